"""From checked files to one immutable mechanism."""
