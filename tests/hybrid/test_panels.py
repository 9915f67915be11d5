"""Panels of a flight: how long they may be, what they are asked, and where a gap closes on them."""

from __future__ import annotations

from math import inf
from typing import Any

import numpy as np
import pytest
from small_machines import SLED, frame, link, machine, slide, turn

from nipper_pin import Case, ConvergenceError, Mechanism, Resolution, Window, load, simulate
from nipper_pin.chebyshev import nodes
from nipper_pin.dynamics import Partition, ShaftMotion, System, impact
from nipper_pin.hybrid import advance
from nipper_pin.hybrid.event_location.guards import _gap_root
from nipper_pin.hybrid.motion.kinematics import kinematic_panel
from nipper_pin.hybrid.motion.panel import Attempt, Begin, Panel
from nipper_pin.hybrid.motion.picard import flight_panel
from nipper_pin.hybrid.result.energy_balance import _exchanged
from nipper_pin.hybrid.run.series import bounces
from nipper_pin.mechanism import Stop

MASS = machine([link("mass"), slide("x", "frame", "mass")], 1)
UPPER = Stop(name="ceiling", index=0, restitution=0.5, contact=None, sense=-1.0, at=0.1)

LOWER = Stop(name="floor", index=0, restitution=0.5, contact=None)


def _fall(gap: float, rate: float, acceleration: float, stop: Stop = LOWER) -> float | None:
    """Root of gap + rate t + acceleration t^2 / 2 on a panel of one second, by the engine."""
    q, v, a = np.zeros((3, 8, 1))
    q[0], v[0], a[:] = stop.at + stop.sense * gap, stop.sense * rate, stop.sense * acceleration
    system = System(MASS, ShaftMotion(MASS, 2.0 * np.pi, 0.0))
    panel = Panel(0.0, 1.0, q, v, a, split=Partition((), (0,)), integrated=True)
    return _gap_root(system, system.constraint_set(frozenset()), panel, stop)


@pytest.mark.parametrize("gap", [1.0, 1e-3, 1e-6, 1e-9, 1e-12, 1e-15])
def test_a_gap_however_small_at_the_start_closes_at_its_root(gap: float) -> None:
    """With gap d, rate -2 and acceleration -2 the root is sqrt(1 + d) - 1, about d / 2.

    For small d it lies before every inner point of any grid. The root is a difference of numbers of
    order one times the panel length only through the gap itself, hence 1e-12 of it, and the
    resolution of the time scale, 4 eps.
    """
    root = _fall(gap, -2.0, -2.0)
    wanted = gap / (np.sqrt(1.0 + gap) + 1.0)
    assert root == pytest.approx(wanted, rel=1e-12, abs=1e-15)


@pytest.mark.parametrize("stop", [LOWER, UPPER], ids=lambda stop: stop.name)
@pytest.mark.parametrize("rate", [0.4, 1e-1, 1e-2, 1e-3])
def test_a_gap_that_opens_from_zero_closes_a_flight_later(rate: float, stop: Stop) -> None:
    """From zero with rate w and acceleration -g the gap is back at 2 w / g.

    The zero at the start is no trigger, and the flight may be 500 times shorter than the panel;
    then the double integral, exact to one eps of its scale, leaves eps / w of the time. At an
    upper stop at 0.1 the flight is 5e-7 high, and a difference of coordinates would leave 3e-11.
    """
    assert _fall(0.0, rate, -1.0, stop) == pytest.approx(2.0 * rate, rel=1e-12)


@pytest.mark.parametrize("stop", [LOWER, UPPER], ids=lambda stop: stop.name)
def test_a_gap_that_stays_open_has_no_root(stop: Stop) -> None:
    """A gap that grows, or returns only after the panel, gives no root."""
    assert _fall(0.0, 1.0, 1.0, stop) is None
    assert _fall(1.0, 1.0, -3.0, stop) is None
    assert _fall(0.0, 1.0, -1.9, stop) is None


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
    monkeypatch.setattr(advance, "_MOST_PANELS", most)
    simulate(load("e62"), case)
    monkeypatch.setattr(advance, "_MOST_PANELS", most - 1)
    with pytest.raises(ConvergenceError, match=f"more than {most - 1} panels") as caught:
        simulate(load("e62"), case)
    assert caught.value.evidence["t"] > 0.0


def test_a_panel_that_is_too_long_is_given_up_after_two_sweeps_of_each_grid(e62: Mechanism) -> None:
    """What follows the last coefficients is far above the tolerance on a fifth of a turn."""
    solution = simulate(e62, Case(speed_rpm=650.0))
    system, segment = solution.system, solution.segments[0]
    first = segment.panels[0]
    jacobian = system.body.closures(first.q[:1])[1][0]
    begin = Begin(first.t, first.q[0], first.v[0], first.a[0], jacobian)
    phase, before = system.constraint_set(segment.closed), system.body.evaluations
    h = 0.2 * system.shaft.period
    attempt = flight_panel(system, phase, first.split, begin, h, Resolution())
    assert attempt.panel is None
    assert 0.2 <= attempt.factor <= 0.7
    # New nodes of three nested grids, and states in which the round-off of forces is asked for.
    assert system.body.evaluations - before <= 2 * (3 + 6 + 12) + 3


def test_phases_without_freedom_take_panels_of_a_fifth_of_a_turn(
    e62: Mechanism, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Three stretches of a turn of the E62 at 450 r/min: none of their panels is solved twice."""
    tried = []

    def counted(*arguments: Any) -> Attempt:
        tried.append(arguments)
        return kinematic_panel(*arguments)

    monkeypatch.setattr(advance, "kinematic_panel", counted)
    solution = simulate(e62, Case(speed_rpm=450.0, window=Window.CYCLE))
    stretches = [item.panels for item in solution.segments if item.kinematic]
    first = max(panels[0].h for panels in stretches)
    assert first == pytest.approx(2.5 / 12.0 * solution.shaft.period)
    assert max(panel.h for panels in stretches for panel in panels) > 1.1 * first
    assert len(tried) == sum(len(panels) for panels in stretches) == 6


@pytest.mark.parametrize("model", ["e62", "hanging_pendulum", "e62_offset_guide"])
def test_a_nipper_needs_none(model: str) -> None:
    """Linear springs on joints: the nodes show all that their forces do.

    What each check is for is tested in `tests/regression` (forces between nodes, points that pass),
    in `test_self_check.py`, and for ends of tables in `test_springs_in_other_forms.py`.
    """
    mechanism = load(model)
    assert System(mechanism, ShaftMotion(mechanism, 50.0, 0.0)).elements is None


def system_of(mechanism: Mechanism) -> System:
    return System(mechanism, ShaftMotion(mechanism, 50.0, 0.0))


def test_a_choice_of_coordinates_that_has_become_singular_is_made_anew(e62: Mechanism) -> None:
    """The closures of a second configuration do not determine what those of the first did."""
    system = system_of(e62)
    given = tuple(int(index) for index in system.driven)
    _, jacobian = system.body.closures(np.zeros((1, system.body.nv)))
    first = system.split(jacobian[0], given, ())
    again = jacobian[0].copy()
    again[:, first.columns[0]] = again[:, first.columns[1]]
    # What the lost column did is done by another coordinate, which was independent.
    other = next(
        column for column in range(system.body.nv)
        if column not in first.dependent and column not in given
    )  # fmt: skip
    again[:, other] = jacobian[0][:, first.columns[0]]
    assert np.linalg.cond(again[:, first.columns]) > 1e12
    second = system.split(again, given, ())
    assert second.dependent != first.dependent
    assert np.linalg.cond(again[:, second.columns]) < 1e4


@pytest.mark.parametrize(("short", "stops"), [(1e-13, {"a"}), (1e-6, {"a", "b"})])
def test_a_stop_that_would_go_on_closing_takes_part(
    e62: Mechanism, monkeypatch: pytest.MonkeyPatch, short: float, stops: set[str]
) -> None:
    """One impulse would do for both, but for a share of the rate: only round-off is let pass."""
    system = system_of(e62)
    a, b = (
        Stop(name=name, index=index, restitution=0.0, contact=None)
        for name, index in (("a", 0), ("b", 1))
    )  # fmt: skip
    v = np.zeros(system.body.nv)
    v[:2] = -1.0, -1.0

    def impulses(_s: object, _q: object, _j: object, chosen: list[Stop], _jumps: object) -> object:
        delta = np.zeros(system.body.nv)
        delta[:2] = 1.0, 1.0
        if [stop.name for stop in chosen] == ["a"]:
            delta[1] -= short
        if [stop.name for stop in chosen] == ["b"]:
            return None
        return delta, np.zeros(system.body.closure_rows), np.ones(len(chosen))

    monkeypatch.setattr(impact, "_impulses", impulses)
    none = np.zeros((system.body.closure_rows, system.body.nv))
    found = impact.collide(system, np.zeros(system.body.nv), v, none, [a, b], [0.0, 0.0])
    assert {name for name, impulse in found.P_N.items() if impulse > 0.0} == stops


def test_no_limit_is_taken_across_a_knot_of_a_drive(
    e62: Mechanism, monkeypatch: pytest.MonkeyPatch
) -> None:
    """With a knot always near, bounces are followed on until what is left is the tolerance."""
    case = Case(speed_rpm=650.0)
    free = simulate(e62, case)
    asked: list[float] = []

    def knot_near(_shaft: ShaftMotion, t: float) -> float:
        asked.append(t)
        return 0.0 if in_rests[-1] else inf

    in_rests = [False]
    right = bounces.accumulation_point

    def series(*arguments: object) -> tuple[float, float]:
        in_rests.append(True)
        try:
            return right(*arguments)  # type: ignore[arg-type]
        finally:
            in_rests.pop()

    monkeypatch.setattr(ShaftMotion, "smooth_for", knot_near)
    monkeypatch.setattr("nipper_pin.hybrid.run.series.bounces.accumulation_point", series)
    followed = simulate(e62, case)
    assert asked
    assert len(followed.collisions) > len(free.collisions)
    # Both are the same rest: what the limit says is what the bounces do.
    assert followed.transitions[0].duration == pytest.approx(free.transitions[0].duration, rel=1e-9)


def test_the_work_of_a_spring_that_passes_closely_is_integrated_finely() -> None:
    """The screw turns evenly, so its work is what the spring stores: to 1e-9 of that.

    On one panel over seven tenths of a turn, of which the force turns within one hundredth.
    """
    parts = [
        link("carriage"), slide("x", "frame", "carriage"), frame("post", "frame", (0.05, 1e-3)),
    ]  # fmt: skip
    pull = {"frame_a": "carriage", "frame_b": "post", "stiffness_N_per_m": 1e4,
            "free_length_mm": 20.0}  # fmt: skip
    screw = {"joint": "x", "law": "screw", "lead_mm_per_turn": 100.0, **SLED}
    passing = machine(parts, 1, drives={"screw": screw}, springs={"pull": pull})
    run = turn(passing)
    system = run.system
    grid, end = nodes(12).sigma[:, None], 0.7
    rate = float(run.segments[0].panels[0].v[0, 0])
    panel = Panel(t=0.0, h=end, q=rate * end * grid, v=np.full_like(grid, rate),
                  a=np.zeros_like(grid), split=run.segments[0].panels[0].split,
                  integrated=False)  # fmt: skip
    rows = system.constraint_set(frozenset())
    work, _, _ = _exchanged(system, rows, panel, 0.0, end, 0.0)
    states = panel.q[[0, -1]].copy()
    states[-1] = rate * end
    stored = np.diff(system.spring_energy(states))[0]
    assert abs(stored) > 1.0
    assert work == pytest.approx(stored, rel=1e-9)
