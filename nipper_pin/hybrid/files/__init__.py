"""Solutions on disk and as a plain document."""
