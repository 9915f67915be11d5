"""Machines beside one another: all of their parts in one tree, on one frame and one cylinder."""

from __future__ import annotations

import copy
from collections.abc import Callable, Iterator, Sequence
from typing import Any, NamedTuple
from xml.etree import ElementTree

import numpy as np

from benchmarks.stress.machines.mirror import mirrored
from benchmarks.stress.machines.parts import Source
from nipper_pin import EventKind, Mechanism, Solution
from nipper_pin.arrays import FloatArray
from nipper_pin.mechanism import from_sources

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
