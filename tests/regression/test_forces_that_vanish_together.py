"""Found by the stress campaign (case 3165 of seed 91): "the accelerations contradict the stops".

Without weight the forces of two stops on a yoke vanish in the instant in which it ceases to
accelerate. All accelerations are zero then, so they did not tell which stop opens; both were
opened, or the one that had to stay was opened by a force of minus round-off.
"""

from __future__ import annotations

import pytest
from small_machines import SHAFT, frame, hinge, link, machine, slide

from nipper_pin import Case, EventKind, Window, simulate

RADIUS = 0.2


def test_of_two_forces_that_vanish_together_one_comes_back() -> None:
    """A yoke swings as r cos w t and carries a pendulum, which carries a slide, each on a stop.

    The yoke's acceleration is zero at a quarter of a turn, in closed form. The pendulum leaves its
    stop then; what it carries is pressed on again, and could not fall through its stop.
    """
    parts = [
        link("crank", 2.0, 0.01, (0.01, 0.0)), hinge("shaft", "frame", "crank"),
        frame("pin", "crank", (RADIUS, 0.0)),
        link("yoke", 1.5, 0.01), slide("x", "frame", "yoke", at=(RADIUS, 0.0)),
        frame("line", "yoke", (0.0, 0.0)),
        link("b0", 0.81, 0.0137, (0.0676, -0.2666)), hinge("j0", "yoke", "b0", (0.07, 0.16)),
        link("b1", 0.047, 4.7e-4, (0.17, -0.165)),
        slide("j1", "b0", "b1", (-0.7071, -0.7071), (0.078, -0.36)),
    ]  # fmt: skip
    mechanism = machine(
        parts, 3,
        drives={"shaft": {"joint": "shaft", "law": "constant_speed", "ratio": 1.0, **SHAFT}},
        closures={"slot": {"frame_a": "line", "frame_b": "pin", "slot_axis": "z",
                           "block_mass_kg": 0.003}},
        stops={
            "upper": {"joint": "j0", "restitution": 0.0, "side": "upper", "at_deg": 0.0},
            "lower": {"joint": "j1", "restitution": 0.0, "side": "lower", "at_mm": 0.0},
        },
        phases=[{"number": 1, "name": "held", "closed": ["upper", "lower"]}],
    )  # fmt: skip
    case = Case(speed_rpm=60.0, window=Window.CYCLE, start_index=0.0)
    solution = simulate(mechanism, case)
    first = solution.events[0]
    assert first.kind is EventKind.RELEASE
    assert first.t == pytest.approx(0.25, abs=1e-13)
    assert first.stops == ("upper",)
    assert first.closed_after == {"lower"}
    t = [0.25 + 1e-4 * k for k in range(1, 20)]
    ahead = solution.trajectory.evaluate(t)
    assert (ahead.q[:, mechanism.stop("lower").index] == 0.0).all()
    assert (mechanism.stop("upper").gaps(ahead.q) > 0.0).all()
    assert solution.energy.relative < 1e-10
