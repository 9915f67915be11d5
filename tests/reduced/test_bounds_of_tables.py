"""Tables of the reduced engine: what they say, what they refuse, and bounds on their errors."""

from __future__ import annotations

from dataclasses import fields, replace
from typing import Any

import numpy as np
import pytest
from numpy.polynomial import chebyshev
from small_machines import SHAFT, frame, hinge, link, machine, slide

from nipper_pin import InputError, Mechanism, SimulationError
from nipper_pin.arrays import FloatArray
from nipper_pin.dynamics import ShaftMotion, System
from nipper_pin.reduced import ReducedModel, build
from nipper_pin.reduced.kernels import kernel, layout
from nipper_pin.reduced.tables import arrival
from nipper_pin.reduced.tables import tables as tables_module
from nipper_pin.reduced.tables.functions import Samples

ARRAYS = ("equation", "gaps", "inertia", "residual", "largest", "steepest_x", "steepest_u",
          "stiffness", "preload")  # fmt: skip


def test_models_are_told_and_compared_without_their_tables(e62: Mechanism) -> None:
    """A line of plain values; equal if these are, whatever the arrays hold."""
    one = build(e62, turn=False)
    assert "array" not in repr(one)
    assert "arrival" not in repr(one)
    plain = {item.name for item in fields(ReducedModel)} - {*ARRAYS, "arrival"}
    for name in plain:
        assert f"{name}={getattr(one, name)!r}" in repr(one)
        assert one != replace(one, **{name: "other"})
    for name in ARRAYS:
        assert f" {name}=" not in repr(one), name
        assert one == replace(one, **{name: 2.0 * getattr(one, name)})
    assert repr(one.arrival) == "Arrival(why='the rest of the turn was not sampled', asked=True)"


def samples(equation: list[FloatArray], inertia: FloatArray | None = None) -> Samples:
    """Functions at points, and nothing else of them."""
    none = np.empty(0)
    return Samples(none, np.array(equation), none, none, none if inertia is None else inertia)


class Sampler:
    """Functions of the travel alone, on a grid of travels and one gap."""

    def __init__(self, *functions: Any) -> None:
        self.functions = functions
        self.travels: list[Any] = []

    def grid(self, u: Any, x: Any) -> Any:
        assert x.tolist() == [0.0]
        return u[:, None, None] * np.ones((1, 1, 2))

    def at(self, u: Any, x: Any, q: Any) -> Any:
        assert (x == 0.0).all()
        assert (q[:, 0] == u).all()
        self.travels.append(u)
        return samples([item(u) for item in self.functions])


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("opening", [0.3, 2.5])
def test_functions_along_the_closed_stop(sign: float, opening: float) -> None:
    """Series that meet the functions within their bounds, which know no sign."""
    functions = (
        lambda u: sign * np.exp(6.0 * u), lambda u: sign * np.cos(40.0 * u), lambda u: 0.0 * u,
    )  # fmt: skip
    sampler: Any = Sampler(*functions)
    series, bounds = arrival._clamping(sampler, opening)
    cells = series.shape[1]
    assert cells == max(1, int(np.ceil(opening / arrival.CELL_RAD)))
    width = opening / cells
    assert (np.concatenate(sampler.travels) > 0.0).all()
    assert (np.concatenate(sampler.travels) < opening).all()
    between = np.linspace(-0.99, 0.99, 41)
    for row, function in enumerate(functions):
        for cell in range(cells):
            true = function(width * (cell + 0.5 * (between + 1.0)))
            found = chebyshev.chebval(between, series[row, cell])
            assert np.abs(found - true).max() <= bounds[row]
        tail = max(np.abs(series[row, cell, -2:]).sum() for cell in range(cells))
        values = np.abs(function(np.concatenate(sampler.travels))).max()
        rounded = 4.0 * np.finfo(float).eps * values
        assert bounds[row] == pytest.approx(2.0 * tail + rounded, rel=1e-9, abs=1e-300)
    assert bounds[2] == 0.0


def test_turns_that_the_waiting_stop_does_not_open(e62: Mechanism) -> None:
    """Its collision has to throw the other one open, and it has to approach before."""
    system = System(e62, ShaftMotion(e62, 1.0, e62.cylinder.angle_at_touch_rad))
    stop = e62.stop("steeve")
    opening = arrival.Opening(0.5, np.zeros((1, len(e62.joints))))

    class Rates:
        def rates(self, _travel: FloatArray, q: FloatArray) -> tuple[FloatArray, FloatArray]:
            thrown, approached = np.full_like(q, 9.0), np.full_like(q, 9.0)
            thrown[0, stop.index], approached[0, stop.index] = throw, approach
            return thrown, approached

    sampler: Any = Rates()
    for throw, approach in ((0.0, -1.0), (-2.0, -1.0), (2.0, 0.0), (2.0, 1.0)):
        waiting = arrival.Waiting(stop, sampler, np.zeros(4), 1.0)
        with pytest.raises(SimulationError, match="'steeve' does not open 'jaw' by its") as caught:
            arrival.arrival(system, sampler, opening, waiting, 1e-9)
        assert caught.value.evidence == {"throw": throw, "approach": approach}


def test_stops_that_cannot_move_freely() -> None:
    """A coordinate that the closures and drives determine is none to sample over."""
    parts = [
        link("crank"), hinge("shaft", "frame", "crank"),
        link("rod"), hinge("pin", "crank", "rod", (0.1, 0.0)), frame("end", "rod", (0.3, 0.0)),
        link("rocker"), hinge("pivot", "frame", "rocker", (0.4, -0.3)),
        frame("top", "rocker", (0.0, 0.3)), link("sled"), slide("rail", "frame", "sled"),
    ]  # fmt: skip
    four_bar = machine(
        parts, 2,
        closures={"joint": {"frame_a": "end", "frame_b": "top"}},
        drives={"shaft": {"joint": "shaft", "law": "constant_speed", "ratio": 1.0, **SHAFT}},
        stops={"rocker": {"joint": "pivot", "restitution": 0.2},
               "sled": {"joint": "rail", "restitution": 0.2}},
        phases=[{"number": 1, "name": "waiting", "closed": ["sled"]}],
    )  # fmt: skip
    with pytest.raises(InputError, match="stop 'rocker' cannot move freely") as caught:
        build(four_bar)
    assert caught.value.evidence == {"stop": "rocker"}


@pytest.mark.parametrize("cells", [1, 3, 4000])
def test_errors_of_series_at_points_off_the_grid(cells: int) -> None:
    """Twice the largest difference, and round-off: of every function, and relative of inertia."""
    domain = tables_module.Domain(travel=2.0, low=-1.0, high=3.0, begin=-2.0)
    width = 2.0 / cells
    asked: list[Any] = []

    class True_:  # noqa: N801
        """c + 0.5 x + 3 (u - 2), one that is always 7, and an inertia of 5 (1 + u)."""

        def at(self, past: Any, x: Any, q: Any) -> Any:
            assert (past >= -2.0).all()
            assert (past <= 0.0).all()
            asked.append((past, x, q))
            values = [1.0 + 0.5 * x + 3.0 * past, np.full_like(x, 7.0)]
            return samples(values, 5.0 * (3.0 + past))

    begins = width * np.arange(cells) - 2.0
    equation = np.zeros((2, cells, 2, 2))
    equation[0, :, 0, 0] = 1.0 + 0.5 * 1.0 + 3.0 * (begins + 0.5 * width) + 1e-3
    equation[0, :, 0, 1] = 0.5 * 2.0
    equation[0, :, 1, 0] = 3.0 * 0.5 * width
    equation[1, :, 0, 0] = 7.0 - 2e-4
    inertia = np.zeros((cells, 2))
    inertia[:, 0] = 5.0 * (3.0 + begins + 0.5 * width) * (1.0 + 1e-5)
    inertia[:, 1] = 5.0 * 0.5 * width * (1.0 + 1e-5)
    grid = np.linspace(0.0, 2.0, 5)
    none = np.empty(0)
    q = np.arange(15.0).reshape(5, 3, 1)
    tables = tables_module.Tables(grid, np.array([-1.0, 0.0, 3.0]), q, none, none, none, none)
    sampler: Any = True_()
    points = tables_module.checks(sampler, domain, tables)
    bounds, relative = tables_module.residuals(points, domain, equation, inertia)
    assert bounds == pytest.approx([2e-3, 4e-4], rel=1e-9)
    assert relative == pytest.approx(2e-5, rel=1e-6)
    (past, x, guess), (again, zero, rest) = asked
    assert (past == again).all()
    assert (zero == 0.0).all()
    # Ends of the domain and the place of collisions are among the points.
    assert [(past == end).sum() for end in (-2.0, 0.0)] == [2, 2]
    assert [(x == place).sum() for place in (0.0, 3.0)] == [3, 1]
    assert x.min() >= -1.0
    assert x.max() <= 3.0
    # Guesses come from the grid point above, those at rest from the column of x = 0.
    row = np.searchsorted(grid, past + 2.0 - 1e-15).clip(0, 4)
    column = np.searchsorted([-1.0, 0.0, 3.0], x).clip(0, 2)
    assert (guess[:, 0] == 3 * row + column).mean() > 0.99
    assert (rest[:, 0] == 3 * row + 1).mean() > 0.99


@pytest.mark.parametrize("worst", ["time", "amplitude", "first", "second"])
def test_the_worst_relative_error_of_a_transition(worst: str) -> None:
    """Of its duration, its amplitude and the times of its first two rebounds."""
    table = np.zeros((20, 5))
    table[layout.TIME, 2], table[layout.AMPLITUDE, 0] = 0.03, 2e-3
    table[layout.REBOUND, :3] = 0.02, 0.01, 0.004
    errors = {"time": 1e-9, "amplitude": 2e-9, "first": 3e-9, "second": 4e-9} | {worst: 7e-9}
    table[layout.AMPLITUDE_ERROR, 0] = 2e-3 * errors["amplitude"]
    table[layout.REBOUND_ERROR, :2] = 0.02 * errors["first"], 0.01 * errors["second"]
    found = kernel._summary(table, layout.AT_REST, 3, 0.04, 0.04 * errors["time"])
    assert found == pytest.approx((0.04, 0.04 * errors["time"], 0.75, 7e-9), rel=1e-12)
