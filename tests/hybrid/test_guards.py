"""What the engine must notice on the way: choices that have become bad, limits, rough forces."""

from __future__ import annotations

from math import inf

import numpy as np
import pytest

from benchmarks.stress.machines.parts import (
    description,
    frame,
    link,
    robot,
    slide,
)
from nipper_pin import Case, Mechanism, Window, simulate
from nipper_pin.dynamics import ShaftMotion, System, impact
from nipper_pin.hybrid.motion.chebyshev import nodes
from nipper_pin.hybrid.motion.panel import Panel
from nipper_pin.hybrid.result.energy_balance import _exchanged
from nipper_pin.hybrid.run.series import bounces as rests
from nipper_pin.mechanism import Characteristic, Stop, from_sources


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


def test_tables_of_springs_go_on_with_their_cubic_for_their_length() -> None:
    """Of a straight line that is the line; beyond twice the length its value there."""
    table = Characteristic(coordinate=(0.0, 0.5, 1.0), force=(1.0, 2.0, 3.0))
    x = np.array([-3.0, -1.0, -0.5, 0.25, 1.5, 2.0, 4.0])
    np.testing.assert_allclose(
        table.forces(x), [-1.0, -1.0, 0.0, 1.5, 4.0, 5.0, 5.0], rtol=0.0, atol=1e-14
    )


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
    right = rests.rest_of_series

    def series(*arguments: object) -> tuple[float, float]:
        in_rests.append(True)
        try:
            return right(*arguments)  # type: ignore[arg-type]
        finally:
            in_rests.pop()

    monkeypatch.setattr(ShaftMotion, "smooth_for", knot_near)
    monkeypatch.setattr("nipper_pin.hybrid.run.series.bounces.rest_of_series", series)
    followed = simulate(e62, case)
    assert asked
    assert len(followed.collisions) > len(free.collisions)
    # Both are the same rest: what the limit says is what the bounces do.
    assert followed.transitions[0].duration == pytest.approx(free.transitions[0].duration, rel=1e-9)


def passing(distance: float) -> Mechanism:
    """A carriage on a screw whose spring passes a fixed point at a small distance."""
    parts = [
        link("carriage", 1.0, 0.01, (0.0, 0.0)),
        slide("rail", "frame", "carriage", (1.0, 0.0)),
        frame("eye", "carriage", (0.0, 0.0)),
        frame("post", "frame", (0.05, distance)),
    ]
    texts = description("a spring that passes a point", 1, 0.0)
    train = {"shaft_frequency_hz": 10.0, "shaft_damping_ratio": 0.7, "reflected_mass_kg": 1.0}
    drive = {"joint": "rail", "law": "screw", "lead_mm_per_turn": 100.0, **train}
    texts["drives"] = {"screw": drive}
    texts["springs"] = {"pull": {"frame_a": "eye", "frame_b": "post",
                                 "stiffness_N_per_m": 1e4, "free_length_mm": 20.0}}  # fmt: skip
    texts["phases"] = [{"number": 1, "name": "running", "closed": []}]
    return from_sources("passing", robot("passing", parts), texts, ".")


def test_the_work_of_a_spring_that_passes_closely_is_integrated_finely() -> None:
    """The screw turns evenly, so its work is what the spring stores: to 1e-9 of that.

    On one panel over seven tenths of a turn, of which the force turns within one hundredth.
    """
    machine = passing(1e-3)
    system = System(machine, ShaftMotion(machine, 2.0 * np.pi, 0.0))
    run = simulate(machine, Case(speed_rpm=60.0, window=Window.CYCLE, start_index=0.0))
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
