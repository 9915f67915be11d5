"""Changing single values of a model by their paths, before anything is validated."""

from .dimensions import HEADS, read_dimension
from .overrides import apply_overrides
from .paths import number_at
from .points import Layout, read_layout

__all__ = [
    "HEADS",
    "Layout",
    "apply_overrides",
    "number_at",
    "read_dimension",
    "read_layout",
]
