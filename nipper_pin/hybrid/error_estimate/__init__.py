"""How far event times and impulses may be off: local errors, carried along the run."""
