"""Figures of a sweep: main effects and level lines."""

from .columns import Parameter, Quantity
from .level_lines import cell_means, level_lines
from .main_effects import main_effects

__all__ = [
    "Parameter",
    "Quantity",
    "cell_means",
    "level_lines",
    "main_effects",
]
