"""Tables of the reduced engine: what they say, what they refuse, and bounds on their errors."""

from __future__ import annotations

import math
from dataclasses import fields, replace
from typing import Any

import numpy as np
import pytest
from numpy.polynomial import chebyshev
from small_machines import SHAFT, frame, hinge, link, machine, slide
from written_tables import with_numbers

from nipper_pin import ConvergenceError, InputError, Mechanism
from nipper_pin.arrays import FloatArray
from nipper_pin.reduced import ReducedModel, build
from nipper_pin.reduced.tables import series2d
from nipper_pin.reduced.tables.functions import Samples
from nipper_pin.reduced.tables.tables import Domain, chart_over, misfit, resolved


def test_models_are_told_without_their_tables(e62: Mechanism) -> None:
    """A line of plain values, and how far the tables reach."""
    one = build(e62)
    hidden = {"numbers", "charts", "arrival"}
    for item in fields(ReducedModel):
        assert (f"{item.name}={getattr(one, item.name)!r}" in repr(one)) is (
            item.name not in hidden
        )
    assert "array" not in repr(one)
    other = replace(one, charts=with_numbers(one.charts, high=0.5))
    assert (other.gap_max, other.travel_rad) == (0.5, one.travel_rad)
    assert repr(one.arrival) == "Arrival(why='', asked=True)"


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


EPS = float(np.finfo(float).eps)


@pytest.mark.parametrize(
    ("tolerance", "expected"),
    [(0.05, (5, 6)), (0.15, (4, 6)), (0.35, (4, 4)), (3.5, (2, 2)), (1e9, (2, 2))],
)
def test_orders_that_are_needed(tolerance: float, expected: tuple[int, int]) -> None:
    """What is dropped is the sum of all orders above, weighted, of the worst function and cell."""
    given = np.zeros((2, 2, 6, 7))
    given[0, 0, 0, 0] = 9.0
    given[0, 1, 3, 0], given[1, 0, 4, 0] = 3.0, 0.05
    given[1, 1, 0, 5], given[0, 0, 0, 3] = -0.15, 1.0
    assert series2d.needed(given, np.array([1.0, 2.0]), tolerance) == expected


class Known:
    """Two functions, the gap of another stop and an inertia, of travel and coordinate."""

    def __init__(self, bent: float = 0.3, steep: float = 1.0) -> None:
        self.bent, self.steep = bent, steep
        self.asked: list[FloatArray] = []
        self.sampled = 0

    def grid(self, u: Any, x: Any) -> Any:
        self.asked.append(u)
        self.sampled += len(u) * len(x)
        return np.array([[[at, place] for place in x] for at in u])

    def values(self, u: Any, x: Any) -> Any:
        return np.array([np.sin(self.steep * u) * np.exp(0.2 * x), 40.0 + self.bent * x**3 + u])

    def at(self, u: Any, x: Any, q: Any) -> Samples:
        # Configurations that are given have to be near.
        assert np.abs(q - np.stack([u, x], axis=-1)).max() < 1.5
        inertia = 2.0 + np.cos(u) * (1.0 + 0.1 * x)
        gaps = np.array([u - 7.0 * x, np.full_like(u, -7.0), np.ones_like(u)])
        return Samples(self.values(u, x), gaps, inertia)


def test_samples_of_a_domain() -> None:
    """Grid, configurations, functions, gaps, and the inertia at x = 0; from the touch outwards."""
    known = Known()
    domain = Domain(1.3, -0.1, 0.5)
    tables = resolved(known.grid, known.at, domain, np.array([1.0, 1.0]), 1e-9)
    assert known.sampled == 3 * 16 * 8
    # Two functions of the equation, a gap with its slopes, and the inertia.
    assert (tables.functions, tables.series.shape) == (2, (6, 3, 16, 8))
    assert (np.diff(tables.u) > 0.0).all()
    assert (np.diff(tables.x) > 0.0).all()
    assert 0.0 < tables.u[0] < tables.u[-1] < 1.3
    assert -0.1 < tables.x[0] < tables.x[-1] < 0.5
    np.testing.assert_allclose(tables.q[:, 2, 0], tables.u, rtol=1e-14)
    np.testing.assert_allclose(tables.q[5, :, 1], tables.x, rtol=1e-14)
    first = np.abs(known.asked[0])
    assert (np.diff(first) > 0.0).all()
    for cell in range(3):
        for place in (-0.8, 0.5):
            u = 1.3 / 3.0 * (cell + 0.5 + 0.5 * place)
            for x in (-0.05, 0.4):
                across = (2.0 * x - 0.4) / 0.6
                assert domain.places(np.array([x])) == pytest.approx([across])
                found = [chebyshev.chebval2d(place, across, row[cell]) for row in tables.series]
                assert found[:2] == pytest.approx(known.values(u, x), rel=1e-10)
                assert found[2:5] == pytest.approx([u - 7.0 * x, -7.0, 1.0], abs=1e-12)
                assert found[5] == pytest.approx(2.0 + math.cos(u) * (1.0 + 0.1 * x), rel=1e-12)


@pytest.mark.parametrize(
    ("known", "domain", "shape"),
    [
        (Known(), Domain(0.5, -0.1, 0.5), (1, 8)),
        (Known(steep=20.0), Domain(0.5, -0.1, 0.5), (2, 8)),
        (Known(), Domain(0.5, -0.1, 2.0), (1, 16)),
        (Known(steep=20.0), Domain(0.5, -0.1, 2.0), (2, 16)),
    ],
)
def test_what_is_refined(known: Known, domain: Domain, shape: tuple[int, int]) -> None:
    """Cells for what changes fast along the travel, orders for what changes across; not both."""
    tables = resolved(known.grid, known.at, domain, np.ones(2), 1e-9)
    assert (tables.series.shape[1], tables.series.shape[3]) == shape
    assert max(series2d.tails(tables.series[:2], np.ones(2))) <= 1e-9
    before = 16 * 8 if shape != (1, 8) else 0
    assert known.sampled == before + 16 * shape[0] * shape[1]


def test_functions_that_no_refinement_resolves() -> None:
    """A corner: refused, with the tails, the tolerance and what was sampled."""

    class Corner(Known):
        def values(self, u: Any, x: Any) -> Any:
            return np.array([np.abs(u - 0.217) ** 0.1, 1.0 + 0.0 * x])

    with pytest.raises(ConvergenceError, match=r"unresolved: 0\.\d+ along the travel,") as caught:
        resolved(Corner().grid, Corner().at, Domain(0.5, -0.1, 0.5), np.ones(2), 1e-9)
    evidence = caught.value.evidence
    assert evidence["tolerance"] == 1e-9
    assert evidence["residual"] > 1e-3
    # One cell, then two, which gain too little to go on.
    assert evidence["iterations"] == 16 * 8 * 3


def test_residuals_are_twice_the_largest_error_at_the_checks() -> None:
    """Errors that are planted into single cells are found, each in its own function."""
    known, domain = Known(), Domain(1.3, -0.1, 0.5)
    tables = resolved(known.grid, known.at, domain, np.ones(2), 1e-12)

    def found_of(series: FloatArray) -> FloatArray:
        return misfit(known.at, domain, tables, series)[0]

    largest = np.array([1.2, 43.0, 5.0, 7.0, 1.0, 3.1])
    assert (found_of(tables.series) <= 200.0 * EPS * largest).all()
    wrong = tables.series.copy()
    wrong[0, 2, 0, 0] += 1e-4
    wrong[1, 0, 0, 0] -= 3e-4
    np.testing.assert_allclose(found_of(wrong)[:2], [2e-4, 6e-4], rtol=1e-6)
    # An error that grows towards the edges: they are among the points that are checked.
    wrong = tables.series.copy()
    wrong[0, 0, 15, 0] += 1e-4
    wrong[1, 2, 0, 7] += 1e-4
    found = found_of(wrong)
    assert found[0] == pytest.approx(2e-4, rel=1e-6)
    assert 1.5e-4 <= found[1] <= 2.0001e-4
    # Lower orders alone are evaluated in the same places.
    assert (found_of(tables.series[:, :, :8, :6]) < 1e-6).all()


@pytest.mark.parametrize(("bent", "least", "most"), [(0.0, 0.0, 1e-9), (1e-3, 1e-6, 1e-4)])
def test_the_error_of_the_inertia_is_known(bent: float, least: float, most: float) -> None:
    """By itself; of a corner that its series round off too, which are as fine as the functions."""

    class Heavy(Known):
        def at(self, u: Any, x: Any, q: Any) -> Samples:
            found = super().at(u, x, q)
            return replace(found, inertia=found.inertia + bent * np.abs(u - 0.217))

    domain = Domain(1.3, -0.1, 0.5)
    chart = chart_over(Heavy().grid, Heavy().at, domain, np.ones(2), 1e-9)
    assert least <= chart.inertia_error <= most
    u = np.linspace(0.0, 1.3 / 3.0, 501)
    closed = domain.places(np.zeros_like(u))
    series = chebyshev.chebval2d(2.0 * u / (1.3 / 3.0) - 1.0, closed, chart.series[-1, 0])
    true = 2.0 + np.cos(u) + bent * np.abs(u - 0.217)
    assert (np.abs(series / true - 1.0) <= chart.inertia_error).all()


class Noisy:
    """One smooth function of (u, x) with noise of a given size: no series becomes finer than it."""

    def __init__(self, noise: float) -> None:
        self.noise = noise

    def grid(self, u: Any, x: Any) -> Any:
        return np.zeros((len(u), len(x), 1))

    def at(self, u: Any, x: Any, _q: Any) -> Samples:
        random = np.random.default_rng(len(u))
        value = np.sin(u) * np.cos(x) + self.noise * random.uniform(-1.0, 1.0, len(u))
        return Samples(value[None], np.zeros((0, len(u))), np.ones(len(u)))


@pytest.mark.parametrize("tolerance", [1e-8, 1e-4, 1e-3])
def test_noise_of_samples_is_accepted_up_to_the_root_of_the_tolerance(tolerance: float) -> None:
    """Where no refinement helps any more, half of the digits that were asked for have to be there.

    A tail sums some fifty coefficients of the noise, each of a tenth of it: between one and ten
    times the noise.
    """
    domain, root = Domain(1.0, -0.1, 1.0), tolerance**0.5
    one, other = Noisy(0.05 * root), Noisy(2.0 * root)
    tables = resolved(one.grid, one.at, domain, np.ones(1), tolerance)
    assert tolerance < max(series2d.tails(tables.series[:1], np.ones(1))) <= root
    with pytest.raises(ConvergenceError, match="too rough") as caught:
        resolved(other.grid, other.at, domain, np.ones(1), tolerance)
    assert root < caught.value.evidence["residual"] < 40.0 * root


def test_tails_are_the_worst_of_all_functions_and_cells() -> None:
    """The last two orders of each function and cell are added up; the largest sum counts.

    Sums over functions or cells, or without the weights, would be other numbers of this array.
    """
    coefficients = np.zeros((2, 3, 4, 5))
    coefficients[0, 1, 3, 0], coefficients[0, 1, 2, 1] = 2.0, -3.0
    coefficients[0, 2, 3, 2] = 4.0
    coefficients[1, 0, 0, 4], coefficients[1, 0, 1, 3] = -7.0, 1.0
    coefficients[1, 2, 0, 4], coefficients[0, 0, 0, 3] = 6.0, 10.0
    coefficients[1, 1, 0, 0] = 1e3
    by_u, by_x = series2d.tails(coefficients, np.array([1.0, 2.0]))
    assert by_u == 5.0
    assert by_x == 16.0
