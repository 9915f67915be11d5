"""Small changes through flights and collisions: linear maps against neighbouring motions.

The restitution of a stop changes what follows its collisions and nothing else. Its derivative is
carried through the flights and collisions of one run and compared with what a second run of the
whole engine, with a restitution larger by 1e-6, does.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from small_machines import SHAFT, frame, hinge, link, machine

from nipper_pin import Case, DriveMode, EventKind, Resolution, Solution, Window, load, simulate
from nipper_pin.hybrid.error_estimate.saltation import impact_map
from nipper_pin.hybrid.error_estimate.variational import flight_map
from nipper_pin.hybrid.error_estimate.zonotope import Deviations

CHANGE = 1e-6


def _pendulums(restitution: float) -> Solution:
    """A double pendulum on a rocking base; its lower rod strikes from both sides."""
    parts = [
        link("base"), hinge("shaft", "frame", "base"),
        link("upper", 1.0, 0.01, (0.2, 0.0)), hinge("shoulder", "base", "upper", (0.1, 0.0)),
        link("lower", 0.5, 0.004, (0.15, 0.02)), hinge("elbow", "upper", "lower", (0.4, 0.0)),
    ]  # fmt: skip
    drive = {"joint": "shaft", "law": "fourier", "sine_rad": [0.3, 0.1], **SHAFT}
    stops = {
        "near": {"joint": "elbow", "restitution": restitution, "side": "lower", "at_deg": -20.0},
        "far": {"joint": "elbow", "restitution": 0.7, "side": "upper", "at_deg": 10.0},
    }
    both = machine(parts, 3, gravity=9.81, drives={"shaft": drive}, stops=stops)
    case = Case(speed_rpm=60.0, window=Window.CYCLE, start_index=0.0, max_collisions=7,
                resolution=Resolution(tolerance=1e-13))  # fmt: skip
    return simulate(both, case)


def _tie(restitution: float) -> Solution:
    """The same pendulum, closed to a loop by a rocker and a coupler: three freedoms, one loop."""
    parts = [
        link("base"), hinge("shaft", "frame", "base"),
        link("arm", 1.0, 0.01, (0.2, 0.0)), hinge("shoulder", "base", "arm", (0.1, 0.0)),
        link("lower", 0.5, 0.004, (0.15, 0.02)), hinge("elbow", "arm", "lower", (0.4, 0.0)),
        frame("tip", "lower", (0.3, 0.0)),
        link("rocker", 0.7, 0.02), hinge("rocker", "frame", "rocker", (0.9, 0.3)),
        link("coupler", 0.4, 0.01), hinge("joint", "rocker", "coupler", (0.1, -0.5)),
        frame("end", "coupler", (-0.2, 0.2)),
    ]  # fmt: skip
    drive = {"joint": "shaft", "law": "fourier", "sine_rad": [0.3, 0.1], **SHAFT}
    stops = {
        "near": {"joint": "elbow", "restitution": 0.7, "side": "lower", "at_deg": -5.0},
        "far": {"joint": "elbow", "restitution": restitution, "side": "upper", "at_deg": 5.0},
    }
    both = machine(parts, 3, gravity=9.81, drives={"shaft": drive}, stops=stops,
                   closures={"tie": {"frame_a": "tip", "frame_b": "end"}})  # fmt: skip
    case = Case(speed_rpm=60.0, window=Window.CYCLE, start_index=0.0, max_collisions=6,
                drive=DriveMode.INERTIAL, resolution=Resolution(tolerance=1e-13))  # fmt: skip
    return simulate(both, case)


def _nipper(restitution: float) -> Solution:
    """The transition of the E62-class nipper with shafts that yield: two loops, three freedoms."""
    case = Case(speed_rpm=650.0, drive=DriveMode.INERTIAL, resolution=Resolution(tolerance=1e-13))
    return simulate(load("e62", {"stops.jaw.restitution": restitution}), case)


def _derivatives(solution: Solution, name: str) -> list[tuple[float, float]]:
    """Derivatives of the times of all collisions and of their impulses, by a restitution."""
    system, mechanism, nv = solution.system, solution.mechanism, solution.system.body.nv
    found = Deviations(np.zeros((2 * nv, 1)), np.zeros(1), np.zeros(1))
    segments, derivatives = list(solution.segments), []
    for event in solution.events:
        if event.kind is not EventKind.COLLISION:
            break
        while segments and segments[0].t_end <= event.t:
            segment = segments.pop(0)
            first = segment.panels[0]
            found = found.later(-found.late, np.concatenate([first.v[0], first.a[0]]))
            rows = system.constraint_set(segment.closed)
            for panel, begin, end in segment.pieces():
                found = found.through(flight_map(system, rows, panel, end - begin)[0])
            rows = system.constraint_set(event.closed_before)
            motion = system.shaft.driven(np.array([event.t]))
            a = system.accelerations(motion, event.q[None], event.v_before[None], rows)[0]
            stop = mechanism.stop(event.stops[0])
            late = -found.states[stop.index] / event.v_before[stop.index]
            found = found.later(late, np.concatenate([event.v_before, a]))
            assert found.states[stop.index] == pytest.approx([0.0], abs=1e-12)
        stop = mechanism.stop(event.stops[0])
        matrix, pushes = impact_map(system, event.q, event.v_before, [stop], [stop.restitution])
        impulse = float((pushes @ found.states)[0, 0])
        found = found.through(matrix)
        if stop.name == name:
            # v+ = v- + (1 + e) times something that e does not change; so the impulse.
            found.states[nv:, 0] += event.delta / (1.0 + stop.restitution)
            impulse += event.P_N[name] / (1.0 + stop.restitution)
        derivatives.append((float(found.late[0]), impulse))
    return derivatives


@pytest.mark.parametrize(
    ("run", "stop", "restitution"),
    [(_pendulums, "near", 0.6), (_tie, "far", 0.6), (_nipper, "jaw", 0.3)],
)
def test_changes_of_times_and_impulses_are_those_of_a_neighbouring_motion(
    run: Callable[[float], Solution], stop: str, restitution: float
) -> None:
    """Differences of first order: 1e-6 of them, and errors of 1e-13 over changes of 1e-6, are left.

    Each collision multiplies what those before it have done, so a wrong sign or a lost term in one
    map shows in all later ones.
    """
    base, other = run(restitution), run(restitution + CHANGE)
    derivatives = _derivatives(base, stop)
    assert len(derivatives) > 3
    for number, (late, impulse) in enumerate(derivatives):
        one, two = base.events[number], other.events[number]
        assert one.stops == two.stops
        name = one.stops[0]
        assert (two.t - one.t) / CHANGE == pytest.approx(late, rel=1e-3, abs=1e-7 * one.t)
        changed = (two.P_N[name] - one.P_N[name]) / CHANGE
        assert changed == pytest.approx(impulse, rel=1e-3, abs=1e-6 * one.P_N[name])
    assert abs(derivatives[-1][0]) > 1e-4 * base.events[len(derivatives) - 1].t
