"""Stops that close together, because closures or couplings tie their joints to one freedom."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq
from small_machines import frame, hinge, link, machine, slide

import nipper_pin as nip

FORCE, TRAVEL = 5.0, 0.01


def rack(
    ratios: tuple[float, ...],
    restitution: tuple[float, ...],
    apart: float = 0.0,
    phases: list[dict[str, Any]] | None = None,
) -> nip.Mechanism:
    """A jaw of 1 kg that a constant force shuts, and jaws that follow it, each with a stop.

    Args:
        ratios: Coordinates of the followers by that of the jaw.
        restitution: Of each stop, the jaw's first.
        apart: Distance by which the last stop is met later [m].
        phases: Working phases.
    """
    parts = [link("jaw"), slide("jaw", "frame", "jaw", (0.0, 1.0))]
    stops = {"s0": {"joint": "jaw", "at_mm": -1e3 * TRAVEL, "restitution": restitution[0]}}
    for place, ratio in enumerate(ratios, start=1):
        joint = slide(f"j{place}", "frame", f"l{place}", (0.0, 1.0))
        mimic = f'<mimic joint="jaw" multiplier="{ratio!r}"/></joint>'
        parts += [link(f"l{place}", 0.5), joint.replace("</joint>", mimic)]
        late = apart if place == len(ratios) else 0.0
        stops[f"s{place}"] = {
            "joint": f"j{place}",
            "at_mm": -1e3 * ratio * (TRAVEL + late),
            "side": "lower" if ratio > 0.0 else "upper",
            "restitution": restitution[place],
        }
    spring = {"joint": "jaw", "coordinate_mm": [-1e3, 1e3], "force_N": [FORCE, FORCE]}
    tables: dict[str, Any] = {"stops": stops, "springs": {"shut": spring}}
    if phases is not None:
        tables["phases"] = phases
    return machine(parts, 1, **tables)


def turn(mechanism: nip.Mechanism, speed_rpm: float = 60.0) -> nip.Solution:
    """One whole turn."""
    return nip.simulate(mechanism, nip.Case(speed_rpm=speed_rpm, window=nip.Window.CYCLE))


def rest_of(solution: nip.Solution, *stops: str) -> float:
    """Time of the rest of these stops, which is one event [s]."""
    (rest,) = (event for event in solution.events if event.kind is nip.EventKind.REST)
    assert sorted(rest.stops) == sorted(stops)
    assert rest.closed_after == frozenset(stops)
    return rest.t


@pytest.mark.parametrize(
    ("ratios", "restitution"),
    [
        ((1.0,), (0.3, 0.3)),
        ((-1.0,), (0.3, 0.3)),
        ((-0.25, 2.0), (0.5, 0.5, 0.5)),
        ((1.5,), (0.0, 0.0)),
        # The larger one is struck: it throws the other open faster than that does itself.
        ((-2.0,), (0.2, 0.6)),
        ((-2.0,), (0.6, 0.2)),
    ],
)
def test_stops_of_a_rack_rest_at_one_time_and_share(
    ratios: tuple[float, ...], restitution: tuple[float, ...]
) -> None:
    """Of the inertia 1 + sum(m r^2) each stop takes the same share, divided by its own ratio."""
    solution = turn(rack(ratios, restitution))
    inertia = 1.0 + 0.5 * sum(ratio**2 for ratio in ratios)
    strike = math.sqrt(2.0 * TRAVEL * inertia / FORCE)
    speed, e_N = FORCE / inertia * strike, max(restitution)
    names = [f"s{place}" for place in range(len(restitution))]
    rest = strike * (1.0 + e_N) / (1.0 - e_N)
    assert rest_of(solution, *names) == pytest.approx(rest, rel=1e-12)
    sizes = dict(zip(names, (1.0, *map(abs, ratios)), strict=True))
    struck = [name for name, own in zip(names, restitution, strict=True) if own == e_N]
    first = solution.events[0]
    assert first.t == pytest.approx(strike, rel=1e-13)
    whole = (1.0 + e_N) * inertia * speed
    for name in names:
        share = whole / len(struck) / sizes[name] if name in struck else 0.0
        assert first.P_N[name] == pytest.approx(share, rel=1e-12)
    lost = [hit.energy_lost for hit in solution.collisions if hit.event is first]
    assert sum(lost) == pytest.approx(0.5 * (1.0 - e_N**2) * inertia * speed**2, rel=1e-12)
    forces = solution.trajectory.reactions(0.5 * (rest + 1.0)).stops
    for name in names:
        expected = FORCE / len(names) / sizes[name]
        assert forces[name][0] == pytest.approx(expected, rel=1e-12)
    assert solution.warnings == ()


def test_one_that_is_met_later_is_never_struck() -> None:
    """It does not close with the other, and the phase that names both contradicts itself."""
    solution = turn(rack((-1.0,), (0.3, 0.3), apart=1e-6))
    assert rest_of(solution, "s0") < 1.0
    both = [{"number": 1, "name": "shut", "closed": ["s0", "s1"]}]
    with pytest.raises(nip.ModelError, match=r"contradict one another: .*stop s0, stop s1"):
        rack((-1.0,), (0.3, 0.3), apart=1e-6, phases=both)


def test_a_phase_may_name_one_or_both() -> None:
    """All that close with a stop belong to its phase."""
    for closed in (["s0"], ["s1"], ["s1", "s0"]):
        phases = [
            {"number": 1, "name": "open", "closed": []},
            {"number": 4, "name": "shut", "closed": closed},
        ]
        solution = turn(rack((-1.0,), (0.3, 0.3), phases=phases))
        last = solution.phases[-1]
        assert (last.number, last.closed) == (4, {"s0", "s1"})


def four_bar(follower: float, elsewhere: float = 0.0) -> nip.Mechanism:
    """A crank of 0.1 m, a rod and a rocker of 0.15 m, both pivots on the frame, 0.2 m apart.

    Args:
        follower: Where the rocker's stop is [rad]; the crank's is at -0.5.
        elsewhere: A further slide, free to move, that carries it all: the mass on it [kg].
    """
    ground = "sled" if elsewhere else "frame"
    parts = [
        link("crank", 0.3, 1e-3, (0.05, 0.0)),
        link("rod", 0.2, 1e-3),
        link("rocker", 0.4, 1e-3),
        hinge("crank", ground, "crank"),
        hinge("rod", "crank", "rod", (0.1, 0.0)),
        hinge("rocker", ground, "rocker", (0.2, 0.0)),
        frame("end", "rod", (0.1, 0.15)),
        frame("tip", "rocker", (0.0, 0.15)),
    ]
    if elsewhere:
        parts += [link("sled", elsewhere), slide("sled", "frame", "sled")]
    stops = {
        "crank": {"joint": "crank", "at_deg": math.degrees(-0.5), "restitution": 0.4},
        "rocker": {
            "joint": "rocker",
            "at_deg": math.degrees(follower),
            "side": "upper",
            "restitution": 0.4,
        },
    }
    closures = {"pin": {"frame_a": "end", "frame_b": "tip"}}
    freedom = 2 if elsewhere else 1
    return machine(parts, freedom, gravity=9.81, stops=stops, closures=closures)


def rocker_at(crank: float) -> float:
    """Rocker's angle by that of the crank, from the triangle of the two ends of the rod [rad]."""
    rod = math.hypot(0.1, 0.15)
    end = 0.1 * np.array([math.cos(crank), math.sin(crank)])

    def left(angle: float) -> float:
        tip = np.array([0.2 - 0.15 * math.sin(angle), 0.15 * math.cos(angle)])
        return float(np.hypot(*(tip - end))) - rod

    return float(brentq(left, -0.9, 0.9, xtol=1e-16, rtol=1e-15))


@pytest.mark.parametrize("elsewhere", [0.0, 2.0])
def test_stops_of_a_four_bar_that_are_met_at_one_place(elsewhere: float) -> None:
    """The motion is that with one of them; the other's gap follows by another ratio."""
    place = rocker_at(-0.5)
    both = four_bar(place, elsewhere)
    solution = turn(both)
    alone = turn(replace(both, stops=tuple(item for item in both.stops if not item.leader)))
    assert rest_of(solution, "crank", "rocker") == rest_of(alone, "crank")
    step = 1e-6
    ratio = (rocker_at(-0.5 - step) - rocker_at(-0.5 + step)) / (2.0 * step)
    impulses, whole = solution.events[0].P_N, alone.events[0].P_N["crank"]
    assert impulses["crank"] == pytest.approx(0.5 * whole, rel=1e-12)
    assert impulses["rocker"] == pytest.approx(0.5 * whole / ratio, rel=1e-8)
    strikes = {hit.stop: hit.approach_rate for hit in solution.collisions[:2]}
    assert strikes["rocker"] == pytest.approx(ratio * strikes["crank"], rel=1e-8)


def test_what_is_read_of_a_turn(tmp_path: Path) -> None:
    """Rebounds, stated errors, clamping and a saved run are there for each of the stops."""
    mechanism = rack((-2.0,), (0.3, 0.3))
    solution = turn(mechanism)
    pairs = list(zip(solution.collisions[::2], solution.collisions[1::2], strict=True))
    assert len(pairs) > 3
    for one, other in pairs:
        assert (one.stop, other.stop) == ("s0", "s1")
        assert other.rebound_time == pytest.approx(one.rebound_time, rel=1e-12)
        assert other.rebound_amplitude == pytest.approx(2.0 * one.rebound_amplitude, rel=1e-9)
    for event, error in zip(solution.events, solution.errors, strict=True):
        assert error.impulses.keys() == event.P_N.keys()
    again = nip.load_solution(nip.save(solution, tmp_path / "run.npz"))
    assert [event.P_N for event in again.events] == [event.P_N for event in solution.events]
    assert again.errors == solution.errors
    table = nip.turn_table(mechanism, speed_rpm=[60.0, 61.0], turns=1)
    share = 1.0 - solution.events[-1].t
    assert table.clamped_share[0] == pytest.approx(share, rel=1e-9)


@pytest.mark.parametrize("at_deg", range(-59, 0, 2))
def test_cranks_of_a_parallelogram_close_together_wherever_that_is(at_deg: int) -> None:
    """Round-off of the search for that place is larger in some places than in others."""
    places = {f"stops.{name}.at_deg": float(at_deg) for name in ("s1", "s2")}
    mechanism = nip.load(Path(__file__).parents[1] / "strangers/par_two_stops", places)
    assert [stop.leader for stop in mechanism.stops] == ["", "s1"]


@pytest.mark.parametrize("size", [1e-3, 1.0, 1e3])
def test_stops_of_slides_close_together_whatever_the_size_of_the_machine(size: float) -> None:
    """A rod whose ends slide along x and z turns from 45 to 60 deg: dz/dx = -cot(60 deg) there.

    A stop that is met a millionth of the rod later closes alone.
    """
    start, end = math.radians(45.0), math.radians(60.0)
    parts = [
        link("x", 1.0, size**2),
        link("z", 1.0, size**2),
        link("rod", 1.0, size**2),
        slide("x", "frame", "x", (1.0, 0.0), (size * math.cos(start), 0.0)),
        slide("z", "frame", "z", (0.0, 1.0), (0.0, size * math.sin(start))),
        hinge("rod", "x", "rod"),
        frame("tip", "rod", (-size * math.cos(start), size * math.sin(start))),
    ]
    x, z = (1e3 * size * (at(end) - at(start)) for at in (math.cos, math.sin))
    for late, leader in ((0.0, "x"), (1e-3 * size, "")):
        stops = {
            "x": {"joint": "x", "at_mm": x, "restitution": 0.3},
            "z": {"joint": "z", "at_mm": z + late, "side": "upper", "restitution": 0.3},
        }
        mechanism = machine(
            parts, 1, stops=stops, closures={"pin": {"frame_a": "tip", "frame_b": "z"}}
        )
        assert [stop.leader for stop in mechanism.stops] == ["", leader]
        ratio = 1.0 / math.tan(end) if leader else 1.0
        assert mechanism.stop("z").ratio == pytest.approx(ratio, rel=1e-12)
