"""Run time against error, and what each part of a run costs."""
