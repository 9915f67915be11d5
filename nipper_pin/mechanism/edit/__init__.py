"""Changing single values of a model by their paths, before anything is validated."""

from .dimensions import HEADS, read_dimension
from .layout import Layout, read_layout
from .overrides import apply_overrides
from .toml_paths import number_at

__all__ = [
    "HEADS",
    "Layout",
    "apply_overrides",
    "number_at",
    "read_dimension",
    "read_layout",
]
