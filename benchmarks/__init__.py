"""Measurements of the package: run time, accuracy, stress campaigns, other simulators."""
