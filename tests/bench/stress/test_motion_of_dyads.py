"""Where points of linkages are: triangles and lines by hand, and when they count as too flat."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from benchmarks.stress.linkages import freedoms
from benchmarks.stress.linkages.dyads import Growing, crank
from benchmarks.stress.linkages.motion import (
    ANGLES,
    NoAssemblyError,
    Output,
    Pose,
    Rod,
    crossing,
    heading,
    rod_on_line,
    still,
    two_rods,
    unit,
)


def test_angles_and_poses() -> None:
    """Every three degrees of a turn; a point of a body goes along its axes."""
    assert len(ANGLES) == 120
    assert np.degrees(ANGLES[[0, 1, -1]]) == pytest.approx([0.0, 3.0, 357.0])
    found = Pose(still(1.0 + 2.0j), np.full(120, 0.5 * math.pi)).at(3.0 + 4.0j)
    assert found[7] == pytest.approx(-3.0 + 5.0j)
    assert unit(np.array([0.0, 0.5 * math.pi])) == pytest.approx(np.array([1.0, 1.0j]))


def test_pins_of_two_rods() -> None:
    """A triangle of 3, 4 and 5 on either side; its sine is one, and that of a flat one is told."""
    first, second = still(1.0 + 2.0j), still(1.0 + 7.0j)
    for side, x in ((1.0, -2.4), (-1.0, 2.4)):
        found = two_rods(first, 3.0, second, 4.0, side, 0.999)
        assert found[5] == pytest.approx(1.0 + x + 3.8j)
    # Two rods of 5 with their ends 8 apart: at their pin the sine is 24/25.
    second = still(9.0 + 2.0j)
    two_rods(first, 5.0, second, 5.0, 1.0, 0.959)
    for l_first, l_second, least in ((5.0, 5.0, 0.961), (3.0, 4.0, 0.0), (4.0, 4.0, 0.0)):
        with pytest.raises(NoAssemblyError):
            two_rods(first, l_first, second, l_second, 1.0, least)


def test_headings() -> None:
    """Continuous over the turn; a way that is a twentieth of its longest is too short."""
    way = np.cos(2.0 * ANGLES) + 1j * np.sin(2.0 * ANGLES)
    found = heading(still(3.0 + 1.0j), way + 3.0 + 1.0j)
    assert found == pytest.approx(2.0 * ANGLES, abs=1e-12)
    for share, right in ((0.051, True), (0.049, False)):
        size = np.full(120, 2.0)
        size[17] *= share
        if right:
            assert heading(still(0j), size * way) == pytest.approx(2.0 * ANGLES)
        else:
            with pytest.raises(NoAssemblyError):
                heading(still(0j), size * way)


def test_rods_on_lines() -> None:
    """An end three beside the line, a rod of five: four before or behind; its cosine is 0.8."""
    end, at = still(2.0 + 6.0j), 10.0 + 3.0j
    for side, travel in ((1.0, -4.0), (-1.0, -12.0)):
        assert rod_on_line(end, 5.0, at, 0.0, side, 0.79)[3] == pytest.approx(travel)
    upright = rod_on_line(end, 10.0, at, 0.5 * math.pi, 1.0, 0.1)
    assert upright[3] == pytest.approx(3.0 + 6.0)
    with pytest.raises(NoAssemblyError):
        rod_on_line(end, 5.0, at, 0.0, 1.0, 0.81)


def test_lines_that_cross() -> None:
    """From (1, 2) to the right and from (7, -3) upwards they meet after six and five."""
    first, second = still(1.0 + 2.0j), still(7.0 - 3.0j)
    right, up = still(1.0 + 0.0j), still(0.0 + 1.0j)
    found = crossing(first, right, second, up, 0.99)
    assert [x[9] for x in found] == pytest.approx([6.0, 5.0])
    aslant = still(0.8 + 0.6j)
    found = crossing(first, aslant, second, up, 0.79)
    assert [x[9] for x in found] == pytest.approx([7.5, 9.5])
    with pytest.raises(NoAssemblyError):
        crossing(first, aslant, second, up, 0.81)


def test_growing() -> None:
    """A crank about the origin, and what a body is drawn as."""
    found = crank(np.random.default_rng(1), 0.3)
    assert found.least == 0.3
    assert 10.0 <= found.radius <= 40.0
    assert 2.0 <= found.size / found.radius <= 4.0
    assert found.places["A"][30] == pytest.approx(1j * found.radius, abs=1e-12)
    assert found.on == {"crank": ["O", "A"]}
    bar: Any = found.body("crank")
    assert (bar.points, bar.density_kg_m) == ("O A", 1.0)
    found.add("block", "A", found.poses["crank"], 0.25)
    block: Any = found.body("block")
    assert (block.points, block.mass_kg) == ("A", 0.25)


@pytest.mark.parametrize(("old", "choice", "there"), [(0.5, 0.5, "A"), (0.5, 0.7, None),
                                                      (0.01, 0.5, "O")])  # fmt: skip
def test_moving_points(old: float, choice: float, there: str | None) -> None:
    """Points that move by a fifth of the crank, one time in twenty any; else a new one."""
    grown = Growing(20.0, 50.0, 0.1)
    turning = 20.0 * unit(ANGLES)
    grown.places = {"O": still(0j), "A": turning, "B": 0.0999 * turning}
    grown.add("bar", "O B A", Pose(still(0j), ANGLES), 1.0)
    grown.add("block", "A", Pose(turning, ANGLES), 1.0)
    grown.add("halves", "O A", Pose(turning, ANGLES), 1.0)
    grown.halved.add("halves")
    chosen: list[list[str]] = []
    numbers = iter([old, choice])
    places = iter([0.5, -0.25])

    class Rng:
        def choice(self, names: list[str]) -> str:
            chosen.append(list(names))
            return names[0]

        def random(self) -> float:
            return next(numbers)

        def uniform(self, *bounds: float) -> float:
            assert bounds in ((-0.3, 1.0), (-0.4, 0.4))
            return next(places)

    name, point = grown.moving(Rng())  # type: ignore[arg-type]
    assert name == "bar"
    assert chosen[0] == ["bar"]
    if there is None:
        assert point == "P3"
        assert grown.on["bar"] == ["O", "B", "A", "P3"]
        assert grown.places["P3"][0] == pytest.approx(25.0 - 12.5j)
    else:
        assert point == there
        assert chosen[1] == (["O", "B", "A"] if there == "O" else ["A"])


def slider() -> tuple[Output, Rod]:
    """A block on a line through the crank's axis: what moves it gives way to one side only."""
    pin = 20.0 * unit(ANGLES)
    travel = rod_on_line(pin, 100.0, 0j, 0.0, 1.0, 0.1)
    rod = Rod("rod", 100.0, pin, complex)
    return Output("x", travel, False, rod), rod


class Told:
    """A lower or an upper stop at a share of the reach."""

    def __init__(self, lower: bool, share: float) -> None:
        self.lower, self.share = lower, share

    def random(self) -> float:
        return 0.4 if self.lower else 0.6

    def uniform(self, *bounds: float) -> float:
        assert bounds == (0.03, 0.4)
        return self.share


@pytest.mark.parametrize("lower", [True, False])
@pytest.mark.parametrize("step", [1, -1])
@pytest.mark.parametrize("share", [0.03, 0.25, 0.4])
def test_where_a_stop_is_met(lower: bool, step: int, share: float) -> None:
    """At the last of the angles before its place, as the crank turns."""
    output, rod = slider()
    rng: Any = Told(lower, share)
    found = freedoms.struck(rng, output, rod, step)
    assert found is not None
    assert (found.lower, found.longer, found.output) == (lower, lower, output)
    x = output.coordinate if lower else -output.coordinate
    place = x.min() + share * np.ptp(x)
    assert x[found.contact] >= place > x[(found.contact + step) % 120]
    assert found.gap == pytest.approx(x - x[found.contact])


def test_where_no_stop_can_be() -> None:
    """A coordinate that jumps, and a rod that would have to give way in both directions."""
    output, rod = slider()
    rng: Any = Told(True, 0.25)
    jumps = Output("x", np.where(math.pi > ANGLES, 100.0, 0.0), False, rod)
    assert freedoms.struck(rng, jumps, rod, 1) is None
    away = rod.driving + np.where(math.pi > ANGLES, 120.0, 60.0)
    assert freedoms.struck(rng, output, Rod("rod", 100.0, rod.driving, lambda _: away), 1) is None


def test_where_all_stops_are_open() -> None:
    """Where the least of the gaps, in shares of their reach, is largest; a twentieth at least."""
    assert freedoms.open_at([]) == 0
    x, y = np.zeros(120), np.zeros(120)
    x[[5, 9, 20]], y[[5, 9, 20]] = (100.0, 40.0, 10.0), (1.0, 3.0, 10.0)

    def stop(values: np.ndarray, lower: bool, contact: int = 0) -> freedoms.Struck:
        return freedoms.Struck(Output("x", values, False), lower, contact, True)

    assert freedoms.open_at([stop(x, True)]) == 5
    # Shares (1, 0.4, 0.1) and (0.1, 0.3, 1).
    assert freedoms.open_at([stop(x, True), stop(y, True)]) == 9
    assert freedoms.open_at([stop(-x, False), stop(y, True)]) == 9
    assert freedoms.open_at([stop(x, True), stop(y, False)]) is None
    x[[5, 9, 20]] = 0.0
    x[50], x[60] = 1.0, -18.5
    assert freedoms.open_at([stop(x, True)]) == 50
    x[60] = -19.5
    assert freedoms.open_at([stop(x, True)]) is None


def test_largest_second_derivative() -> None:
    """A radius of 20 at twice the speed has four times that, but for what the step leaves."""
    grown = Growing(20.0, 50.0, 0.1)
    grown.places = {"O": still(90.0 + 9.0j), "A": 30.0 * unit(ANGLES),
                    "B": 20.0 * unit(2.0 * ANGLES)}  # fmt: skip
    step = math.radians(3.0)
    exact = 20.0 * 2.0 * (1.0 - math.cos(2.0 * step)) / step**2
    assert freedoms.furthest(grown) == pytest.approx(exact, rel=1e-12)
    assert exact == pytest.approx(80.0, rel=1e-2)
