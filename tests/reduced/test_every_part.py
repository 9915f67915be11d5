"""Parts of the reduced engine that need no machine: what they say, and bounds on their errors."""

from __future__ import annotations

from dataclasses import fields, replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from numpy.polynomial import chebyshev

from nipper_pin.errors import InputError, SimulationError
from nipper_pin.reduced import sampling
from nipper_pin.reduced.kernels import kernel, layout
from nipper_pin.reduced.model import ReducedModel
from nipper_pin.reduced.tables import arrival
from nipper_pin.reduced.tables import tables as tables_module
from nipper_pin.reduced.tables.arrival import Arrival

ARRAYS = ("equation", "gaps", "inertia", "residual", "largest", "steepest_x", "steepest_u",
          "stiffness", "preload")  # fmt: skip


def made(scale: float) -> ReducedModel:
    """A model whose plain values are always the same."""
    given: dict[str, Any] = {item.name: item.name for item in fields(ReducedModel)}
    given |= {name: scale * np.arange(3.0) for name in ARRAYS}
    given["arrival"] = Arrival(tables=np.arange(3.0), turn=np.arange(4.0), why=str(scale))  # type: ignore[arg-type]
    return ReducedModel(**given)


def test_models_are_told_and_compared_without_their_tables() -> None:
    """A line of plain values; equal if these are, whatever the arrays hold."""
    one = made(1.0)
    text = repr(one)
    for name in ARRAYS:
        assert f" {name}=" not in text, name
    assert "array" not in text
    assert "arrival" not in text
    plain = {item.name for item in fields(ReducedModel)} - {*ARRAYS, "arrival"}
    for name in plain:
        assert f"{name}='{name}'" in text
        assert one != replace(one, **{name: "other"})
    assert one == made(2.0)
    assert repr(one.arrival) == "Arrival(why='1.0', asked=True)"


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
        return SimpleNamespace(equation=np.array([item(u) for item in self.functions]))


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


@pytest.mark.parametrize(
    ("gaps", "right"),
    [
        # From y = -1 to y = 1 the gap grows, and is open from y = 0 on.
        ([[-1.0, 0.5, 1.0], [-0.5, 1.0, 2.0]], True),
        ([[-1.0, 0.5, 0.5], [-0.5, 1.0, 2.0]], False),
        ([[-1.0, 0.5, 1.0], [-0.5, 1.0, 0.75]], False),
        ([[-1.0, 0.0, 1.0], [-0.5, 1.0, 2.0]], False),
        ([[-3.0, -2.0, -1.0], [-0.5, 1.0, 2.0]], False),
    ],
)
def test_turns_in_which_the_stop_can_close(gaps: Any, right: bool) -> None:
    mechanism: Any = SimpleNamespace(
        transition_stop="jaw", stop=lambda name: SimpleNamespace(index={"jaw": 1}[name])
    )
    q = np.full((2, 3, 2), np.nan)
    q[:, :, 1] = gaps
    tables: Any = SimpleNamespace(q=q, x=np.array([-1.0, 0.0, 1.0]))
    if right:
        arrival._check_open(mechanism, tables)
        return
    with pytest.raises(SimulationError, match="stop 'jaw' can close between its opening and"):
        arrival._check_open(mechanism, tables)


def test_turns_that_the_waiting_stop_does_not_open() -> None:
    """Its collision has to throw the other one open, and it has to approach before."""
    system: Any = SimpleNamespace(mechanism=SimpleNamespace(transition_stop="jaw"))
    stop: Any = SimpleNamespace(name="lift", index=1)
    opening: Any = SimpleNamespace(travel=0.5, q=np.zeros((1, 2)))
    for throw, approach in ((0.0, -1.0), (-2.0, -1.0), (2.0, 0.0), (2.0, 1.0)):
        rates = np.array([[9.0, throw]]), np.array([[9.0, approach]])
        sampler: Any = SimpleNamespace(rates=lambda travel, q: rates)  # noqa: B023, ARG005
        waiting = arrival.Waiting(stop, sampler, np.zeros(4), 1.0)
        with pytest.raises(SimulationError, match="'lift' does not open 'jaw' by its") as caught:
            arrival.arrival(system, sampler, opening, waiting, 1e-9)
        assert caught.value.evidence == {"throw": throw, "approach": approach}


def test_stops_that_cannot_move_freely(monkeypatch: pytest.MonkeyPatch) -> None:
    """A coordinate that the closures and drives determine is none to sample over."""
    asked: list[Any] = []
    units = np.array([1.0, 0.5, 1.0])
    jacobian = np.array([[1.0, 2.0, 3.0]])
    body = SimpleNamespace(nv=3, units=units, closures=lambda _: (None, jacobian))
    system: Any = SimpleNamespace(driven=np.array([2]), body=body)

    def partition(jacobian: Any, driven: Any, more: Any) -> Any:
        asked.append((jacobian.tolist(), driven, more))
        return SimpleNamespace(dependent=[1])

    monkeypatch.setattr(sampling, "partition", partition)
    assert sampling._split(system, 0, "jaw").dependent == [1]
    assert asked == [([1.0, 1.0, 3.0], [2], [0])]
    with pytest.raises(InputError, match="stop 'jaw' cannot move freely") as caught:
        sampling._split(system, 1, "jaw")
    assert caught.value.evidence == {"stop": "jaw"}


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
            return SimpleNamespace(
                equation=np.array([1.0 + 0.5 * x + 3.0 * past, np.full_like(x, 7.0)]),
                inertia=5.0 * (3.0 + past),
            )

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
    tables: Any = SimpleNamespace(
        u=grid, x=np.array([-1.0, 0.0, 3.0]), q=np.arange(15.0).reshape(5, 3, 1)
    )
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
