"""Stops that are adjusted: where they are closed follows from their adjustment.

A module has the table of the model file that a place is found from. A new one is a module here,
named like the law, or a class in a user's own program that `register_stop` makes known.
"""

from ..files.law_tables import StopTable
from ..files.register import register_stop

__all__ = ["StopTable", "register_stop"]
