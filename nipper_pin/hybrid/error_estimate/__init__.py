"""Stated errors of event times and impulses: local errors, propagated along the run."""
