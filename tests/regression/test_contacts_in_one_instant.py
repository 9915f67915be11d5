"""Found by the stress campaign: stops that open, close and strike one another in one instant.

"stop 'j1 upper' penetrates: 1.03e-06, at most 1.55e-09" and "open but its gap starts to close from
zero": at the start all stops that pull were opened at once, and one of them pushes once the others
are open. "open stop 'bottom' enters its contact with -1.15" and "please report the case": a link
that held drives press against two stops at once flew from one to the other for ever. Case 7276 of
seed 291: "impulses 8.63235e-08 and 8.63235e-08, stated 6.76e-10 of them": a link between two stops
that are hit in turn in one instant had, at the end of a flight of no length, the round-off of an
integral over a long panel for its rate. In case 5636 of seed 371, "closure rate of v_after:
8.58e-16, at most 2.4e-16", the check was wrong: where the restitution is 1e-12 a stop comes to rest
right after its collision, which had taken 0.07 m/s away up to 57 units of round-off.
"""

from __future__ import annotations

from dataclasses import replace
from math import acos, sqrt

import numpy as np
import pytest
from small_machines import SLED, frame, link, machine, slide

from benchmarks.stress.checks.invariants import violations
from nipper_pin import Case, EventKind, ImpactError, Mechanism, Resolution, Window, simulate
from nipper_pin.dynamics import Partition
from nipper_pin.hybrid.motion.panel import Panel

TURN = Case(speed_rpm=60.0, window=Window.CYCLE, start_index=0.0)


@pytest.mark.parametrize("order", [13, 16])
def test_a_flight_of_no_length_ends_with_the_state_of_its_start(order: int) -> None:
    """At rest on a panel of a millisecond with 2e4 m/s2: round-off of its integral is 5e-16 m/s."""
    a = 2e4 * np.cos(np.arange(order, dtype=float))[:, None]
    still = np.zeros((order, 1))
    panel = Panel(0.3, 1e-3, still, still, a, Partition.of([], 1), integrated=True)
    q, v = panel.interpolate_at(0.3)
    assert q[0] == 0.0
    assert v[0] == 0.0


@pytest.mark.parametrize("closed", [["a", "b"], ["a"]])
def test_stops_that_pull_at_the_start_open_by_complementarity(closed: list[str]) -> None:
    """A cart leaves its stop and carries a second one, which would pull if the first one stayed.

    Springs push the first cart off with 10 N and the second one off the first with 1 N. With both
    stops closed both pull. Together the two carts go as x = 0.1 (1 - cos W t), W^2 = k / 2 m, and
    the force between them, m x'' - 1 N, is zero where 5 cos W t = 1: there the second stop opens.
    """
    parts = [
        link("a", 1.0), slide("a_x", "frame", "a"),
        link("b", 1.0), slide("b_x", "a", "b"),
    ]  # fmt: skip
    springs = {
        "one": {"joint": "a_x", "stiffness_N_per_m": 100.0, "preload_length_mm": -100.0},
        "two": {"joint": "b_x", "stiffness_N_per_m": 10.0, "preload_length_mm": -100.0},
    }
    stops = {
        "a": {"joint": "a_x", "restitution": 0.5}, "b": {"joint": "b_x", "restitution": 0.5}
    }  # fmt: skip
    phases = [{"number": 1, "name": "start", "closed": closed}]
    solution = simulate(machine(parts, 2, springs=springs, stops=stops, phases=phases), TURN)
    first, *others = solution.events
    assert (first.kind, first.stops, first.t) == (EventKind.RELEASE, ("a",), 0.0)
    rest = [event for event in others if event.t == 0.0]
    assert [event.stops for event in rest] == ([("b",)] if closed == ["a"] else [])
    opens = next(event for event in others if event.kind is EventKind.RELEASE)
    W = sqrt(50.0)
    assert opens.stops == ("b",)
    assert opens.t == pytest.approx(acos(0.2) / W, rel=1e-11)
    t = np.linspace(0.0, opens.t, 20)[:-1]
    q = solution.trajectory.evaluate(t).q
    assert q[:, 0] == pytest.approx(0.1 * (1.0 - np.cos(W * t)), abs=1e-12)
    assert not q[:, 1].any()
    assert violations(solution) == []


def press(restitution: float) -> Mechanism:
    """A floor that a screw lifts by 0.1 m/s, 80 mm below a ceiling, and a mass between them."""
    parts = [
        link("floor"), slide("lift", "frame", "floor", (0.0, 1.0)),
        link("mass", 0.5), slide("height", "floor", "mass", (0.0, 1.0)),
        link("hanger", 1e-3), slide("hanger_z", "frame", "hanger", (0.0, 1.0)),
        link("carriage", 1e-3), slide("hanger_x", "hanger", "carriage"),
    ]  # fmt: skip
    return machine(
        parts, 2, gravity=0.0,
        drives={"lift": {"joint": "lift", "law": "screw", "lead_mm_per_turn": 100.0, **SLED}},
        stops={
            "floor": {"joint": "height", "restitution": restitution, "at_mm": -30.0},
            "ceiling": {
                "joint": "hanger_z", "restitution": restitution, "side": "upper", "at_mm": 50.0
            },
        },
        closures={"tie": {"frame_a": "carriage", "frame_b": "mass"}},
        phases=[{"number": 1, "name": "start", "closed": []}],
    )  # fmt: skip


@pytest.mark.parametrize("restitution", [0.5, 0.9])
def test_a_mass_between_a_held_floor_and_a_ceiling_is_jammed(restitution: float) -> None:
    """Floor and ceiling meet the mass at 0.08 m / (0.1 m/s), and nothing goes on from there.

    Before that the mass flies between them in times that shrink like the gap; their sum is finite.
    What is refused is the instant in which they meet, with the names of both stops.
    """
    with pytest.raises(ImpactError, match=r"ceiling.*floor|floor.*ceiling") as caught:
        simulate(press(restitution), TURN)
    assert caught.value.evidence["t"] == pytest.approx(0.8, abs=1e-12)
    assert "please report" not in caught.value.message


def test_lively_stops_that_only_come_near_are_no_jam() -> None:
    """A mass that loses nothing rattles 40 times before the gap is gone, and nothing is wrong.

    Twenty collisions in one instant are a jam, and these are none.
    """
    solution = simulate(press(1.0), Case(speed_rpm=60.0, window=Window.CYCLE, start_index=0.0,
                                         max_collisions=40))  # fmt: skip
    assert len(solution.collisions) == 40
    assert {hit.stop for hit in solution.collisions} == {"floor", "ceiling"}
    assert violations(solution) == []


def test_what_a_collision_leaves_open_is_no_fault_of_the_rest_that_follows() -> None:
    """A heavy block in a slot, stopped by 1e-12: round-off of its closure stays, more is found."""
    parts = [
        link("first", 0.5697251581736106),
        slide("j0", "frame", "first", (-0.9701136452817515, 0.24265101532479125)),
        link("second", 3.683221315325442),
        slide("j1", "first", "second", (0.9684517740150778, 0.2492010461596196)),
        frame("tip", "second", (0.5437712629483043, -0.1689902628039441)),
        frame("rail", "frame", (0.5437712629483043, -0.1689902628039441), 0.7250612323188824),
    ]  # fmt: skip
    solution = simulate(
        machine(
            parts, 1,
            closures={"rail": {"frame_a": "rail", "frame_b": "tip", "slot_axis": "x",
                               "block_mass_kg": 368.3221315325442}},
            springs={"one": {"joint": "j0", "stiffness_N_per_m": 5.81939763523595,
                             "preload_length_mm": 90.85009049053058},
                     "two": {"joint": "j1", "stiffness_N_per_m": 42.70725816157991,
                             "preload_length_mm": -321.1211698370899}},
            dampers={"one": {"joint": "j0", "damping_N_s_per_m": 0.5226940542238843},
                     "two": {"joint": "j1", "damping_N_s_per_m": 0.001},
                     "rail": {"joint": "rail", "damping_N_s_per_m": 0.001}},
            stops={"upper": {"joint": "j1", "restitution": 1e-12, "side": "upper",
                             "at_mm": 21.946137239941073}},
        ),
        replace(TURN, resolution=Resolution(tolerance=2e-11)),
    )  # fmt: skip
    collision, rest = solution.events
    assert (collision.kind, rest.kind) == (EventKind.COLLISION, EventKind.REST)
    G = solution.system.body.closures(rest.q[None])[1][0]
    # What the collision leaves of the closures' rates, and at least some round-off of its own.
    left = np.abs(G @ collision.v_after).max()
    left += 16.0 * np.finfo(float).eps * np.abs(G).max() * np.abs(collision.v_before).max()
    assert violations(solution) == []

    opening = np.linalg.pinv(G) @ np.full(len(G), 3.0 * left)
    doctored = replace(rest, delta=rest.delta + opening, v_after=rest.v_after + opening)
    found = violations(replace(solution, events=(collision, doctored)))
    assert any("closure rate of v_after" in item.detail for item in found)
