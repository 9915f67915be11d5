"""Stops that are struck in one event: a row for each, with its own numbers and stated errors."""

from __future__ import annotations

import json
import math
from typing import Any

import mpmath
import pytest
from small_machines import frame, hinge, link, machine, slide, turn
from units_shown import rows as csv_rows

import nipper_pin as nip
from nipper_pin.hybrid.result.rebound_errors import rebound_error
from nipper_pin.hybrid.result.turns import reported_turn
from nipper_pin.mechanism import Simultaneous

G = 9.81


MASSES = (1.0, 2.0, 3.0)

RESTITUTIONS = (0.3, 0.6, 0.9)


def falling(
    heights: tuple[float, ...],
    restitutions: tuple[float, ...] = RESTITUTIONS,
    rates: tuple[float, ...] = (0.0, 0.0, 0.0),
    *,
    sled: bool = False,
) -> nip.Mechanism:
    """Balls of 1, 2 and 3 kg at heights [m] above floors of their own, with rates [m/s].

    On a sled that nothing pushes they are one part of a machine, and move as without it.
    """
    parts = [link("sled", 1.0), slide("x", "frame", "sled", axis=(1.0, 0.0))] if sled else []
    home = "sled" if sled else "frame"
    stops, initial = {}, {}
    for place, (height, e_N, rate) in enumerate(zip(heights, restitutions, rates, strict=True)):
        parts += [link(f"ball{place}", MASSES[place]),
                  slide(f"z{place}", home, f"ball{place}", axis=(0.0, 1.0),
                        at=(float(place), 0.0))]  # fmt: skip
        stops[f"s{place}"] = {"joint": f"z{place}", "restitution": e_N}
        initial[f"z{place}"] = {"at_mm": 1e3 * height, "rate_mm_per_s": 1e3 * rate}
    freedoms = len(heights) + sled
    return machine(parts, freedoms, gravity=G, stops=stops, initial=initial)


def bounces(height: float, rate: float, e_N: float, count: int) -> list[tuple[Any, ...]]:
    """Time, rate before, rebound's height and time of the first bounces, to 40 digits."""
    with mpmath.workdps(40):
        h, u, e, g = (mpmath.mpf(value) for value in (height, rate, e_N, G))
        v = mpmath.sqrt(u * u + 2 * g * h)
        t, found = (u + v) / g, []
        for _ in range(count):
            found.append((t, -v, (e * v) ** 2 / (2 * g), 2 * e * v / g))
            t, v = t + 2 * e * v / g, e * v
        return found


@pytest.fixture(scope="module")
def three() -> nip.Solution:
    return turn(falling((0.2, 0.2, 0.2)))


def first_rows(solution: nip.Solution) -> list[nip.Collision]:
    return [hit for hit in solution.collisions if hit.event is solution.collisions[0].event]


def test_each_stop_has_a_row_with_its_own_loss_and_rebound(three: nip.Solution) -> None:
    """Three balls from 0.2 m: m g h (1 - e^2) each, heights e^2 h and times 2 e v/g of rebounds.

    The rows of an event add up to it, and with the rests they balance the energy of the run.
    """
    rows = first_rows(three)
    assert [(hit.number, hit.stop) for hit in rows] == [(1, "s0"), (2, "s1"), (3, "s2")]
    assert [hit.number for hit in three.collisions] == [*range(1, len(three.collisions) + 1)]
    for hit, mass, e_N in zip(rows, MASSES, RESTITUTIONS, strict=True):
        v = math.sqrt(2.0 * G * 0.2)
        assert hit.t == rows[0].t
        assert hit.approach_rate == pytest.approx(-v, rel=1e-14)
        assert hit.separation_rate == pytest.approx(e_N * v, rel=1e-14)
        assert hit.impulse == pytest.approx(mass * (1.0 + e_N) * v, rel=1e-14)
        assert hit.energy_lost == pytest.approx(mass * G * 0.2 * (1.0 - e_N**2), rel=1e-13)
        assert hit.rebound_amplitude == pytest.approx(e_N**2 * 0.2, rel=1e-13)
        assert hit.rebound_time == pytest.approx(2.0 * e_N * v / G, rel=1e-13)
    for event in three.events:
        own = [hit.energy_lost for hit in three.collisions if hit.event is event]
        if event.kind is nip.EventKind.COLLISION:
            assert math.fsum(own) == pytest.approx(event.energy_lost, rel=1e-14)
    rests = [event.energy_lost for event in three.events if event.kind is nip.EventKind.REST]
    lost = math.fsum([*(hit.energy_lost for hit in three.collisions), *rests])
    assert lost == pytest.approx(three.energy.impact_losses, rel=1e-13)
    assert three.checks.energy_balance <= 1e-13


@pytest.mark.parametrize("sled", [False, True])
@pytest.mark.parametrize("slow", [0, 1, 2])
def test_the_time_error_of_an_event_is_that_of_its_least_certain_stop(
    slow: int, *, sled: bool
) -> None:
    """One ball is thrown up to arrive with the others, and more slowly: its time is less sure."""
    fall = math.sqrt(2.0 * 0.2 / G)
    thrown = 0.4 * G * fall
    heights, rates = [0.2] * 3, [0.0] * 3
    heights[slow], rates[slow] = 0.5 * G * fall**2 - thrown * fall, thrown
    (first, second, third), (one, two, other) = heights, rates
    mechanism = falling((first, second, third), rates=(one, two, other), sled=sled)
    solution = turn(mechanism)
    assert solution.events[0].stops == ("s0", "s1", "s2")
    strikes = {name: strike.time for name, strike in solution.errors[0].strikes.items()}
    assert max(strikes, key=lambda name: strikes[name]) == f"s{slow}"
    assert solution.errors[0].time == strikes[f"s{slow}"]


def test_documents_and_tables_have_the_rows(three: nip.Solution) -> None:
    """JSON, columns and CSV hold what the table of collisions holds."""
    document = json.loads(json.dumps(nip.record(three), allow_nan=False))
    rows = document["collisions"]
    assert [(row["number"], row["stop"]) for row in rows[:3]] == [(1, "s0"), (2, "s1"), (3, "s2")]
    assert [row["time_s"] for row in rows[:3]] == [0.0, 0.0, 0.0]
    assert [row["energy_lost_J"] for row in rows] == [hit.energy_lost for hit in three.collisions]
    assert len(csv_rows(three, "collisions.csv")) == len(three.collisions)
    assert len(csv_rows(three, "link_velocities.csv")) == 3 * len(three.collisions)
    assert f"{len(three.collisions)} collisions" in repr(three)


# Heights as floats, so that the balls come down at one time but for round-off, or within 1e-13 s.
@pytest.mark.sampled(5)
@pytest.mark.parametrize("apart", [0.0, 2e-14, -4e-14])
@pytest.mark.parametrize(
    "rates", [(0.0, 0.0, 0.0), (0.3, -0.2, 0.1), (-0.25, 0.4, 0.0), (0.1, 0.2, 0.3)]
)
def test_stated_errors_of_each_row_hold(rates: tuple[float, ...], apart: float) -> None:
    """Times, rates and rebounds of the first six bounces of each ball, against 40 digits."""
    falls = 0.21
    heights = tuple(
        float(0.5 * G * falls**2 - rate * falls + place * apart * (G * falls - rate))
        for place, rate in enumerate(rates)
    )
    mechanism = falling(heights, rates=rates)
    solution = turn(mechanism)
    assert solution.events[0].stops == ("s0", "s1", "s2")
    starts = {start.joint: start for start in mechanism.starts}
    for place, e_N in enumerate(RESTITUTIONS):
        start = starts[f"z{place}"]
        hits = [hit for hit in solution.collisions if hit.stop == f"s{place}"]
        exact = bounces(start.at, start.rate, e_N, 6)
        for hit, (t, rate, height, duration) in zip(hits, exact, strict=False):
            stated = solution.errors[hit.event.number - 1].at(hit.stop)
            assert abs(hit.t - t) <= stated.time
            assert abs(hit.approach_rate / rate - 1) <= stated.relative
            of_rebound = rebound_error(solution, hit)
            if math.isfinite(of_rebound.time):
                assert abs(hit.rebound_amplitude - height) <= of_rebound.amplitude
                assert abs(hit.rebound_time - duration) <= of_rebound.time


def test_what_is_stated_says_something() -> None:
    """Of balls 4e-14 s apart, not many times as much: the second flight forgets nothing of it."""
    apart, falls = 4e-14, 0.21
    heights = tuple(0.5 * G * falls**2 + place * apart * G * falls for place in range(3))
    solution = turn(falling(heights, (0.6, 0.3, 0.1)))
    assert solution.events[0].stops == ("s0", "s1", "s2")
    for hit in solution.collisions[:3]:
        stated = solution.errors[0].at(hit.stop)
        assert stated.time <= (hit.number - 1) * 1.1 * apart + 1e-14
    for name in ("s0", "s1", "s2"):
        second = [hit for hit in solution.collisions if hit.stop == name][1]
        stated = solution.errors[second.event.number - 1].at(name)
        assert stated.time <= 4.0 * apart
        assert stated.relative <= 1e-12


@pytest.mark.parametrize(("e_floor", "e_block"), [(0.5, 0.5), (0.2, 0.7), (0.0, 0.6), (0.8, 0.0)])
def test_losses_of_coupled_stops(e_floor: float, e_block: float) -> None:
    """A block comes down on a carriage as that meets its floor: Newton's law at both at once.

    Rates after are -e times those before; the block's impulse follows from its own momentum, that
    of the floor from the momentum of both. Each loses -P (rate before + rate after)/2.
    """
    slow, falls = 0.5, 0.2
    both = machine(
        [link("carriage", 2.0), slide("z", "frame", "carriage", axis=(0.0, 1.0)),
         link("block", 0.7), slide("s", "carriage", "block", axis=(0.0, 1.0))], 2, gravity=G,
        stops={"floor": {"joint": "z", "restitution": e_floor},
               "block": {"joint": "s", "restitution": e_block}},
        initial={"z": {"at_mm": 1e3 * 0.5 * G * falls**2},
                 "s": {"at_mm": 1e3 * slow * falls, "rate_mm_per_s": -1e3 * slow}},
    )  # fmt: skip
    solution = turn(both)
    fall = G * falls
    gained = (1.0 + e_floor) * fall, (1.0 + e_block) * slow
    on_block = 0.7 * (gained[0] + gained[1])
    on_floor = 2.0 * gained[0] + on_block
    expected = {
        "floor": 0.5 * on_floor * (1.0 - e_floor) * fall,
        "block": 0.5 * on_block * (1.0 - e_block) * slow,
    }
    rows = {hit.stop: hit for hit in first_rows(solution)}
    assert rows.keys() == expected.keys()
    for name, lost in expected.items():
        assert rows[name].energy_lost == pytest.approx(lost, rel=1e-11)
    whole = math.fsum(hit.energy_lost for hit in rows.values())
    assert whole == pytest.approx(solution.events[0].energy_lost, rel=1e-13)


@pytest.mark.parametrize("e_N", [0.0, 0.3])
def test_a_stop_that_stays_closed_has_no_row(e_N: float) -> None:
    """A block lies on a carriage that meets its floor: the floor alone is struck, one row."""
    lying = machine(
        [link("carriage", 2.0), slide("z", "frame", "carriage", axis=(0.0, 1.0)),
         link("block", 0.7), slide("s", "carriage", "block", axis=(0.0, 1.0)),
         link("weight", 1.0), hinge("swings", "frame", "weight")], 3, gravity=0.0,
        stops={"floor": {"joint": "z", "restitution": e_N},
               "block": {"joint": "s", "restitution": 0.5}},
        springs={"coil": {"joint": "s", "stiffness_N_per_m": 100.0, "preload_length_mm": 10.0}},
        initial={"z": {"at_mm": 100.0, "rate_mm_per_s": -1000.0}},
        phases=[{"number": 1, "name": "lies", "closed": ["block"]}],
    )  # fmt: skip
    solution = turn(lying)
    assert [hit.stop for hit in solution.collisions][:1] == ["floor"]
    assert solution.collisions[0].event.stops == ("floor", "block")
    assert solution.collisions[0].energy_lost == solution.events[0].energy_lost
    assert len(first_rows(solution)) == 1


def twins(e_left: float, e_right: float, main: str = "left") -> nip.Mechanism:
    """Two jaws on slides, mirror images, that springs push to their stops."""
    return machine(
        [link("left", 1.0), slide("x", "frame", "left", axis=(-1.0, 0.0)),
         link("right", 1.0), slide("y", "frame", "right")], 2,
        springs={name: {"joint": joint, "stiffness_N_per_m": 900.0, "preload_length_mm": 1.0}
                 for name, joint in (("left", "x"), ("right", "y"))},
        stops={"left": {"joint": "x", "restitution": e_left},
               "right": {"joint": "y", "restitution": e_right}},
        initial={"x": {"at_mm": 10.0}, "y": {"at_mm": 10.0}}, transition_stop=main,
    )  # fmt: skip


def test_a_turn_reads_both_of_two_stops_struck_at_once() -> None:
    """Without restitution both close at once: the collisions, impulses and losses of each."""
    read = reported_turn(turn(twins(0.0, 0.0)))
    rows = read.solution.collisions
    assert [hit.stop for hit in rows] == ["left", "right"]
    left, right = (read.at(name) for name in ("left", "right"))
    assert left.collisions == right.collisions == 1
    assert left.impulse_sum == rows[0].impulse == right.impulse_sum
    assert read.energy_lost == pytest.approx(rows[0].energy_lost + rows[1].energy_lost, rel=1e-14)
    assert read.closing_index is not None


def test_either_of_two_stops_may_be_the_transition_stop() -> None:
    """A turn reads the same of a machine and of its mirror image, whose first row is another's."""
    found = []
    for turned, main in ((twins(0.5, 0.2, "left"), "left"), (twins(0.2, 0.5, "right"), "right")):
        solution = turn(turned)
        read, (transition, *_) = reported_turn(solution), solution.transitions
        hits = [hit for hit in solution.collisions if hit.stop == main]
        assert hits[0].number == (1 if main == "left" else 2)
        found.append(
            [
                transition.t_start, transition.duration, read.largest_gap, read.closing_index,
                read.rest_index, read.energy_lost, read.at(main).impulse_sum,
                *((hit.t, hit.rebound_amplitude, hit.energy_lost) for hit in hits[:4]),
            ]
        )  # fmt: skip
    for one, other in zip(*found, strict=True):
        assert one == pytest.approx(other, rel=1e-11)


FALL = 0.1

LAWS: tuple[Simultaneous, ...] = ("newton", "sequential")


def rod(
    law: Simultaneous,
    mass: float,
    arms: tuple[float, float],
    restitution: tuple[float, float] = (0.5, 0.5),
) -> nip.Mechanism:
    """A uniform rod of 0.3 m on feet of 1 g, which slide upright.

    Args:
        law: Of stops that are struck together.
        mass: Of the rod [kg].
        arms: From its middle to its left and its right foot [m].
        restitution: Of the stops below them.
    """
    places = dict(zip("lr", (-arms[0], arms[1]), strict=True))
    parts = [link("guide", 1e-3), slide("z", "frame", "guide", (0.0, 1.0)),
             link("rod", mass, mass * 0.3**2 / 12.0), hinge("tilt", "guide", "rod")]  # fmt: skip
    for foot, x in places.items():
        parts += [frame(f"{foot}_end", "rod", (x, 0.0)), link(f"{foot}_foot", 1e-3),
                  slide(f"{foot}_z", "frame", f"{foot}_foot", (0.0, 1.0), (x, 0.0))]  # fmt: skip
    return machine(
        parts, 2, gravity=G, simultaneous=law, initial={"z": {"at_mm": 1e3 * FALL}},
        closures={foot: {"frame_a": f"{foot}_foot", "frame_b": f"{foot}_end", "slot_axis": "x",
                         "block_mass_kg": 1e-3} for foot in places},
        stops={foot: {"joint": f"{foot}_z", "restitution": e_N}
               for foot, e_N in zip(places, restitution, strict=True)},
    )  # fmt: skip


@pytest.mark.sampled(7)
@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("arms", [(0.15, 0.15), (0.1166667, 0.1166666), (0.11667, 0.11666)])
@pytest.mark.parametrize(("mass", "e_N"), [(0.1, 0.0), (1.0, 0.5), (30.0, 0.2), (1.0, 0.7)])
def test_a_symmetric_rod_bounces_flat(
    law: Simultaneous, arms: tuple[float, float], mass: float, e_N: float
) -> None:
    """Both laws say the same of it; rounded numbers are no reason to strike one end first."""
    solution = turn(rod(law, mass, arms, (e_N, e_N)))
    assert not [text for text in solution.warnings if "choice" in text]
    (rest,) = (event for event in solution.events if event.kind is nip.EventKind.REST)
    assert rest.stops == ("l", "r")
    fall = math.sqrt(2.0 * FALL / G)
    assert rest.t == pytest.approx(fall * (1.0 + e_N) / (1.0 - e_N), rel=1e-11)
    for hit in solution.collisions:
        assert hit.separation_rate == pytest.approx(-e_N * hit.approach_rate, rel=1e-9)


@pytest.mark.sampled(5)
@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("mass", [0.1, 30.0])
@pytest.mark.parametrize("restitution", [(0.5, 0.5), (0.0, 0.5), (0.2, 0.7)])
def test_the_mirror_image_does_the_same(
    law: Simultaneous, mass: float, restitution: tuple[float, float]
) -> None:
    """Of a rod whose left foot is nearer; its first blow is the one that the laws give apart."""
    one = turn(rod(law, mass, (0.1, 0.15), restitution))
    other = turn(rod(law, mass, (0.15, 0.1), restitution[::-1]))
    for solution in (one, other):
        assert "depends on a choice of the model: at t = 142.784 ms" in solution.warnings[0]
    first, mirrored = one.events[0].P_N, other.events[0].P_N
    assert first["l"] == pytest.approx(mirrored["r"], rel=1e-9)
    assert first["r"] == pytest.approx(mirrored["l"], rel=1e-9)
    assert len(one.collisions) == len(other.collisions)
    for hit, image in zip(one.collisions, other.collisions, strict=True):
        assert image.t == pytest.approx(hit.t, abs=1e-9)
