"""Figures of a sweep: main effects, parallel coordinates and level lines."""

from .columns import Parameter, Quantity
from .level_lines import cell_means, level_lines
from .main_effects import main_effects
from .parallel import parallel_coordinates

__all__ = [
    "Parameter",
    "Quantity",
    "cell_means",
    "level_lines",
    "main_effects",
    "parallel_coordinates",
]
