"""Random linkages, of a crank and dyads."""

from .random_linkage import linkage, random_linkage, write_linkage

__all__ = ["linkage", "random_linkage", "write_linkage"]
