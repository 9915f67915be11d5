"""True over stated errors of random machines of the E62 class (measure_stated_errors.py)."""
