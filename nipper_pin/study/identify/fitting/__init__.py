"""Least squares inside bounds, what the data determine, and how good a fit is."""
