"""Links that differ by many powers of ten in mass: found by the stress campaign."""

from __future__ import annotations

import math
from xml.etree import ElementTree

import numpy as np
import pytest
from small_machines import TURNING, frame, hinge, link, machine, nipper, slide, turn

import nipper_pin as nip
from benchmarks.stress.machines.small_machines import e62
from nipper_pin.dynamics import close_velocities
from nipper_pin.mechanism import from_sources


def test_impacts_meet_the_closures_whatever_the_masses() -> None:
    """A steeve of 1 kg below and 2e-5 kg above, on an eccentric of 5 t.

    One call of the impulse dynamics loses as many digits as the masses differ by: what it missed
    the closures by, up to 2e-9 of the change of velocity, is solved again.
    """
    masses = {
        "links__rocker__mass_kg": 6.112970081993449,
        "links__steeve_lower__mass_kg": 958.4004960978955,
        "links__steeve_upper__mass_kg": 2e-05,
        "links__eccentric__mass_kg": 5000.0,
    }
    numbers = 0.3692777920542086, 0.2182642475452975, 4965.6935234898165, 4.6822706988600995
    case = nip.Case(speed_rpm=148.03270023741666, window=nip.Window.CYCLE, max_collisions=200)
    solution = nip.simulate(nipper(*numbers, **masses), case)
    hits = [event for event in solution.events if event.kind is nip.EventKind.COLLISION]
    assert len(hits) > 5
    for event in hits:
        _, jacobian = solution.system.body.closures(event.q[None])
        size = (np.abs(jacobian[0]) @ np.abs(event.delta)).max()
        assert np.abs(jacobian[0] @ event.delta).max() <= 1e-11 * size


def _slotted_lever(block_mass: float) -> nip.Mechanism:
    """A crank turns a lever through a block in its slot; a flap on the lever bounces."""
    parts = [
        link("crank", 2.0, 0.01, (0.01, 0.0)), hinge("shaft", "frame", "crank"),
        frame("pin", "crank", (0.09674855953523717, 0.0)),
        link("lever", 1.0, 0.02, (0.05, 0.0)),
        hinge("axis", "frame", "lever", (-0.0733237068380953, -0.0498676967517443)),
        frame("line", "lever", (0.0, 0.0), 0.28522022669285424),
        link("flap", 1.3878656094729744, 0.003923527536982059,
             (0.08861625551878967, 0.017723251103757935)),
        hinge("flap", "lever", "flap", (0.17007226637333248, 0.0498676967517443)),
    ]  # fmt: skip
    return machine(
        parts, 2, gravity=57.81913454522849,
        drives={"shaft": TURNING},
        closures={"slot": {"frame_a": "line", "frame_b": "pin", "slot_axis": "x",
                           "block_mass_kg": block_mass}},
        springs={"flap": {"joint": "flap", "stiffness_N_m_per_rad": 0.656877259119166,
                          "preload_deg": 15.856685263233242},
                 "slot": {"joint": "slot", "stiffness_N_per_m": 342.04031944323947,
                          "preload_length_mm": 7.187110921627505}},
        stops={"lower": {"joint": "flap", "restitution": 0.999, "side": "lower",
                         "at_deg": -1.4796459709693544},
               "upper": {"joint": "flap", "restitution": 0.48565811979727536, "side": "upper",
                         "at_deg": 5.729577951308232e-05}},
    )  # fmt: skip


def _run(block_mass: float) -> nip.Solution:
    return turn(_slotted_lever(block_mass), 25.92748785307902, max_collisions=39)


@pytest.fixture(scope="module")
def light() -> nip.Solution:
    return _run(3.7482911899514025e-09)


def test_accelerations_of_a_light_block_meet_the_closures_and_the_equations_of_motion(
    light: nip.Solution,
) -> None:
    """A block of 4e-9 kg, which the round-off of what pushes it moves with 1e-7 m/s2 of its own.

    G a + G_dot v = 0, with G_dot v as a difference of fourth order along v: its step of 1e-3 leaves
    a truncation of 1e-12 and a round-off of 2e-16 / 1e-3 of v^2; 1e-7 was left. And T' (M a + h -
    tau) = 0 for the motion T that the closures leave to the flap and the lever, to round-off of the
    forces: a correction that met the closures by moving the heavy links, and not the block, would
    fail here.
    """
    system = light.system
    body = system.body
    for segment in light.segments[5:25:5]:
        rows, panel = system.constraint_set(segment.closed), segment.panels[0]
        q, v = panel.q, panel.v
        motion = system.shaft.driven(panel.times)
        a = system.accelerations(motion, q, v, rows)
        fastest = np.abs(v).max()
        step = 1e-3 / fastest
        weights = {-2: 1.0, -1: -8.0, 1: 8.0, 2: -1.0}
        change = sum(w * body.closures(q + k * step * v)[1] for k, w in weights.items())
        _, here = body.closures(q)
        left = np.einsum("nij,nj->ni", here, a)
        left += np.einsum("nij,nj->ni", change / (12.0 * step), v)
        assert np.abs(left).max() <= 1e-11 * body.reach_m * fastest**2
        flap = system.mechanism.stop("lower").index
        unit = np.zeros_like(v)
        unit[:, flap] = 1.0
        free = close_velocities(unit, here, panel.split)
        forces = body.inverse_dynamics(q, v, a), system.applied_forces(q, v)
        balance = np.einsum("nj,nj->n", free, forces[0] - forces[1])
        pulls = np.abs(free) * (np.abs(forces[0]) + np.abs(forces[1]))
        assert np.abs(balance).max() <= 1e-13 * pulls.sum(axis=1).max()


def test_a_light_block_costs_no_panels(light: nip.Solution) -> None:
    """A flight of the flap is one panel whatever the block weighs, and ends where it does at 1 mg.

    A block of 1e-6 kg changes the motion by 1e-6 of itself; one of 4e-9 kg took up to 111 panels.
    """
    other = _run(1e-6)
    flights = [segment for segment in light.segments if not segment.kinematic]
    assert len(flights) > 30
    assert sum(len(segment.panels) for segment in flights) <= 1.2 * len(flights)
    assert light.evaluations <= 1.1 * other.evaluations
    for one, two in zip(light.events[:10], other.events, strict=False):
        assert one.stops == two.stops
        assert one.t == pytest.approx(two.t, rel=1e-4)


def test_a_nipper_whose_links_differ_by_ten_millions() -> None:
    """Rod and frame weigh tonnes, the links between them less than a gram: there was no motion.

    The energy balance of flights at a tolerance of 1e-12 is good to some hundred times that.
    """
    kilograms = {
        "bottom_nipper": 471.375442083462,
        "steeve_lower": 1801.9697304666279,
        "steeve_upper": 0.0004008692462020054,
        "rocker": 0.00018643569604475069,
        "eccentric": 49.118234732501925,
    }
    source = e62()
    root = ElementTree.fromstring(source.urdf)
    for part in root.iter("link"):
        mass, inertia = part.find("inertial/mass"), part.find("inertial/inertia")
        if part.get("name") in kilograms and mass is not None and inertia is not None:
            factor = kilograms[str(part.get("name"))] / float(mass.attrib["value"])
            for item in (mass, inertia):
                item.attrib.update({k: repr(float(x) * factor) for k, x in item.attrib.items()})
    urdf = ElementTree.tostring(root, encoding="unicode")
    changed = from_sources("e62", urdf, source.description, source.folder)
    solution = nip.simulate(changed, nip.Case(speed_rpm=316.0, window=nip.Window.CYCLE))
    assert len(solution.collisions) > 10
    assert solution.energy.relative < 1e-10


@pytest.fixture(scope="module")
def arm() -> nip.Mechanism:
    """A bead slides without friction on an arm that turns at constant speed, from 0.1 m on."""
    parts = [
        link("arm"), hinge("shaft", "frame", "arm"),
        link("bead", 1.0, 0.01), slide("out", "arm", "bead", at=(0.1, 0.0)),
    ]  # fmt: skip
    return machine(parts, 2, drives={"shaft": TURNING})


@pytest.mark.parametrize("turns", [1, 2])
def test_a_bead_on_a_turning_arm_is_thrown_outwards(arm: nip.Mechanism, turns: int) -> None:
    """r = r_0 cosh(angle): 27 m after one turn, 14 km after two."""
    there = turn(arm, cycles=turns).trajectory.evaluate(turns, left=True)
    wanted = 0.1 * (math.cosh(2.0 * math.pi * turns) - 1.0)
    assert there.q[0, 1] == pytest.approx(wanted, rel=1e-9)


def test_a_bead_that_leaves_for_ever_is_refused(arm: nip.Mechanism) -> None:
    """After four turns r would be 4e9 m, and more than 1e9 m of it one step; the joint is named.

    Thrown out to 1e15 m it had more inertia than the shaft that was to be held.
    """
    with pytest.raises(nip.SimulationError, match="joint out runs away") as caught:
        turn(arm, cycles=4)
    assert caught.value.evidence["moved"] > 1e9
