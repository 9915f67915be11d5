"""Run time against error, and the run time of each part."""
