"""One run: its tables, plots and files."""
