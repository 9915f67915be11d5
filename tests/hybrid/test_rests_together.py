"""Several stops that bounce, in step or each for itself, and the states in which they rest."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest
from mpmath import mp, mpf
from small_machines import SLED, link, machine, slide, turn

from nipper_pin import Case, Event, EventKind, Mechanism, Outcome, Solution, Window, simulate
from nipper_pin.dynamics import Impact
from nipper_pin.dynamics.constraint_set import parts as parts_of
from nipper_pin.hybrid import State
from nipper_pin.hybrid.history import Closed
from nipper_pin.hybrid.run.phase_manager import EventLog
from nipper_pin.hybrid.run.series.bounces import Change

GRAVITY = 9.81

Ball = tuple[float, float]

"""Restitution, height of fall [m]."""


def balls(items: Sequence[Ball]) -> Mechanism:
    """Balls beside one another, which fall from rest; none touches another one."""
    parts, stops = [], {}
    for i, (e_N, height) in enumerate(items):
        parts += [link(f"ball{i}"), slide(f"z{i}", "frame", f"ball{i}", (0.0, 1.0))]
        stops[f"floor{i}"] = {"joint": f"z{i}", "restitution": e_N, "at_mm": -1e3 * height}
    return machine(parts, len(items), gravity=GRAVITY, stops=stops)


def carriage(items: Sequence[Ball], mass: float, force: float) -> Mechanism:
    """Balls of 1 kg on a carriage that is free to move, each drawn to its stop on the carriage."""
    parts = [link("carriage", mass), slide("z", "frame", "carriage", (0.0, 1.0))]
    stops, springs = {}, {}
    for i, (e_N, height) in enumerate(items):
        parts += [link(f"ball{i}"), slide(f"z{i}", "carriage", f"ball{i}", (0.0, 1.0))]
        stops[f"floor{i}"] = {"joint": f"z{i}", "restitution": e_N, "at_mm": -1e3 * height}
        springs[f"pull{i}"] = {
            "joint": f"z{i}", "coordinate_mm": [-1e3, 1e3], "force_N": [force, force]
        }  # fmt: skip
    return machine(parts, len(items) + 1, stops=stops, springs=springs)


def rest_in_closed_form(ball: Ball, acceleration: float = GRAVITY) -> float:
    """t_1 (1 + e) / (1 - e) of a ball that falls from rest [s]."""
    with mp.workdps(40):
        e_N, height = mpf(ball[0]), mpf(1e3 * ball[1]) / 1000
        return float(mp.sqrt(2 * height / mpf(acceleration)) * (1 + e_N) / (1 - e_N))


def run(mechanism: Mechanism, last: float, **case: object) -> Solution:
    """One turn that lasts a fifth longer than a time [s]."""
    numbers = {"speed_rpm": 50.0 / last, "window": Window.CYCLE, **case}
    return simulate(mechanism, Case(**numbers))  # type: ignore[arg-type]


def fallen(items: Sequence[Ball]) -> Solution:
    """A turn in which all balls come to rest."""
    return run(balls(items), max(map(rest_in_closed_form, items)))


def rests(solution: Solution) -> dict[str, Event]:
    """The rest of every stop."""
    found = [event for event in solution.events if event.kind is EventKind.REST]
    return {name: event for event in found for name in event.stops}


def check_balls(solution: Solution, items: Sequence[Ball]) -> None:
    """Each rest lies where the closed form has it: to 1e-12, and within what is stated."""
    assert solution.outcome is Outcome.COMPLETED
    found = rests(solution)
    for i, ball in enumerate(items):
        event, exact = found[f"floor{i}"], rest_in_closed_form(ball)
        off = abs(event.t - exact)
        assert off <= 1e-12 * exact
        assert off <= solution.errors[event.number - 1].time
    assert all(hit.approach_rate < 0.0 for hit in solution.collisions)


@pytest.mark.parametrize("later", [0, 1])
def test_limits_that_one_collision_shows_are_each_at_its_time(later: int) -> None:
    """Two balls land at once and are so slow that both limits are known; one is the later one.

    The event of each has its ball alone, and at the second one both lie still.
    """
    items = [(0.1, 5e-6), (0.1, 5e-6)]
    items[later] = (0.3, 5e-6)
    solution = turn(balls(items), tolerance=1e-3)
    hit, *found = solution.events
    assert hit.kind is EventKind.COLLISION
    assert [event.kind for event in found] == [EventKind.REST, EventKind.REST]
    names = [f"floor{1 - later}", f"floor{later}"]
    assert [event.stops for event in found] == [(name,) for name in names]
    assert found[0].closed_after == {names[0]}
    assert found[1].closed_after == set(names)
    assert found[1].v_after.tolist() == [0.0, 0.0]
    for event in found:
        off = abs(event.t - rest_in_closed_form(items[int(event.stops[0][-1])]))
        assert off <= min(1e-12 * event.t, solution.errors[event.number - 1].time)


@pytest.mark.parametrize("pulled", [0, 1])
def test_a_stop_that_nothing_presses_shut_does_not_rest(pulled: int) -> None:
    """Two balls land at once, slower than ``rest_rate``; one of them is pulled off its floor.

    It flies on as a ball does that is thrown up at e v, and the other one lies still.
    """
    parts, stops, springs, initial = [], {}, {}, {}
    for i in range(2):
        parts += [link(f"ball{i}"), slide(f"z{i}", "frame", f"ball{i}", (0.0, 1.0))]
        stops[f"floor{i}"] = {"joint": f"z{i}", "restitution": 0.5}
        force = -1.0 if i == pulled else 1.0
        springs[f"pull{i}"] = {
            "joint": f"z{i}", "coordinate_mm": [-1e3, 1e4], "force_N": [force, force]
        }  # fmt: skip
        # So that each comes to its floor after 0.1 s, at 0.1 m/s.
        initial[f"z{i}"] = {"at_mm": 10.0 - 5.0 * force, "rate_mm_per_s": 100.0 * (force - 1.0)}
    thrown = machine(parts, 2, stops=stops, springs=springs, initial=initial)
    solution = turn(thrown, rest_rate=0.06)
    hit, rest = solution.events
    assert set(hit.stops) == {"floor0", "floor1"}
    assert (rest.kind, rest.stops) == (EventKind.REST, (f"floor{1 - pulled}",))
    assert hit.t == pytest.approx(0.1, rel=1e-12)
    places = solution.trajectory.evaluate(hit.t + 0.5).q[0]
    assert places[pulled] == pytest.approx(0.05 * 0.5 + 0.5 * 0.5**2, rel=1e-12)
    assert places[1 - pulled] == 0.0


@pytest.mark.parametrize(
    "items",
    [
        [(0.4, 0.2), (0.4 + 1e-9, 0.2)],
        [(0.4, 0.2), (0.4 + 1e-12, 0.2)],
        [(0.4, 0.2), (0.4 + 1e-15, 0.2)],
        [(0.4, 0.2), (0.4, 0.2 + 1e-9)],
        [(0.4, 0.2), (0.4, 0.2 + 1e-12)],
        [(0.4, 0.2), (0.4, 0.2 + 1e-14)],
        [(0.7, 0.2), (0.7, 0.2), (0.7 + 1e-12, 0.2)],
    ],
)
def test_balls_nearly_in_step_come_to_rest(items: list[Ball]) -> None:
    """However little they differ, each has its own rest, within what is stated of it."""
    check_balls(fallen(items), items)


@pytest.mark.parametrize(
    "items",
    [
        [(0.4, 0.2), (0.4, 0.3)],
        [(0.4, 0.2), (0.6, 0.2), (0.5, 0.2)],
        [(0.0, 0.2), (0.6, 0.2)],
        [(0.3, 0.2), (0.6, 0.1), (0.5, 0.25), (0.45, 0.17), (0.7, 0.05)],
        [(0.97, 0.1), (0.3, 0.2)],
    ],
)
def test_each_ball_does_what_it_does_alone(items: list[Ball]) -> None:
    """As many collisions at the same times, whatever the others do; and rebounds of its own.

    A rest lies beyond the last collision that is computed, and the others strike before its time.
    """
    together = fallen(items)
    check_balls(together, items)
    assert [event.t for event in together.events] == sorted(event.t for event in together.events)
    closed = frozenset[str]()
    for number, event in enumerate(together.events, start=1):
        assert event.number == event.source == number
        assert event.closed_before == closed
        closed = event.closed_after
    assert together.checks.energy_balance < 1e-12
    for i, ball in enumerate(items):
        alone = run(balls([ball]), max(map(rest_in_closed_form, items)))
        mine = [hit for hit in together.collisions if hit.stop == f"floor{i}"]
        # The last bits of the rates decide which bounce is the last that is followed.
        assert abs(len(mine) - len(alone.collisions)) <= 1
        for one, other in zip(mine, alone.collisions, strict=False):
            assert one.t == pytest.approx(other.t, rel=1e-13)
            assert one.rebound_time == pytest.approx(other.rebound_time, rel=1e-9)
            assert one.rebound_amplitude == pytest.approx(other.rebound_amplitude, rel=1e-9)


@pytest.mark.sampled(8)
@pytest.mark.parametrize("e_N", [0.98, 0.985, 0.99, 0.995, 0.998])
@pytest.mark.parametrize("height", [0.003, 0.2, 1.0])
def test_high_restitution(e_N: float, height: float) -> None:
    """The limit of a ball that loses little is known early: a few hundred bounces are followed."""
    solution = fallen([(e_N, height)])
    check_balls(solution, [(e_N, height)])
    assert len(solution.collisions) <= 200


@pytest.mark.campaign
@pytest.mark.parametrize(
    "items", [[(0.999, 1.0)], [(0.9999, 0.01)], [(0.9999, 0.2), (0.9999, 0.1)], [(0.99, 0.2)] * 3]
)
def test_highest_restitution(items: list[Ball]) -> None:
    """The same, of balls that would bounce a hundred thousand times."""
    solution = fallen(items)
    check_balls(solution, items)
    assert len(solution.collisions) <= 200 * len(items)


def test_a_short_fall_in_a_long_turn_is_located_to_round_off() -> None:
    """The first collision is right to 1e-13 of its own time, in a turn twenty thousand times that.

    The first panel of a flight is a part of a turn; its round-off goes with the square of that.
    """
    solution = run(balls([(0.5, 1.0)]), 9000.0)
    exact = float(mp.sqrt(mpf(2) / mpf(GRAVITY)))
    assert solution.collisions[0].t == pytest.approx(exact, rel=1e-13)
    assert solution.collisions[0].approach_rate == pytest.approx(-GRAVITY * exact, rel=1e-12)


@pytest.mark.sampled(4)
@pytest.mark.parametrize("count", [2, 3, 5])
@pytest.mark.parametrize(("e_N", "mass"), [(0.3, 2.0), (0.7, 0.5), (0.7, 20.0)])
def test_balls_on_one_carriage_in_step(e_N: float, mass: float, count: int) -> None:
    """Relative to the carriage each falls with F (1 / m + n / M): the same as one ball."""
    force, items = 10.0, [(e_N, 0.2)] * count
    exact = rest_in_closed_form(items[0], force * (1.0 + count / mass))
    solution = run(carriage(items, mass, force), exact)
    assert solution.outcome is Outcome.COMPLETED
    (event,) = set(rests(solution).values())
    assert event.stops == tuple(sorted(f"floor{i}" for i in range(count)))
    assert event.t == pytest.approx(exact, rel=1e-12)
    assert abs(event.t - exact) <= solution.errors[event.number - 1].time
    # What moved the carriage is over: the centre of mass has stayed where it was.
    end = solution.trajectory.evaluate(solution.trajectory.span[1])
    assert np.abs(end.v).max() <= 1e-11


def test_a_rebound_that_is_left_out_has_its_height_past_the_strikes_of_others() -> None:
    """On one carriage another ball strikes while the last rebound of this one goes on unseen.

    A finer run computes that very rebound, before its own rest is known.
    """
    bouncing = carriage([(0.4, 0.2), (0.5, 0.2)], 20.0, 10.0)
    coarse, fine = (turn(bouncing, 20.0, tolerance) for tolerance in (1e-8, 1e-10))
    last = coarse.collisions[-1]
    _, flown = last.rebounds.until(last.event, last.stop)
    assert flown is not None
    assert len(flown) > 2
    hits = [hit for hit in fine.collisions if hit.stop == last.stop]
    same = min(hits, key=lambda hit: abs(hit.t - last.t))
    assert same is not hits[-1]
    assert last.rebound_amplitude == pytest.approx(same.rebound_amplitude, rel=1e-8)
    assert last.rebound_time == pytest.approx(same.rebound_time, rel=1e-8)


@pytest.mark.parametrize(
    ("held", "parts"), [(True, [{"a"}, {"b", "c"}]), (False, [{"a", "b", "c"}])]
)
def test_parts_of_a_machine(held: bool, parts: list[set[str]]) -> None:
    """Sliders on a driven sled do not touch one another, unless the drive yields; a strut does."""
    sliders = [
        item
        for place, name in enumerate("abc")
        for item in (link(name), slide(f"z{name}", "sled", name, (0.0, 1.0), (0.1 * place, 0.0)))
    ]
    tie = {"frame_a": "b", "frame_b": "c", "stiffness_N_per_m": 1.0, "free_length_mm": 10.0}
    mechanism = machine(
        [link("sled"), slide("x", "frame", "sled"), *sliders],
        4,
        stops={name: {"joint": f"z{name}", "restitution": 0.5} for name in "abc"},
        drives={"cam": {"joint": "x", "law": "screw", "lead_mm_per_turn": 100.0, **SLED}},
        springs={"tie": tie},
    )
    found = parts_of(mechanism, held).stops
    assert {frozenset(part) for part in parts} == set(found.values())
    assert all(name in found[name] for name in "abc")


def stack(items: Sequence[Ball], raised: bool, **keys: object) -> Mechanism:
    """Balls above one another; coordinates are zero where they meet, or where they start."""
    parts, stops, initial = [], {}, {}
    for i, (e_N, height) in enumerate(items):
        below = f"ball{i - 1}" if i else "frame"
        parts += [link(f"ball{i}", 1.0 + 0.3 * i), slide(f"z{i}", below, f"ball{i}", (0.0, 1.0))]
        stops[f"stop{i}"] = {"joint": f"z{i}", "restitution": e_N}
        if raised:
            initial[f"z{i}"] = {"at_mm": 1e3 * height}
        else:
            stops[f"stop{i}"]["at_mm"] = -1e3 * height
    return machine(parts, len(items), gravity=GRAVITY, stops=stops, initial=initial, **keys)


@pytest.mark.sampled(5)
@pytest.mark.parametrize("law", ["newton", "sequential"])
@pytest.mark.parametrize("raised", [True, False])
@pytest.mark.parametrize(
    "items",
    [
        # Without digits left, these struck one another for ever.
        [(0.7525599295306892, 0.2), (0.6158895531772997, 0.07464945569912056)],
        [(0.8245050677260921, 0.2), (0.6814295764188614, 0.0), (0.40782076080165663, 0.0894)],
        [(0.5, 0.2), (0.76, 0.08)],
        [(0.3, 0.1), (0.9, 0.03), (0.6, 0.0)],
        [(0.26, 0.2), (0.76, 0.08), (0.77, 0.0), (0.79, 0.065)],
    ],
)
def test_balls_above_one_another_rest(items: list[Ball], raised: bool, law: str) -> None:
    """Stops that end one another's series: all rest, and all that was lost is the fall of the pile.

    The floor bears the pile then, which has fallen by the heights, each ball with all above it.
    """
    solution = run(stack(items, raised, simultaneous=law), 20.0, max_collisions=2000)
    assert solution.outcome is Outcome.COMPLETED
    assert solution.events[-1].closed_after == {f"stop{i}" for i in range(len(items))}
    masses = [1.0 + 0.3 * i for i in range(len(items))]
    fallen_by = np.cumsum([height for _, height in items])
    weight = GRAVITY * sum(m * z for m, z in zip(masses, fallen_by, strict=True))
    lost = sum(event.energy_lost for event in solution.events)
    assert lost == pytest.approx(weight, rel=1e-9)
    forces = solution.trajectory.reactions(np.array([0.99 * solution.shaft.period]))
    for i in range(len(items)):
        assert forces.stops[f"stop{i}"][0] == pytest.approx(GRAVITY * sum(masses[i:]), rel=1e-12)


def test_a_free_coordinate_goes_on_to_the_time_of_rest() -> None:
    """A ball comes to rest on its floor while a second one falls on: z = -g t2 / 2."""
    mechanism = balls([(0.5, 1e-3), (0.5, 1e3)])
    solution = simulate(mechanism, Case(speed_rpm=60.0, window="cycle"))
    rest = next(item for item in solution.events if item.kind is EventKind.REST)
    # sqrt(2 h / g) (1 + e) / (1 - e) for a fall from h.
    assert rest.t == pytest.approx(3.0 * np.sqrt(2e-3 / 9.81), rel=1e-12)
    motion = solution.motion_at(rest)
    assert motion.q[0] == pytest.approx([-1e-3, -0.5 * 9.81 * rest.t**2], abs=1e-13)
    assert motion.v[0] == pytest.approx([0.0, -9.81 * rest.t], abs=1e-12)
    (hit, *_) = solution.collisions
    same = solution.motion_at(hit.event)
    assert (same.q[0] == hit.event.q).all()
    assert (same.v[0] == hit.event.v_after).all()


@pytest.mark.parametrize(("rest", "there", "error"), [(1.0, 0.9, 0.1 + 1e-6), (0.8, 0.8, 1e-6)])
def test_a_rest_that_is_brought_forward_is_off_by_what_it_was_moved(
    rest: float, there: float, error: float
) -> None:
    """A limit that lies beyond the next event, a collision at 0.9 s, is put there."""
    none = np.zeros(1)
    impact = Impact(none, none, np.zeros(0), {}, 0.0)
    state = State(0.5, none, none, np.zeros((0, 1)), (none, none, none), Closed())
    log = EventLog(lambda _: frozenset({"jaw", "steeve"}))
    log.record(EventKind.REST, state, Change(rest, 1e-6, ["jaw"], impact, Closed()))
    log.record(EventKind.COLLISION, state, Change(0.9, 0.0, ["steeve"], impact, Closed()))
    first, hit = log.events
    assert (first.t, hit.t) == (there, 0.9)
    assert first.series_error == pytest.approx(error, rel=1e-12)
