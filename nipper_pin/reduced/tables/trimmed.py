"""Tables without negligible coefficients, and bounds on the errors of the remaining series."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...arrays import FloatArray
from ...tolerances.reduced import TRIMMED_SHARE
from . import series2d
from .tables import Checks, Domain, Tables, residuals


@dataclass(frozen=True, kw_only=True)
class Trimmed:
    """Series as the compiled code reads them.

    Attributes:
        equation: Coefficients of the functions in x'', shape (functions, cells, Nu, Nx).
        gaps: Coefficients of the gaps of the other stops, shape (other stops, cells, Nu, Nx).
        inertia: Coefficients of the inertia at x = 0, shape (cells, Nu).
        residual: Bounds on the errors of the functions, shape (functions,).
        inertia_residual: Relative one of the inertia.
        largest: Largest value of each function, shape (functions,).
        steepest_x: Largest derivative by x, shape (functions,).
        steepest_u: Largest derivative by u, shape (functions,).
    """

    equation: FloatArray
    gaps: FloatArray
    inertia: FloatArray
    residual: FloatArray
    inertia_residual: float
    largest: FloatArray
    steepest_x: FloatArray
    steepest_u: FloatArray


def trimmed(
    points: Checks,
    domain: Domain,
    tables: Tables,
    weights: FloatArray,
    tolerance: float,
    least: tuple[int, int] = (2, 2),
) -> Trimmed:
    """Leave out the highest degrees while their weighted sums stay below a share of the tolerance.

    Args:
        points: The functions at points off the grid, for the errors.
        tables: The tables, resolved.
        weights: Weight of an error of each function, shape (functions,).
        tolerance: Relative accuracy of the tables.
        least: Least orders that are kept, by travel and by x.
    """
    count_u, count_x = series2d.needed(tables.equation, weights, TRIMMED_SHARE * tolerance)
    count_u, count_x = max(count_u, least[0]), max(count_x, least[1])
    equation = np.ascontiguousarray(tables.equation[:, :, :count_u, :count_x])
    inertia = np.ascontiguousarray(tables.inertia[:, :count_u])
    residual, inertia_residual = residuals(points, domain, equation, inertia)
    width = domain.travel / equation.shape[1]
    largest, steep_u, steep_x = series2d.largest(equation)
    return Trimmed(
        equation=equation,
        gaps=np.ascontiguousarray(tables.gaps[:, :, :count_u, :count_x]),
        inertia=inertia,
        residual=residual,
        inertia_residual=inertia_residual,
        largest=largest,
        steepest_x=2.0 / (domain.high - domain.low) * steep_x,
        steepest_u=2.0 / width * steep_u,
    )
