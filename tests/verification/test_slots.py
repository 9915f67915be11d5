"""Pins in slots: Scotch yoke and slotted lever in closed form, and a machine built by hand."""

from __future__ import annotations

from math import atan2, hypot

import numpy as np
import pytest
from judged_runs import both, compare
from small_machines import SHAFT, frame, hinge, link, machine, slide

from nipper_pin import (
    Case,
    InputError,
    Mechanism,
    Solution,
    Window,
    simulate,
)
from nipper_pin.mechanism.drives import OscillatingGuide

RADIUS = 0.05
TURN = Case(speed_rpm=60.0, window=Window.CYCLE, start_index=0.0)
CRANK = {"crank": {"joint": "crank_axis", "law": "constant_speed", "ratio": 1.0, **SHAFT}}
CRANK_PARTS = [
    link("crank", 2.0, 0.01, (0.01, 0.0)),
    hinge("crank_axis", "frame", "crank"),
    frame("crank_pin", "crank", (RADIUS, 0.0)),
]


def index_of(mechanism: Mechanism, joint: str) -> int:
    """Place of a joint's coordinate."""
    return next(item.index for item in mechanism.joints if item.name == joint)


def sampled(solution: Solution) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Times, q, v and a at 101 times of a turn."""
    t = np.linspace(*solution.trajectory.span, 101)
    motion = solution.trajectory.evaluate(t)
    return t, motion.q, motion.v, solution.trajectory.reactions(t).a


def yoke(mass: float = 0.3) -> Mechanism:
    """A crank pin in the upright slot of a yoke that slides along x."""
    parts = [*CRANK_PARTS, link("yoke", 1.5, 0.01), slide("yoke_x", "frame", "yoke")]
    slot = {"frame_a": "yoke", "frame_b": "crank_pin", "slot_axis": "z", "block_mass_kg": mass}
    # The yoke's origin stands where the pin is at touch.
    parts[-1] = slide("yoke_x", "frame", "yoke", at=(RADIUS, -0.02))
    return machine(parts, 1, drives=CRANK, closures={"slot": slot})


def test_a_scotch_yoke_moves_as_the_cosine() -> None:
    """x = r cos psi, and the block stands at r sin psi in its slot, with both derivatives.

    Rates are in units of r W and accelerations of r W^2; round-off of the closures is 1e-16 m. The
    yoke's frame stands 20 mm below the pin at touch: the block's coordinate is zero there all the
    same.
    """
    mechanism = yoke()
    t, q, v, a = sampled(simulate(mechanism, TURN))
    W = 2.0 * np.pi
    x, s = index_of(mechanism, "yoke_x"), index_of(mechanism, "slot")
    assert q[:, x] == pytest.approx(RADIUS * (np.cos(W * t) - 1.0), abs=1e-15)
    assert q[:, s] == pytest.approx(RADIUS * np.sin(W * t), abs=1e-15)
    assert v[:, x] == pytest.approx(-RADIUS * W * np.sin(W * t), abs=1e-14)
    assert v[:, s] == pytest.approx(RADIUS * W * np.cos(W * t), abs=1e-14)
    assert a[:, x] == pytest.approx(-RADIUS * W**2 * np.cos(W * t), abs=1e-13)
    assert a[:, s] == pytest.approx(-RADIUS * W**2 * np.sin(W * t), abs=1e-13)


def test_the_pin_pushes_across_its_slot_and_moves_its_block() -> None:
    """The force on the block is what the yoke's mass asks for across, the block's own along.

    Both masses move along x by r cos W t, the block alone along z by r sin W t; the force that the
    pin exerts on the block, the side of frame a, is m a in either direction.
    """
    mechanism = yoke(0.3)
    solution = simulate(mechanism, TURN)
    t = np.linspace(*solution.trajectory.span, 101)
    W = 2.0 * np.pi
    force = solution.trajectory.reactions(t).closures["slot"]
    scale = RADIUS * W**2
    assert force[:, 0] == pytest.approx(-(1.5 + 0.3) * scale * np.cos(W * t), abs=1e-12)
    assert force[:, 1] == pytest.approx(-0.3 * scale * np.sin(W * t), abs=1e-12)


GUIDE = (-0.12, 0.03)


def test_a_slotted_lever_is_an_oscillating_guide() -> None:
    """Crank and slotted lever (quick return): the law of the same mechanism as a drive.

    The lever turns about a fixed point beside the crank; a frame on it is turned so that its x
    axis, the slot, points to the pin at touch. The law is atan2 with derivatives by hand, and knows
    no closure. The block slides by the change of distance from the lever's axis to the pin.
    """
    x, z = RADIUS - GUIDE[0], -GUIDE[1]
    slot_angle = atan2(z, x)
    lever = [
        link("lever", 1.0, 0.02, (0.05, 0.0)),
        hinge("lever_axis", "frame", "lever", GUIDE),
        frame("slot_frame", "lever", turned=slot_angle),
    ]
    slot = {
        "frame_a": "slot_frame", "frame_b": "crank_pin", "slot_axis": "x", "block_mass_kg": 0.2
    }  # fmt: skip
    mechanism = machine([*CRANK_PARTS, *lever], 1, drives=CRANK, closures={"slot": slot})
    t, q, v, a = sampled(simulate(mechanism, TURN))
    W = 2.0 * np.pi
    law = OscillatingGuide(
        crank_radius_m=RADIUS, crank_axis=(0.0, 0.0), guide_axis=GUIDE, guide_offset_m=0.0
    )
    angle, rate, second = law.evaluate(W * t)
    column, block = index_of(mechanism, "lever_axis"), index_of(mechanism, "slot")
    assert q[:, column] == pytest.approx(angle - angle[0], abs=1e-14)
    assert v[:, column] == pytest.approx(W * rate, abs=1e-13)
    assert a[:, column] == pytest.approx(W**2 * second, abs=1e-12)
    pin = RADIUS * np.exp(1j * W * t) - complex(*GUIDE)
    assert q[:, block] == pytest.approx(np.abs(pin) - hypot(x, z), abs=1e-14)


def test_a_slot_moves_as_an_independent_solution_has_it() -> None:
    """A crank pin in the slot of a lever that throws a sprung flap, by points on lines.

    A spring stands on the block's own coordinate.
    """
    parts = [
        *CRANK_PARTS,
        link("lever", 1.0, 0.02, (0.05, 0.0)), hinge("lever_axis", "frame", "lever", (-0.2, 0.0)),
        link("flap", 0.4, 0.003, (0.05, 0.01)), hinge("flap_axis", "lever", "flap", (0.1, 0.0)),
    ]  # fmt: skip
    slot = {"frame_a": "lever", "frame_b": "crank_pin", "slot_axis": "x", "block_mass_kg": 0.25}
    hammer = machine(
        parts, 2, gravity=9.81, drives=CRANK, closures={"slot": slot},
        springs={"coil": {"joint": "flap_axis", "stiffness_N_m_per_rad": 2.0, "preload_deg": 4.0},
                 "buffer": {"joint": "slot", "stiffness_N_per_m": 30.0, "preload_length_mm": 2.0}},
        stops={"flap": {"joint": "flap_axis", "restitution": 0.4},
               "back": {"joint": "flap_axis", "restitution": 0.6, "side": "upper", "at_deg": 6.0}},
    )  # fmt: skip
    report = compare(both(hammer), 180.0, start_index=0.0)
    assert report.verdict == "agree", report.line()
    assert report.events > 5
    assert report.motion <= 1e-11


def test_a_stop_may_limit_the_block() -> None:
    """A stop on the block's coordinate stops the pin in its slot: a slotted link that goes taut.

    The mass hangs on the pin by gravity alone, 0.4 of its way down the slot; it falls from rest and
    is caught after sqrt(2 h / g), with the impulse M v of all that falls.
    """
    parts = [
        link("pin_carrier", 0.7), slide("drop", "frame", "pin_carrier", (0.0, 1.0)),
        link("rail"), slide("rail_x", "frame", "rail"),
        link("arm", 1.0), hinge("arm_axis", "frame", "arm", (1.0, 1.0)),
    ]  # fmt: skip
    slot = {"frame_a": "rail", "frame_b": "pin_carrier", "slot_axis": "z", "block_mass_kg": 0.1}
    mechanism = machine(
        parts, 2, gravity=9.81,
        drives={"arm": {"joint": "arm_axis", "law": "constant_speed", "ratio": 1.0, **SHAFT}},
        closures={"slot": slot},
        stops={"end": {"joint": "slot", "restitution": 0.0, "at_mm": -400.0}},
    )  # fmt: skip
    solution = simulate(mechanism, TURN)
    (hit,) = solution.collisions
    assert hit.t == pytest.approx((0.8 / 9.81) ** 0.5, rel=1e-12)
    assert hit.impulse == pytest.approx(0.8 * (0.8 * 9.81) ** 0.5, rel=1e-11)
    assert solution.events[-1].closed_after == {"end"}


GOOD = {"frame_a": "yoke", "frame_b": "crank_pin", "slot_axis": "z", "block_mass_kg": 0.1}


@pytest.mark.parametrize(("changes", "off", "freedom", "words"), [
    ({"block_mass_kg": 0.0}, 0.0, 1, r"closures\.slot\.block_mass_kg = 0\.0 .*above 0"),
    ({"slot_axis": "y"}, 0.0, 1, r"closures\.slot\.slot_axis = 'y' .*one of x, z"),
    ({"frame_a": "rail"}, 0.0, 1, r"closures\.slot\.frame_a.*no frame named 'rail'"),
    ({}, 0.001, 1, r"1 mm .*from the slot along z of yoke to crank_pin"),
    ({}, 0.0, 2, r"the model has 1: 3 tree joints \(1 of them blocks"),
])  # fmt: skip
def test_mistakes_in_slots_are_named(
    changes: dict[str, object], off: float, freedom: int, words: str
) -> None:
    """With the key and the gap; what is missing or named twice is among the reviewed refusals."""
    at = (RADIUS + off, 0.0)
    parts = [*CRANK_PARTS, link("yoke"), slide("yoke_x", "frame", "yoke", at=at)]
    with pytest.raises(InputError, match=words):
        machine(parts, freedom, drives=CRANK, closures={"slot": GOOD | changes})
