"""Closed stops after an event, and the limits of bounce series."""
