"""Findings of ``check``: its record, masses by shapes, clearances, and what to do next."""

from __future__ import annotations

import itertools
import math
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin
import pytest
import trimesh
from small_machines import frame, hinge, link, sources
from snapshots import Words

from nipper_pin import Case, InputError, Mechanism, Solution, Window, check, load, simulate
from nipper_pin.dynamics import impact_condition
from nipper_pin.mechanism import collision_model, from_sources
from nipper_pin.study.check import Extreme, ModelReport
from nipper_pin.study.interference import Clearance, clearances
from nipper_pin.study.masses import LinkMass, link_masses
from nipper_pin.study.next_steps import next_steps
from tests.refusals.bases import model


@pytest.fixture(name="turn", scope="module")
def one_turn(e62: Mechanism) -> Solution:
    return simulate(e62, Case(speed_rpm=650.0, window=Window.CYCLE))


@pytest.fixture(name="report", scope="module")
def of_the_turn(e62: Mechanism) -> ModelReport:
    return check(e62, 650.0)


def index(run: Solution, t: float) -> float:
    return run.mechanism.cylinder.index_from_angle(float(run.shaft.angle(t)))


def test_the_record(report: ModelReport, e62: Mechanism, turn: Solution) -> None:
    """From the model and from the turn that was walked."""
    record = report.record()
    jaw, steeve = e62.stop("jaw"), e62.stop("steeve")
    hits = [item for item in turn.collisions if item.stop == "jaw"]
    release = next(item for item in turn.events if item.kind.value == "release")
    opened = next(
        item for item in turn.events
        if item.t > hits[-1].t and "jaw" in item.closed_before and "jaw" not in item.closed_after
    )  # fmt: skip
    assert record["closing_index"] == pytest.approx(hits[0].index)
    assert record["opening_index"] == pytest.approx(index(turn, opened.t))
    assert record["releases"] == [
        {"stop": "steeve", "index": pytest.approx(index(turn, release.t))}
    ]
    # The stop force is zero there; it is located to round-off of some 100 N.
    assert abs(report.stop_force["steeve"].value) < 1e-9
    assert report.stop_force["steeve"].index == pytest.approx(report.releases[0][1], abs=1e-9)
    assert report.struck == {"jaw", "steeve"}
    assert record["outcome"] == turn.outcome.value
    assert record["masses_kg"] == {
        joint.child: e62.model.inertias[e62.model.getJointId(joint.name)].mass
        for joint in e62.joints
    }
    assert (record["mobility"], record["driven"], record["links"]) == (3, 2, list(e62.links))
    assert record["provenance"] == dict(e62.provenance)
    assert record["joints"] == [asdict(item) for item in e62.joints]
    assert record["closures"] == [asdict(item) for item in e62.closures]
    assert list(record["contacts"]) == ["jaw"]
    assert list(record["smallest_stop_force_N"]) == ["jaw", "steeve"]
    upper = replace(steeve, sense=-1.0, at=-0.02)
    bare = replace(jaw, contact=None)
    other = replace(report, mechanism=replace(e62, stops=(bare, upper))).record()
    assert (other["stops"]["steeve"]["side"], other["stops"]["steeve"]["at"]) == ("upper", -0.02)
    assert (record["stops"]["steeve"]["side"], record["stops"]["steeve"]["at"]) == ("lower", 0.0)
    # A hinge's stop without contact point has a moment.
    assert list(other["smallest_stop_moment_N_m"]) == ["jaw"]
    assert list(other["smallest_stop_force_N"]) == ["steeve"]
    assert other["contacts"] == {}


def test_least_forces_of_stops(report: ModelReport, turn: Solution) -> None:
    """No force of a walk of its own, phase by phase, is below; nor is the index elsewhere."""
    lowest: dict[str, tuple[float, float]] = {}
    for item in turn.phases:
        inner = 1e-6 * (item.t_end - item.t_start)
        times = np.linspace(item.t_start + inner, item.t_end - inner, 150)
        if item.t_end - item.t_start < 1e-6:
            continue
        forces = turn.trajectory.reactions(times).contacts
        for name in item.closed:
            least = int(np.argmin(forces[name]))
            found = (float(forces[name][least]), float(times[least]))
            lowest[name] = min(lowest.get(name, (math.inf, 0.0)), found)
    for name, (force, t) in lowest.items():
        assert report.stop_force[name].value == pytest.approx(force, abs=0.02 * 100.0)
        assert report.stop_force[name].index == pytest.approx(index(turn, t), abs=0.2)


def test_conditions(report: ModelReport, turn: Solution) -> None:
    """The largest over the turn and where it is; one where there are no closures.

    The impact condition is largest where a phase ends, and nodes of panels stop short of it by some
    percent of a panel; it says how many digits are lost.
    """
    times = np.linspace(*turn.trajectory.span, 240)
    _, jacobian = turn.system.body.closures(turn.trajectory.evaluate(times).q)
    free = [i for i in range(7) if i not in turn.system.driven]
    found = [np.linalg.cond(item[:, free]) for item in jacobian]
    place = int(np.argmax(found))
    assert report.condition.value == pytest.approx(found[place], rel=1e-6)
    assert report.condition.index == pytest.approx(index(turn, times[place]), abs=1e-6)
    values: list[tuple[float, float]] = []
    for phase in turn.phases:
        stops = turn.system.constraint_set(frozenset(phase.closed)).stops
        times = np.linspace(phase.t_start, phase.t_end, 300)
        q = turn.trajectory.evaluate(times).q
        _, jacobian = turn.system.body.closures(q)
        values += [
            (impact_condition(turn.system, here, rows, stops), index(turn, float(t)))
            for t, here, rows in zip(times, q, jacobian, strict=True)
        ]
    told = report.impact_condition
    there, _ = min(values, key=lambda item: abs(item[1] - told.index))
    assert told.value == pytest.approx(there, rel=0.02)
    assert told.value == pytest.approx(max(values)[0], rel=0.02)


def test_a_machine_of_one_body() -> None:
    """Without closures conditions are one; what falls has no transition, with the reason."""
    ball = load(Path(__file__).parents[1] / "strangers" / "ball_e05")
    found = check(ball, 60.0)
    assert found.condition == found.impact_condition == Extreme(1.0, 24.0)
    with pytest.raises(InputError) as caught:
        simulate(ball, Case(speed_rpm=60.0))
    assert found.no_transition == caught.value.message
    assert check(load("e62"), 512.5).no_transition == ""


def test_masses_with_what_is_fixed(tmp_path: Path) -> None:
    """Shapes of a link and of what is fixed to it, to any depth, add up; a mesh hides them."""

    def shown(part: str, *shapes: str) -> str:
        parts = "".join(f"<collision><geometry>{item}</geometry></collision>" for item in shapes)
        return part.replace("</link>", f"{parts}</link>")

    box, ball = '<box size="0.1 0.1 0.2"/>', '<sphere radius="0.3"/>'
    bar, mesh = '<cylinder radius="0.2" length="0.5"/>', '<mesh filename="m.stl"/>'
    masses = {"a": 8.0, "d": 0.25, "e": 3.0, "f": 4.0, "g": 5.0}
    shapes = {"a": (box, box), "d": (ball,), "e": (box, mesh, box), "f": (), "g": (bar,)}
    parts = []
    for place, name in enumerate(masses):
        parts += [shown(link(name, masses[name]), *shapes[name]),
                  hinge(f"j{name}", "frame", name, (float(place), 0.0))]  # fmt: skip
    # A frame is a link without mass.
    parts += [shown(frame(name, on).replace("/>", "></link>", 1), box) for name, on in ("ba", "cb")]
    trimesh.creation.box().export(tmp_path / "m.stl")
    urdf, description = sources(parts, 5)
    machine = from_sources("m", urdf, description, str(tmp_path))
    volumes = {"a": 0.008, "d": 0.036 * math.pi, "e": None, "f": None, "g": 0.02 * math.pi}
    assert link_masses(machine) == tuple(
        LinkMass(name, mass, volume and pytest.approx(mass / volume))
        for (name, mass), volume in zip(masses.items(), volumes.values(), strict=True)
    )


@pytest.mark.parametrize(
    ("mass", "density", "doubtful"),
    [(1.0, 4.9e5, False), (1.0, 5.1e5, True), (999.0, None, False), (1001.0, 1.0, True)],
)
def test_doubts_about_masses(mass: float, density: float | None, doubtful: bool) -> None:
    """The sentences are in the reviewed words of `check`."""
    assert bool(LinkMass("x", mass, density).doubt) is doubtful


def test_clearances_are_those_of_pinocchio(e62: Mechanism, turn: Solution) -> None:
    """Every pair of links that share no joint, at the times that are looked at, all shapes."""
    found = {(item.link_a, item.link_b): item for item in clearances(turn, samples=12)}
    start, end = turn.trajectory.span
    events = [item.t for item in turn.events if start <= item.t <= end]
    times = np.unique([*np.linspace(start, end, 12), *events])
    geometry, names = collision_model(e62)
    link_of = {shape: link for link, shapes in names.items() for shape in shapes}
    adjacent = {frozenset((joint.parent, joint.child)) for joint in e62.joints}
    jaw = next(joint for joint in e62.joints if joint.index == e62.stop("jaw").index)
    lips = frozenset((jaw.parent, jaw.child))
    owners = [link_of[item.name] for item in geometry.geometryObjects]
    pairs = [
        (a, b) for a, b in itertools.combinations(range(len(owners)), 2)
        if owners[a] != owners[b] and {owners[a], owners[b]} not in adjacent - {lips}
    ]  # fmt: skip
    for pair in pairs:
        geometry.addCollisionPair(pin.CollisionPair(*pair))
    data, shapes = e62.model.createData(), geometry.createData()
    near: dict[frozenset[str], dict[float, float]] = {}
    for t, q in zip(times, turn.trajectory.evaluate(times).q, strict=True):
        pin.computeDistances(e62.model, data, geometry, shapes, q)
        place = round(index(turn, t), 6)
        for (a, b), result in zip(pairs, shapes.distanceResults, strict=True):
            of_pair = near.setdefault(frozenset((owners[a], owners[b])), {})
            of_pair[place] = min(of_pair.get(place, math.inf), result.min_distance)
    told = {frozenset(key): item for key, item in found.items()}
    # Links of closures' pins share a joint, too.
    assert set(told) <= {key for key, values in near.items() if min(values.values()) < 0.02}
    assert len(told) >= 3
    for key, item in told.items():
        assert item.distance_m == pytest.approx(min(near[key].values()), abs=2e-6)
        assert item.distance_m == pytest.approx(near[key][round(item.index, 6)], abs=2e-6)
        assert item.may_touch is (key == lips)
    distances = [item.distance_m for item in clearances(turn, samples=12)]
    assert distances == sorted(distances)


def test_lips_meet_and_a_needle_that_is_too_long_strikes(e62: Mechanism, tmp_path: Path) -> None:
    """Lips touch to the tolerance of distances; a drum half a millimetre larger meets the lower.

    Closing at index 34 and opening between 7 and 9.5, as this class of machine is set.
    """
    report = check(e62, 450.0)
    assert report.closing_index == pytest.approx(34.0, abs=0.3)
    assert report.opening_index is not None
    assert 7.0 < report.opening_index < 9.5
    assert report.releases == report.interferences == ()
    near = {frozenset((item.shape_a, item.shape_b)): item for item in report.clearances}
    (lips,) = (item for item in report.clearances if item.may_touch)
    assert near[frozenset(("bottom_lip", "top_lip"))] is lips
    assert abs(lips.distance_m) < 1e-6
    drum = 'radius="0.0625" length="0.2"', 'radius="0.063" length="0.2"'
    worst = check(load(model("e62", drum, tmp_path)), 450.0).interferences[0]
    assert {worst.link_a, worst.link_b} == {"frame", "bottom_nipper"}
    before = near[frozenset((worst.shape_a, worst.shape_b))]
    assert {before.shape_a, before.shape_b} == {"cylinder_drum", "bottom_lip"}
    assert worst.distance_m == pytest.approx(before.distance_m - 0.0005, abs=2e-6)
    assert worst.index == pytest.approx(39.7, abs=0.3)


def test_what_interferes() -> None:
    """Overlaps by more than the distance computation is good for."""
    for distance, wrong in ((-0.9e-6, False), (-1.1e-6, True), (0.0, False)):
        item = Clearance("a", "s", "b", "t", distance, 3.0, may_touch=False)
        assert item.interferes is wrong


def report_of(e62: Mechanism, **changes: Any) -> ModelReport:
    given: dict[str, Any] = {
        "mechanism": e62, "speed_rpm": 512.5, "start_index": 24.0,
        "condition": Extreme(1.0, 2.0), "impact_condition": Extreme(3.0, 4.0), "clearances": (),
        "closing_index": 34.0, "opening_index": 8.0, "releases": (), "stop_force": {},
        "outcome": "done", "struck": frozenset(), "no_transition": "",
    }  # fmt: skip
    return ModelReport(**{**given, **changes})


def test_what_to_do_next(e62: Mechanism, words: Words) -> None:
    """Each thing that is missing by its sentence, then the commands with the user's words."""
    pair = [Clearance("a", one, "b", "t", -1e-3, 3.0, may_touch=False) for one in ("z", "s", "z")]
    bare = replace(e62, drives=(), stops=(), transition_stop="", shortcuts={}, phases=())
    unstruck = {"closing_index": None, "opening_index": None}
    cases: dict[str, dict[str, Any]] = {
        "nothing": {},
        "no transition": {"no_transition": "too many stops"},
        "not struck": {"closing_index": None},
        "not opened": {"opening_index": None},
        "overlaps": {
            "clearances": (*pair, replace(pair[0], shape_a="far", distance_m=0.1))
        },
        "a shortcut": {"mechanism": replace(e62, shortcuts={"stiffness": "x"})},
        "shortcuts": {"mechanism": replace(e62, shortcuts={})},
        "provenance": {"mechanism": replace(e62, provenance={})},
        "drives and stops": {"mechanism": bare, **unstruck},
        "stops": {"mechanism": replace(bare, drives=e62.drives), **unstruck,
                  "no_transition": "none"},
    }  # fmt: skip
    said = []
    for name, changes in cases.items():
        report = report_of(changes.pop("mechanism", e62), **changes)
        found = next_steps(
            report, "my model", given=["--speed", "500"], start=["--start-index", "3"]
        )
        said += [f"{name}:", *(f"  {text}" for text in (*found.missing, *found.commands))]
    words("\n".join(said) + "\n")
