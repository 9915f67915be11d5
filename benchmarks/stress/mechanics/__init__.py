"""The judge's own mechanics, which shares no equation with the package."""
