"""Each machine beside its mirror image, and beside copies of itself, does what it does alone.

Two machines on one frame and one cylinder have nothing in common: what one does is not to depend
on the other, though stops of both are struck in the same instant. No number comes from elsewhere:
a run of the machine alone is the judge, to the errors that the two runs state.
"""

from __future__ import annotations

import copy
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import Any, NamedTuple
from xml.etree import ElementTree

import numpy as np
import pytest
from small_machines import link, machine, slide

from benchmarks.stress.machines.mirror import mirrored
from benchmarks.stress.machines.parts import Source
from nipper_pin import Case, EventKind, Mechanism, Solution, Window, load, simulate
from nipper_pin.arrays import FloatArray
from nipper_pin.mechanism import from_sources
from nipper_pin.mechanism.gallery import GALLERY, drawn

_TABLES = ("drives", "springs", "dampers", "forces", "stops", "closures", "initial")
# Keys of their entries that name other parts.
_NAMES = ("joint", "frame_a", "frame_b", "of")
_Call = Callable[[str], str]
# Of numbers of which nothing larger is stated.
ROUND_OFF = 16.0 * float(np.finfo(float).eps)


def pair(mechanism: Mechanism) -> Mechanism:
    """A machine and its mirror image, whose parts are called ``NAME_mirrored``.

    Both stand in the same place, and do not touch one another.
    """
    own = _source(mechanism)
    image = mirrored(own)
    assert image is not None, f"{mechanism.name} has no mirror image"
    return _beside([(own, ""), (image, "_mirrored")])


def copies(mechanism: Mechanism, count: int) -> Mechanism:
    """A machine several times; parts of the copies are called ``NAME_1``, ``NAME_2`` and so on."""
    own = _source(mechanism)
    return _beside([(own, f"_{k}" if k else "") for k in range(count)])


def _source(mechanism: Mechanism) -> Source:
    description = copy.deepcopy(dict(mechanism.description))
    return Source(mechanism.name, mechanism.urdf, description, mechanism.mesh_folder)


def _beside(machines: Sequence[tuple[Source, str]]) -> Mechanism:
    """One mechanism of several; what has no part of its own in each is that of the first."""
    (first, _), *others = machines
    root = ElementTree.fromstring(first.urdf)
    document: dict[str, Any] = copy.deepcopy(first.description)
    # Their paths lead to parts that now are several.
    for key in ("shortcuts", "provenance"):
        document.pop(key, None)
    document["degrees_of_freedom"] *= len(machines)
    frame = _frame(root)
    for source, suffix in others:

        def called(name: str, suffix: str = suffix) -> str:
            return name if name == frame else name + suffix

        robot = ElementTree.fromstring(source.urdf)
        _rename(robot, called)
        parts = [item for item in robot if item.tag in ("link", "joint")]
        root.extend(item for item in parts if item.get("name") != frame)
        for name in _TABLES:
            for key, entry in source.description.get(name, {}).items():
                document.setdefault(name, {})[called(key)] = _renamed(entry, called)
        for phase, own in zip(document["phases"], source.description["phases"], strict=True):
            phase["closed"] = [*phase["closed"], *map(called, own["closed"])]
    urdf = ElementTree.tostring(root, encoding="unicode")
    return from_sources(f"{first.name}_{len(machines)}", urdf, document, first.folder)


def _frame(robot: ElementTree.Element) -> str:
    """The link that no joint carries."""
    carried = {item.get("link") for item in robot.iter("child")}
    (frame,) = {item.get("name", "") for item in robot.iterfind("link")} - carried
    return frame


def _rename(robot: ElementTree.Element, called: _Call) -> None:
    keys = {"parent": "link", "child": "link", "mimic": "joint"}
    keys |= dict.fromkeys(("link", "joint", "collision"), "name")
    for item in robot.iter():
        key = keys.get(item.tag, "")
        if key in item.attrib:
            item.set(key, called(item.attrib[key]))


def _renamed(entry: dict[str, Any], called: _Call) -> dict[str, Any]:
    changed = {key: called(value) if key in _NAMES else value for key, value in entry.items()}
    if "contact" in entry:
        changed["contact"] = {key: called(value) for key, value in entry["contact"].items()}
    return changed


def differences(alone: Solution, beside: Solution, suffix: str) -> list[str]:
    """What a machine does otherwise beside others than alone, beyond the errors of both runs.

    Parts of the machine are called there by their own names and the suffix after them.
    """
    found = []
    if beside.outcome is not alone.outcome:
        found.append(f"alone: {alone.outcome.value} beside: {beside.outcome.value}")
    for stop in alone.mechanism.stops:
        name = stop.name + suffix
        found += [
            f"{name}: {text}" for text in _compared(blows(alone, stop.name), blows(beside, name))
        ]
    return found


class Blow(NamedTuple):
    """One event of one stop.

    Attributes:
        kind: What happens.
        values: Time, rates before and after, and impulse of a collision; the time of any other.
        errors: Their stated errors.
    """

    kind: EventKind
    values: FloatArray
    errors: FloatArray


def blows(run: Solution, name: str) -> list[Blow]:
    """Events that concern one stop, in order of time."""
    stop, found = run.mechanism.stop(name), []
    for event, error in zip(run.events, run.errors, strict=True):
        impulse = event.P_N.get(name, 0.0)
        if event.kind is EventKind.COLLISION and impulse > 0.0:
            numbers = [event.t, stop.rate(event.v_before), stop.rate(event.v_after), impulse]
            values, share = np.array(numbers), error.impulses[name] / impulse
            errors = np.array([error.time, *(share * np.abs(values[1:]))])
        elif event.kind is not EventKind.COLLISION and name in event.stops:
            values, errors = np.array([event.t]), np.array([error.time])
        else:
            continue
        found.append(Blow(event.kind, values, errors + ROUND_OFF * np.abs(values)))
    return found


def _compared(one: list[Blow], other: list[Blow]) -> Iterator[str]:
    """Differences of two lists; of a series either run may have computed more bounces."""
    series = {EventKind.COLLISION, EventKind.REST}
    while one and other:
        here, there = one[0], other[0]
        if here.kind is there.kind:
            off = np.abs(here.values - there.values) > here.errors + there.errors
            if off.any():
                yield f"{here.kind.value}: {here.values} alone, {there.values} beside"
            one, other = one[1:], other[1:]
        elif {here.kind, there.kind} != series:
            yield f"{here.kind.value} alone, {there.kind.value} beside at {there.values[0]:g} s"
            return
        elif here.kind is EventKind.REST:
            other = other[1:]
        else:
            one = one[1:]
    for where, left in (("alone", one), ("beside", other)):
        if left:
            yield f"{len(left)} events {where} only, the first at {left[0].values[0]:g} s"


SETTINGS = (("held", 1.0), ("inertial", 1.0), ("held", 2.0))


def table() -> list[object]:
    """Every machine of the gallery; a turn at the rated speed is the quick one."""
    return [
        pytest.param(
            name, drive, share,
            marks=[pytest.mark.campaign] * ((drive, share) != ("held", 1.0)),
        )
        for drive, share in SETTINGS
        for name in GALLERY
    ]  # fmt: skip


def turn(mechanism: Mechanism, share: float = 1.0, **keys: object) -> Case:
    speed = share * mechanism.cylinder.rated_speed_rpm
    return Case(speed_rpm=speed, window=Window.CYCLE, max_collisions=400, **keys)  # type: ignore[arg-type]


@pytest.mark.sampled(5)
@pytest.mark.parametrize(("name", "drive", "share"), table())
def test_a_machine_beside_its_mirror_image(name: str, drive: str, share: float) -> None:
    """Events of either half are those of the machine alone, each at the time that it has there."""
    machine_alone = drawn(name).mechanism()
    case = turn(machine_alone, share, drive=drive)
    alone, both = simulate(machine_alone, case), simulate(pair(machine_alone), case)
    # At twice its speed the clapper of the bell is thrown past both stops.
    assert alone.events or (name, share) == ("bell", 2.0)
    assert differences(alone, both, "") == differences(alone, both, "_mirrored") == []


def ball(restitution: float) -> Mechanism:
    """A ball 200 mm above a floor."""
    return machine(
        [link("ball"), slide("z", "frame", "ball", (0.0, 1.0))], 1, gravity=9.81,
        stops={"floor": {"joint": "z", "restitution": restitution}},
        initial={"z": {"at_mm": 200.0}},
    )  # fmt: skip


@pytest.mark.parametrize(
    ("of", "count"),
    [
        *(("ball", count) for count in (2, 3, 5)),
        ("e62", 3), ("slider_crank", 3), ("slider_crank", 5),
    ],
)  # fmt: skip
def test_machines_that_do_the_same(of: str, count: int) -> None:
    """Copies whose stops are struck, and come to rest, all in the same instants."""
    machines = {"ball": lambda: ball(0.4), "e62": load}
    single = machines.get(of, lambda: drawn(of).mechanism())()
    case = turn(single)
    alone, beside = simulate(single, case), simulate(copies(single, count), case)
    assert any(event.kind is EventKind.REST for event in alone.events)
    for k in range(count):
        assert differences(alone, beside, f"_{k}" if k else "") == []


def test_a_half_that_is_another_machine_is_seen() -> None:
    """A restitution that is off by a millionth, and only there."""
    single = drawn("bell").mechanism()
    both, case = pair(single), turn(single)
    stops = tuple(
        replace(stop, restitution=stop.restitution * (1.0 + 1e-6))
        if stop.name == "left_mirrored" else stop
        for stop in both.stops
    )  # fmt: skip
    alone, beside = simulate(single, case), simulate(replace(both, stops=stops), case)
    assert [text for text in differences(alone, beside, "") if "collision" in text] == []
    found = differences(alone, beside, "_mirrored")
    assert any("left_mirrored: collision" in text for text in found)
