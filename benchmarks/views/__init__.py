"""Reports and files of what was measured."""
