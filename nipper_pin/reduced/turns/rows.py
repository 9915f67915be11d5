"""Up to which gap springs stay on the rows of their tables, beyond which no force is known."""

from __future__ import annotations

import math

import numpy as np
from numpy.polynomial import chebyshev

from ...arrays import FloatArray
from ...mechanism import Mechanism, TabulatedSpring
from ...tolerances.mechanics import TABLE_END_OVERRUN
from ..tables import series2d
from ..tables.tables import Domain, Tables

# Places of a cell, and of the gaps of a domain, at which a coordinate is looked at.
_PLACES = 33
_PAIRS = (0, _PLACES - 1), (1, _PLACES)
_OFF = -1.0


def on_rows(mechanism: Mechanism, domain: Domain, tables: Tables) -> FloatArray:
    """Largest gaps up to which all springs are on the rows of their tables.

    Returns:
        By equal parts of the travel, shape (parts,), rather too small than too large: infinite
        where they are on them at all gaps, negative where they are not with the stop closed. No
        parts of a mechanism without such springs.
    """
    cells, count_x = tables.equation.shape[1], len(tables.x)
    parts = cells * (_PLACES - 1) if mechanism.tabulated_springs else 0
    found = np.full(parts, np.inf)
    for spring in mechanism.tabulated_springs:
        coordinate = tables.q[:, :, spring.index].reshape(cells, -1, count_x)
        low, high = _ends(mechanism, spring)
        for side, end in ((coordinate, high), (-coordinate, -low)):
            if end < math.inf:
                found = np.minimum(found, _below(domain, side, end))
    return found


def _ends(mechanism: Mechanism, spring: TabulatedSpring) -> tuple[float, float]:
    """Ends of a table with their slack; infinite where a stop holds the coordinate before them."""
    low, high = spring.characteristic.ends
    slack = TABLE_END_OVERRUN * (high - low)
    own = [stop for stop in mechanism.stops if stop.index == spring.index]
    if any(stop.sense > 0.0 and stop.at >= low - slack for stop in own):
        low = -math.inf
    if any(stop.sense < 0.0 and stop.at <= high + slack for stop in own):
        high = math.inf
    return low - slack, high + slack


def _below(domain: Domain, coordinate: FloatArray, end: float) -> FloatArray:
    """Largest gaps up to which a coordinate is below an end, from it at the nodes of the cells."""
    series = series2d.fit(coordinate)
    _, count_u, count_x = series.shape
    u, gaps = np.linspace(-1.0, 1.0, _PLACES), np.linspace(0.0, domain.high, _PLACES)
    x = domain.places(gaps)
    by_u = chebyshev.chebvander(u, count_u - 1)
    by_x = chebyshev.chebvander(x, count_x - 1).T
    values = by_u @ series @ by_x
    along = _crests(values, series2d.slopes(u, count_u) @ series @ by_x, u, 1)
    across = _crests(values, by_u @ series @ series2d.slopes(x, count_x).T, x, 2)
    # The highest value between two travels: at each gap, and between two gaps.
    lines = np.maximum(values[:, :-1], values[:, 1:]) + along
    between = np.maximum(lines[:, :, :-1], lines[:, :, 1:])
    between += np.maximum(across[:, :-1], across[:, 1:])
    highest = np.concatenate([lines[:, :, :1], between], axis=2).reshape(-1, _PLACES)
    known = np.append([_OFF, *gaps[:-1]], np.inf)
    beyond = np.append(highest > end, np.ones((len(highest), 1), dtype=bool), axis=1)
    return np.asarray(known[beyond.argmax(axis=1)])


def _crests(values: FloatArray, slopes: FloatArray, places: FloatArray, axis: int) -> FloatArray:
    """By how much values between two places exceed those of both, where they rise and fall again.

    Their slope falls evenly between the two, but for a third derivative.
    """
    first, last = (np.take(values, range(*ends), axis) for ends in _PAIRS)
    rises, falls = (np.take(slopes, range(*ends), axis) for ends in _PAIRS)
    bend = np.where((rises > 0.0) & (falls < 0.0), rises - falls, np.inf)
    half = 0.5 * (places[1] - places[0])
    tops = np.maximum(first + half * rises**2 / bend, last + half * falls**2 / bend)
    return np.asarray(tops - np.maximum(first, last))
