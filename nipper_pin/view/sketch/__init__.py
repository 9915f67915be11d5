"""A labelled drawing of a mechanism, made from the model: ``nipper-pin check --drawing FILE``."""

from .draw import drawing_format, write_sketch
from .places import Sketch, sketch

__all__ = ["Sketch", "drawing_format", "sketch", "write_sketch"]
