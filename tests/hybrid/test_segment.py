"""From a state to the next event: roots on the panels of a segment."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from nipper_pin import Case, ConvergenceError, Resolution, Window, load, simulate
from nipper_pin.dynamics import Partition, ShaftMotion, System
from nipper_pin.hybrid import advance as advancing
from nipper_pin.hybrid.event_location.guards import _gap_root
from nipper_pin.hybrid.motion.panel import Panel
from nipper_pin.mechanism import Stop

MODEL = Path(__file__).parents[1] / "verification" / "models" / "bouncing_mass"


@pytest.fixture(scope="module")
def system() -> System:
    """The bouncing mass at 60 r/min."""
    return System(load(MODEL), ShaftMotion(load(MODEL), 2.0 * np.pi, 0.0))


UPPER = Stop(name="ceiling", index=0, restitution=0.5, contact=None, sense=-1.0, at=0.1)
LOWER = Stop(name="floor", index=0, restitution=0.5, contact=None)
sides = pytest.mark.parametrize("stop", [LOWER, UPPER], ids=lambda stop: stop.name)


def _fall(
    system: System, gap: float, rate: float, acceleration: float, stop: Stop = LOWER
) -> float | None:
    """Root of gap + rate t + acceleration t^2 / 2 on a panel of one second, by the engine."""
    nv, count = system.body.nv, 8
    stop = replace(stop, index=system.mechanism.stop("table").index)
    q, v, a = np.zeros((3, count, nv))
    q[0, stop.index] = stop.at + stop.sense * gap
    v[0, stop.index], a[:, stop.index] = stop.sense * rate, stop.sense * acceleration
    panel = Panel(0.0, 1.0, q, v, a, split=Partition((), tuple(range(nv))), integrated=True)
    return _gap_root(system, system.constraint_set(frozenset()), panel, stop)


@pytest.mark.parametrize("gap", [1.0, 1e-3, 1e-6, 1e-9, 1e-12, 1e-15])
def test_a_gap_however_small_at_the_start_closes_at_its_root(system: System, gap: float) -> None:
    """With gap d, rate -2 and acceleration -2 the root is sqrt(1 + d) - 1, about d / 2.

    For small d it lies before every inner point of any grid. The root is a difference of numbers of
    order one times the panel length only through the gap itself, hence 1e-12 of it, and the
    resolution of the time scale, 4 eps.
    """
    root = _fall(system, gap, -2.0, -2.0)
    wanted = gap / (np.sqrt(1.0 + gap) + 1.0)
    assert root == pytest.approx(wanted, rel=1e-12, abs=1e-15)


@sides
@pytest.mark.parametrize("rate", [0.4, 1e-1, 1e-2, 1e-3])
def test_a_gap_that_opens_from_zero_closes_a_flight_later(
    system: System, rate: float, stop: Stop
) -> None:
    """From zero with rate w and acceleration -g the gap is back at 2 w / g.

    The zero at the start is no trigger, and the flight may be 500 times shorter than the panel;
    then the double integral, exact to one eps of its scale, leaves eps / w of the time. At an
    upper stop at 0.1 the flight is 5e-7 high, and a difference of coordinates would leave 3e-11.
    """
    assert _fall(system, 0.0, rate, -1.0, stop) == pytest.approx(2.0 * rate, rel=1e-12)


@sides
def test_a_gap_that_stays_open_has_no_root(system: System, stop: Stop) -> None:
    """A gap that grows, or returns only after the panel, gives no root."""
    assert _fall(system, 0.0, 1.0, 1.0, stop) is None
    assert _fall(system, 1.0, 1.0, -3.0, stop) is None
    assert _fall(system, 0.0, 1.0, -1.9, stop) is None


@pytest.mark.parametrize("panels", [33, 53, 66, 99, 110])
def test_flights_that_end_just_after_a_panel_end_at_their_impact(panels: int) -> None:
    """Panel lengths with a boundary a hair before an impact give the times of other panel lengths.

    Seven nodes resolve these panels to 1e-10; a missed impact is an error of order one.
    """
    mechanism = load("e62", {"stops.jaw.restitution": 0.5})
    times = []
    for count in (panels, panels + 7):
        resolution = Resolution(adaptive=False, flight_nodes=7, panels_per_turn=count)
        case = Case(speed_rpm=650.0, resolution=resolution)
        times.append([item.t for item in simulate(mechanism, case).collisions[:5]])
    assert times[0] == pytest.approx(times[1], rel=1e-9)


def test_a_phase_of_too_many_panels_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    """The longest phase passes a limit of as many panels as it has and not one of one less.

    Without the limit both would pass; what is refused names the time that was reached.
    """
    case = Case(speed_rpm=450.0, window=Window.CYCLE, resolution=Resolution(panels_per_turn=400))
    most = max(len(part.panels) for part in simulate(load("e62"), case).segments)
    monkeypatch.setattr(advancing, "_MOST_PANELS", most)
    simulate(load("e62"), case)
    monkeypatch.setattr(advancing, "_MOST_PANELS", most - 1)
    with pytest.raises(ConvergenceError, match=f"more than {most - 1} panels") as caught:
        simulate(load("e62"), case)
    assert caught.value.evidence["t"] > 0.0
