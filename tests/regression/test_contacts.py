"""Stops that touch, open and close within round-off, or in one instant."""

from __future__ import annotations

from dataclasses import replace
from math import acos, sqrt

import numpy as np
import pytest
from small_machines import SLED, TURNING, frame, hinge, link, machine, nipper, slide, turn

import nipper_pin as nip
from benchmarks.stress.checks.invariants import violations
from benchmarks.stress.machines.small_machines import bouncing_mass, flaps
from nipper_pin.arrays import FloatArray
from nipper_pin.chebyshev import nodes
from nipper_pin.dynamics import Partition, ShaftMotion, System, collide
from nipper_pin.hybrid.event_location.guards import _flight_root
from nipper_pin.hybrid.motion.panel import Panel
from nipper_pin.tolerances.hybrid import GAP_ROUND_OFF


@pytest.mark.parametrize("drive", list(nip.DriveMode))
def test_a_stop_that_closes_at_the_start_collides_there(drive: nip.DriveMode) -> None:
    """The table arrives under the mass at time zero, at lead times speed.

    A gap that was zero at the start and closing was never seen: the table passed through the mass,
    by a millimetre in this turn.
    """
    mechanism = bouncing_mass(mass=0.7, lead_mm=1.0, restitution=0.0, gravity=9.81).mechanism()
    solution = turn(mechanism, 180.0, drive=drive)
    first = solution.events[0]
    height = mechanism.stop("table").index
    assert (first.t, first.kind, first.stops[0]) == (0.0, nip.EventKind.COLLISION, "table")
    assert first.v_before[height] == pytest.approx(-3e-3, rel=1e-12)
    times = np.linspace(0.0, solution.trajectory.span[1], 50)
    assert solution.trajectory.evaluate(times).q[:, height].min() >= -1e-15


@pytest.fixture(scope="module")
def two_flaps() -> nip.Mechanism:
    return flaps(2, (0.3,), 0.5, 0.02, 10.0, 9.81).mechanism()


@pytest.mark.parametrize(("rate", "after"), [(0.0, 0.0), (3e-15, 0.0), (0.25, 0.25)])
def test_contacts_that_do_not_approach_take_no_impulse(
    two_flaps: nip.Mechanism, rate: float, after: float
) -> None:
    """P = 0 satisfies the law where every rate is positive; one that is round-off becomes zero.

    The arm turns at 1 rad/s, so 3e-15 rad/s is round-off and 0.25 rad/s is not. The law was not
    tried without an impulse: "these stops jam the mechanism".
    """
    system = System(two_flaps, ShaftMotion(two_flaps, 10.0, 0.0))
    q, v = np.zeros(3), np.array([1.0, rate, rate])
    impact = collide(system, q, v, np.empty((0, 3)), two_flaps.stops, [0.5, 0.5])
    assert set(impact.P_N.values()) == {0.0}
    assert not impact.delta.any()
    assert impact.energy_lost == 0.0
    assert impact.v_after.tolist() == [1.0, after, after]


def test_flaps_that_bounce_in_one_rhythm_come_to_rest() -> None:
    """No series of one stop described that: they touched without approach again and again."""
    swing = 0.02389812640351119, 0.22654876994566853, -0.3652977606771073
    three = flaps(3, swing, 0.5, 0.08450230233247534, 48.62970648878668, 0.0).mechanism()
    case = {"start_index": 11.809148731844, "max_collisions": 100}
    solution = turn(three, 35.930164672310816, **case)
    assert solution.outcome is nip.Outcome.COMPLETED
    assert all(len(hit.event.stops) == 3 for hit in solution.collisions)
    assert all(hit.approach_rate < 0.0 for hit in solution.collisions)
    rests = [event for event in solution.events if event.kind is nip.EventKind.REST]
    assert rests
    assert all(len(event.stops) == 3 for event in rests)


def closing(
    t: float, h: float, motion: tuple[FloatArray, ...], gap: float, rate: float
) -> float | None:
    """Where a gap closes that opens with a rate, on a panel of positions, rates, accelerations."""
    parts = [link("mass"), slide("x", "frame", "mass")]
    floor = machine(parts, 1, stops={"floor": {"joint": "x", "restitution": 0.2}}).stop("floor")
    panel = Panel(t, h, *motion, Partition((), (0,)), integrated=True)
    return _flight_root(panel, floor, gap, rate, GAP_ROUND_OFF)


def test_a_gap_that_opens_and_closes_within_round_off_ends_there() -> None:
    """A gap of 3e-22 m that opens at 1e-11 m/s and is pulled shut at 9.4 m/s2 is back after 2.5 ps.

    The first sample of a panel of 10 ms was its start plus round-off of the motion, -1e-20 m.
    """
    order, h, gap, rate, pull = 12, 1e-2, 2.868892e-22, 1.182589e-11, 9.43
    for share in np.linspace(0.9, 1.1, 21):
        t = h * nodes(order).sigma[:, None]
        a = np.full((order, 1), -pull * share)
        q, v = gap + rate * t + 0.5 * a * t**2, rate + a * t
        found = closing(0.0, h, (q, v, a), gap, rate)
        assert found is not None
        # Round-off of what the panel moves by, h^2 a, is all that may be left of the gap there.
        left = gap + rate * found - 0.5 * pull * share * found**2
        assert found >= 0.0
        assert abs(left) <= 64.0 * np.finfo(float).eps * h**2 * pull


@pytest.mark.parametrize("gap", [-1e-35, -1e-20, -3e-14])
def test_a_stop_that_opens_from_below_zero_and_closes_is_not_passed(gap: float) -> None:
    """A gap of -1e-35 rad, left by another collision, opens at 3e-8 rad/s and is pulled shut.

    On a panel of 17 ms all samples of it lay below zero, and were taken for a gap that had no time
    to open.
    """
    order, h, rate, pull = 13, 0.0175, 3.47e-8, 13.18
    t = h * nodes(order).sigma[:, None]
    a = np.full((order, 1), -pull)
    q, v = gap + rate * t + 0.5 * a * t**2, rate + a * t
    found = closing(0.0, h, (q, v, a), gap, rate)
    assert found == pytest.approx(2.0 * rate / pull, rel=1e-10)


@pytest.mark.parametrize("start", [0.0, 1e-9, 1e-3])
def test_a_stop_that_opens_without_a_pull_and_is_pressed_shut_closes_at_once(start: float) -> None:
    """Of a machine without weight, which accelerations of 1e-34 opened, and pushed shut again."""
    order, h, pull = 13, 0.02, 1e-33
    t = h * nodes(order).sigma[:, None]
    a = -pull * (start + t / h)
    v = -pull * (start * t + 0.5 * t**2 / h)
    q = -pull * (0.5 * start * t**2 + t**3 / (6.0 * h))
    assert closing(0.25, h, (q, v, a), 0.0, 0.0) == 0.25


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
    stops closed both pull, and both were opened at once. Together the carts go as x = 0.1 (1 - cos
    W t), W^2 = k / 2 m, and the force between them, m x'' - 1 N, is zero where 5 cos W t = 1: there
    the second stop opens.
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
    solution = turn(machine(parts, 2, springs=springs, stops=stops, phases=phases))
    first, *others = solution.events
    assert (first.kind, first.stops, first.t) == (nip.EventKind.RELEASE, ("a",), 0.0)
    rest = [event for event in others if event.t == 0.0]
    assert [event.stops for event in rest] == ([("b",)] if closed == ["a"] else [])
    opens = next(event for event in others if event.kind is nip.EventKind.RELEASE)
    W = sqrt(50.0)
    assert opens.stops == ("b",)
    assert opens.t == pytest.approx(acos(0.2) / W, rel=1e-11)
    t = np.linspace(0.0, opens.t, 20)[:-1]
    q = solution.trajectory.evaluate(t).q
    assert q[:, 0] == pytest.approx(0.1 * (1.0 - np.cos(W * t)), abs=1e-12)
    assert not q[:, 1].any()
    assert violations(solution) == []


def press(restitution: float) -> nip.Mechanism:
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
    with pytest.raises(nip.ImpactError, match=r"ceiling.*floor|floor.*ceiling") as caught:
        turn(press(restitution))
    assert caught.value.evidence["t"] == pytest.approx(0.8, abs=1e-12)
    assert "please report" not in caught.value.message


def test_lively_stops_that_only_come_near_are_no_jam() -> None:
    """A mass that loses nothing rattles 40 times before the gap is gone, and nothing is wrong.

    Twenty collisions in one instant are a jam, and these are none.
    """
    solution = turn(press(1.0), max_collisions=40)
    assert len(solution.collisions) == 40
    assert {hit.stop for hit in solution.collisions} == {"floor", "ceiling"}
    assert violations(solution) == []


def test_what_a_collision_leaves_open_is_no_fault_of_the_rest_that_follows() -> None:
    """A heavy block in a slot, stopped by 1e-12: round-off of its closure stays, more is found.

    The rest follows its collision at once, which had taken 0.07 m/s away up to 57 units of
    round-off.
    """
    parts = [
        link("first", 0.5697251581736106),
        slide("j0", "frame", "first", (-0.9701136452817515, 0.24265101532479125)),
        link("second", 3.683221315325442),
        slide("j1", "first", "second", (0.9684517740150778, 0.2492010461596196)),
        frame("tip", "second", (0.5437712629483043, -0.1689902628039441)),
        frame("rail", "frame", (0.5437712629483043, -0.1689902628039441), 0.7250612323188824),
    ]  # fmt: skip
    solution = turn(
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
        tolerance=2e-11,
    )  # fmt: skip
    collision, rest = solution.events
    assert (collision.kind, rest.kind) == (nip.EventKind.COLLISION, nip.EventKind.REST)
    G = solution.system.body.closures(rest.q[None])[1][0]
    # What the collision leaves of the closures' rates, and at least some round-off of its own.
    left = np.abs(G @ collision.v_after).max()
    left += 16.0 * np.finfo(float).eps * np.abs(G).max() * np.abs(collision.v_before).max()
    assert violations(solution) == []

    opening = np.linalg.pinv(G) @ np.full(len(G), 3.0 * left)
    doctored = replace(rest, delta=rest.delta + opening, v_after=rest.v_after + opening)
    found = violations(replace(solution, events=(collision, doctored)))
    assert any("closure rate of v_after" in item.detail for item in found)


def test_of_two_forces_that_vanish_together_one_comes_back() -> None:
    """A yoke swings as r cos w t and carries a pendulum, which carries a slide, each on a stop.

    The yoke's acceleration is zero at a quarter of a turn, in closed form; all are zero then, so
    they do not tell which stop opens. The pendulum leaves its stop; what it carries is pressed on
    again, and could not fall through its stop.
    """
    parts = [
        link("crank", 2.0, 0.01, (0.01, 0.0)), hinge("shaft", "frame", "crank"),
        frame("pin", "crank", (0.2, 0.0)),
        link("yoke", 1.5, 0.01), slide("x", "frame", "yoke", at=(0.2, 0.0)),
        frame("line", "yoke", (0.0, 0.0)),
        link("b0", 0.81, 0.0137, (0.0676, -0.2666)), hinge("j0", "yoke", "b0", (0.07, 0.16)),
        link("b1", 0.047, 4.7e-4, (0.17, -0.165)),
        slide("j1", "b0", "b1", (-0.7071, -0.7071), (0.078, -0.36)),
    ]  # fmt: skip
    mechanism = machine(
        parts, 3,
        drives={"shaft": TURNING},
        closures={"slot": {"frame_a": "line", "frame_b": "pin", "slot_axis": "z",
                           "block_mass_kg": 0.003}},
        stops={
            "upper": {"joint": "j0", "restitution": 0.0, "side": "upper", "at_deg": 0.0},
            "lower": {"joint": "j1", "restitution": 0.0, "side": "lower", "at_mm": 0.0},
        },
        phases=[{"number": 1, "name": "held", "closed": ["upper", "lower"]}],
    )  # fmt: skip
    solution = turn(mechanism)
    first = solution.events[0]
    assert first.kind is nip.EventKind.RELEASE
    assert first.t == pytest.approx(0.25, abs=1e-13)
    assert first.stops == ("upper",)
    assert first.closed_after == {"lower"}
    t = [0.25 + 1e-4 * k for k in range(1, 20)]
    ahead = solution.trajectory.evaluate(t)
    assert (ahead.q[:, mechanism.stop("lower").index] == 0.0).all()
    assert (mechanism.stop("upper").gaps(ahead.q) > 0.0).all()
    assert solution.energy.relative < 1e-10


def test_events_of_coarse_runs_meet_the_closures() -> None:
    """At every event g = 0 and G v = 0 to round-off, at a tolerance of 1e-3.

    A stop that depends on another one through the closures had its gap set to zero by hand, and the
    others stayed where they were: 8e-9 were left.
    """
    numbers = 0.19095002553832346, 0.4997024793025926, 6622.197350980627, 7.149651349551252
    resolution = nip.Resolution(
        tolerance=1e-3, flight_nodes=12, kinematic_nodes=8, panels_per_turn=31
    )
    case = nip.Case(speed_rpm=634.7158522014964, window=nip.Window.CYCLE, resolution=resolution)
    solution = nip.simulate(nipper(*numbers), case)
    body = solution.system.body
    stops = {event.stops[0] for event in solution.events}
    assert stops == {"jaw", "steeve"}
    for event in solution.events:
        g, jacobian = body.closures(event.q[None])
        assert np.abs(g).max() <= 1e-13
        for v in (event.v_before, event.v_after):
            # Rates are those at a gap that is zero to 1e-14.
            assert np.abs(jacobian[0] @ v).max() <= 1e-12 * np.abs(v).max()


@pytest.mark.parametrize("tolerance", [1e-4, 1e-6, 1e-10])
def test_the_gap_closes_where_it_does(tolerance: float) -> None:
    """A steeve stands just off its stop on a closed jaw: by -4e-17 m, which open by 5e-12 m and
    close.

    That was before the first place at which a coarse panel was looked at: it went 1 mm through its
    stop. The time is that of an 80-bit solution, to what is stated.
    """
    numbers = 0.1989706720242519, 0.042420346058545305, 4849.703423371149, 11.279290966650025
    model = nipper(*numbers, cylinder__angle_at_touch_deg=115.58298052068753)
    resolution = nip.Resolution(tolerance=tolerance)
    case = nip.Case(speed_rpm=607.3992693621092, window=nip.Window.CYCLE, resolution=resolution)
    solution = nip.simulate(model, case)
    place = next(
        number
        for number, event in enumerate(solution.events)
        if event.kind is nip.EventKind.COLLISION and event.closed_before == frozenset(["jaw"])
    )
    hit, error = solution.events[place], solution.errors[place]
    assert hit.stops == ("steeve",)
    assert abs(hit.t - 0.038650563990750886663) <= error.time < 1e-9
    assert solution.phases[-1].closed == frozenset(["steeve"])
    steeve = model.stop("steeve").index
    times = [solution.events[-1].t + part * 1e-3 for part in range(9)]
    assert (solution.trajectory.evaluate(times).q[:, steeve] >= -1e-12).all()


@pytest.mark.parametrize("panels", range(3, 8))
def test_first_contact_at_the_end_of_a_panel_is_not_missed(e62: nip.Mechanism, panels: int) -> None:
    """Cycles that start whole panels before the touch, and a hair more or less.

    The zero lay behind one panel and before the other by round-off, and the lips passed through
    each other, by 0.07 rad.
    """
    touch = e62.cylinder.index_from_angle(e62.cylinder.angle_at_touch_rad)
    jaw = e62.stop("jaw").index
    start = touch - 40.0 * panels / 12.0
    found = 0
    for off in (-4e-15, -2e-15, 0.0, 2e-15, 4e-15):
        case = nip.Case(speed_rpm=115.6, window=nip.Window.CYCLE, start_index=start + off)
        solution = nip.simulate(e62, case)
        times = np.linspace(0.0, solution.trajectory.span[1], 200)
        assert solution.trajectory.evaluate(times).q[:, jaw].min() >= -1e-12
        found += any(hit.stop == "jaw" for hit in solution.collisions)
    assert found == 5
