"""Random linkages, of a crank and dyads."""

from .family import linkage, write_linkage
from .random_linkage import random_linkage

__all__ = ["linkage", "random_linkage", "write_linkage"]
