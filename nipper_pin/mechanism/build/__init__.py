"""From checked files to one immutable mechanism; what can be none is refused by `ModelError`."""
