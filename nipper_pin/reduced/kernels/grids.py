"""The collocation grids that the compiled code is given."""

from __future__ import annotations

from functools import cache

import numpy as np

from ...arrays import FloatArray
from ...chebyshev import evaluate, nodes, prolonged
from .layout import (
    DOUBLE,
    INTEGRAL,
    LEVELS,
    ONCE,
    PROBE,
    PROBE_ONCE,
    PROBE_TWICE,
    PROBES,
    REFINE,
    SIGMA,
    TWICE,
    VALUE,
)


@cache
def grids() -> FloatArray:
    """Nested collocation grids with the operators of the direct engine, padded to the finest one.

    Returns:
        Shape (operators, levels, N, N + 2); see the names in the kernel.
    """
    finest = LEVELS[-1]
    found = np.zeros((SIGMA + 1, len(LEVELS), finest, finest + 2))
    for level, count in enumerate(LEVELS):
        grid = nodes(count)
        # In the middle between two nodes, as the zeros of what an interpolant misses are spaced.
        # Polynomials of three degrees that cancel at one of the probes do not at all of them.
        first, middle = (np.pi * (int((count - 1) / part) + 0.5) / (count - 1) for part in (4, 2))
        probes = 0.5 * (1.0 - np.cos([first, middle, np.pi - first]))
        found[SIGMA, level, 0, :count] = grid.sigma
        found[SIGMA, level, 1, :PROBES] = probes
        operators = [(ONCE, grid.once), (TWICE, grid.twice)]
        operators += zip((VALUE, INTEGRAL, DOUBLE), grid.integrals, strict=True)
        operators += [
            (kind, evaluate(np.eye(count), probes, integrations))
            for integrations, kind in enumerate((PROBE, PROBE_ONCE, PROBE_TWICE))
        ]
        if level:
            operators.append((REFINE, prolonged(np.eye(LEVELS[level - 1]), count)))
        for kind, operator in operators:
            to, start = operator.shape
            found[kind, level, :start, :to] = operator.T
    return found
