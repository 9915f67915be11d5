"""A labelled drawing of a mechanism, made from the model: ``nipper-pin check --drawing FILE``."""

from .draw import write_sketch
from .places import sketch

__all__ = ["sketch", "write_sketch"]
