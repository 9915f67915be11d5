"""Parts of the reduced engine that need no machine: what they say, and bounds on their errors."""

from __future__ import annotations

from dataclasses import fields, replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from numpy.polynomial import chebyshev

from nipper_pin.errors import SimulationError
from nipper_pin.reduced import arrival
from nipper_pin.reduced.arrival import Arrival
from nipper_pin.reduced.model import ReducedModel

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
