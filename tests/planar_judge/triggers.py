"""What ends a step: a gap or a force that falls through zero, or a row of a spring's table."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from .dynamics import Dynamics
from .gauss import Step, integrated, rule, values_between
from .machine import Stop
from .roots import first_fall

Array = np.ndarray
# Share of a table's length within which a motion stands on a row.
_ON_ROW = 1e-12


class State(NamedTuple):
    """Time, coordinates, rates, closed stops, and gap and rate of every open one."""

    t: float
    q: Array
    v: Array
    closed: frozenset[str]
    gaps: dict[str, tuple[float, float]]


class Trigger(NamedTuple):
    """What ends a step early, its place on it, and its value and slope at the end of a step."""

    kind: str
    stop: str
    place: float
    residual: Callable[[Step], tuple[float, float]]


def falls(dynamics: Dynamics, state: State, shut: Sequence[Stop], done: Step) -> list[Trigger]:
    """All falls of gaps and forces through zero on a step, and all rows that it crosses."""
    found = []
    for stop in dynamics.machine.stops:
        if stop.name in state.closed:
            found.append(_letting_go(dynamics, stop, shut, done))
        else:
            found.append(_closing(dynamics, state, stop, done))
    found += _rows(dynamics, state, done)
    return [item for item in found if item is not None]


def coordinate(dynamics: Dynamics, number: int, q: Array, v: Array) -> tuple[Array, Array]:
    """Values and rates of a coordinate at K states."""
    rows = dynamics.evaluate(q, v)
    row = dynamics.geometry.constraints + number
    return rows.value[:, row], np.einsum("ki,ki->k", rows.jacobian[:, row], v)


def gap_after(dynamics: Dynamics, state: State, stop: Stop, done: Step) -> tuple[float, float]:
    """Gap and rate at the end of a step, integrated, so that small ones keep their digits."""
    gap, rate = state.gaps[stop.name]
    once, twice = integrated(_gap_accelerations(dynamics, stop, done), np.array([1.0]))
    h = done.h
    return gap + h * rate + h * h * float(twice[0]), rate + h * float(once[0])


def _gap_accelerations(dynamics: Dynamics, stop: Stop, done: Step) -> Array:
    rows = dynamics.evaluate(done.q, done.v)
    row = dynamics.stop_rows[stop.name]
    second = np.einsum("ki,ki->k", rows.jacobian[:, row], done.a) + rows.bias[:, row]
    return np.asarray(stop.sense * second)


def _closing(dynamics: Dynamics, state: State, stop: Stop, done: Step) -> Trigger | None:
    """Fall of a gap; a zero at the start is divided out."""
    gap, rate = state.gaps[stop.name]
    second, h = _gap_accelerations(dynamics, stop, done), done.h

    def height(sigma: Array) -> Array:
        twice = h * integrated(second, sigma)[1]
        if gap != 0.0:
            return gap + h * sigma * (rate + sigma * twice)
        return rate + sigma * twice if rate != 0.0 else twice

    def residual(other: Step) -> tuple[float, float]:
        return gap_after(dynamics, state, stop, other)

    place = first_fall(height, 1e-9 if gap == rate == 0.0 else 0.0)
    return None if place is None else Trigger("gap", stop.name, place, residual)


def _letting_go(dynamics: Dynamics, stop: Stop, shut: Sequence[Stop], done: Step) -> Trigger | None:
    """Fall of a force."""
    column = len(dynamics.base) + list(shut).index(stop)

    def forces(t: Array, q: Array, v: Array) -> Array:
        found = dynamics.accelerate(t, q, v, shut).multipliers
        return np.asarray(stop.sense * found[:, column])

    la = forces(done.t0 + done.h * rule(len(done.a)).nodes, done.q, done.v)

    def residual(other: Step) -> tuple[float, float]:
        t = np.array([other.t0 + other.h])
        force = forces(t, other.q_end[None], other.v_end[None])
        near = np.array([1.0, 1.0 - 1e-4]) * other.h / done.h
        ahead = values_between(la, near)
        return float(force[0]), float((ahead[0] - ahead[1]) / (1e-4 * other.h))

    place = first_fall(lambda sigma: values_between(la, sigma))
    return None if place is None else Trigger("force", stop.name, place, residual)


def _rows(dynamics: Dynamics, state: State, done: Step) -> list[Trigger]:
    """Rows of spring tables that are crossed: the force has another curvature behind them."""
    found = []
    for spring in dynamics.machine.springs:
        for row in () if spring.table is None else spring.table.x[1:-1]:
            (start,), _ = coordinate(dynamics, spring.coordinate, state.q[None], state.v[None])
            values, _ = coordinate(dynamics, spring.coordinate, done.q, done.v)
            if abs(start - row) <= _ON_ROW * np.ptp(spring.table.x):
                continue
            side = 1.0 if start > row else -1.0

            def residual(
                other: Step, number: int = spring.coordinate, row: float = row, side: float = side
            ) -> tuple[float, float]:
                (x,), (rate,) = coordinate(dynamics, number, other.q_end[None], other.v_end[None])
                return side * float(x - row), side * float(rate)

            def distance(
                sigma: Array, values: Array = values, row: float = row, side: float = side
            ) -> Array:
                return side * (values_between(values, sigma) - row)

            place = first_fall(distance)
            if place:
                found.append(Trigger("row", "", place, residual))
    return found
