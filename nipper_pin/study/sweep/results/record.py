"""``plan.json``: what a folder says of its plan, and whether a study goes on with it."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any, Literal

import msgspec
from msgspec import Meta

from ....errors import InputError
from ....texts import MOST_JSON, read_text
from ..job import COLUMNS, TURN_COLUMNS
from ..plan import Plan
from ..samples import Samples

_FORMAT = 2
_Count = Annotated[int, Meta(ge=0, le=2**53)]
# What follows from other keys, or changes no result.
_NOT_COMPARED = ("format", "hash", "identity", "title", "study", "scenarios", "mechanisms")


class _Axis(msgspec.Struct, frozen=True):
    """A parameter, as far as it is read again."""

    name: str
    path: str
    low: float
    high: float
    scale: Literal["linear", "log"]
    values: tuple[float, ...]


class _Samples(msgspec.Struct, frozen=True):
    """How parameters are drawn."""

    method: str
    seed: _Count
    count: _Count
    earlier: tuple[_Count, ...]


class _Record(msgspec.Struct, frozen=True):
    """What is read again of a record; the rest is compared alone."""

    hash: str
    identity: str
    title: str
    model: str
    scenarios: Annotated[int, Meta(ge=1, le=2**53)]
    axes: tuple[_Axis, ...]
    samples: _Samples | None
    quantities: tuple[str, ...]
    description: dict[str, Any]
    window: Literal["transition", "cycle"] = "transition"


def plan_record(plan: Plan) -> dict[str, Any]:
    """Record of the plan of a sweep in its folder."""
    job, samples = plan.job, plan.samples
    return {
        "format": _FORMAT,
        "hash": plan.hash,
        "identity": job.identity,
        "title": plan.title,
        "model": job.name,
        "scenarios": plan.scenarios,
        "mechanisms": plan.mechanisms,
        "chunk": plan.chunk,
        "axes": [
            {
                "name": axis.name,
                "path": axis.target.path,
                "low": axis.low,
                "high": axis.high,
                "scale": axis.scale,
                "values": list(axis.values),
            }
            for axis in plan.axes
        ],
        "samples": None
        if samples is None
        else {
            "method": samples.method,
            "seed": samples.seed,
            "count": samples.count,
            "earlier": list(samples.earlier),
        },
        "quantities": list(job.quantities),
        "speed_rpm": job.speed_rpm,
        "drive": job.drive.value,
        "rest_rate": job.rest_rate,
        "tolerance": job.tolerance,
        "max_collisions": job.max_collisions,
        **({} if job.turn is None else {"window": "cycle", **msgspec.structs.asdict(job.turn)}),
        "versions": dict(job.versions),
        "urdf": job.urdf,
        "description": dict(job.document),
        "study": job.study,
    }


def read_document(file: Path) -> dict[str, Any]:
    """Read the record of a plan.

    Raises:
        InputError: It is none, or of another format.
    """
    try:
        document: dict[str, Any] = json.loads(read_text(file, MOST_JSON))
        if document["format"] == _FORMAT:
            msgspec.convert(document, _Record)
            return document
    except FileNotFoundError as error:
        message = f"{file.parent} holds no sweep: there is no {file.name} in it"
        raise InputError(message, file=str(file)) from error
    except (OSError, ValueError, LookupError, TypeError, RecursionError) as error:
        message = f"{file}: not the plan of a sweep, or a damaged one ({error})"
        raise InputError(message, file=str(file)) from error
    message = (
        f"{file}: format {document['format']}, and this version reads {_FORMAT}; sweep again with "
        "another --out"
    )
    raise InputError(message, file=str(file))


def columns_of(document: dict[str, Any]) -> tuple[str, ...]:
    """Columns of the results beside parameters and quantities, by the record of a plan."""
    return TURN_COLUMNS if document.get("window") == "cycle" else COLUMNS


def continued(plan: Plan, stored: dict[str, Any], folder: Path) -> Plan:
    """The plan that goes on with what a folder holds.

    Returns:
        The plan in the chunks that the folder has, and those that more points need.

    Raises:
        InputError: The folder holds the results of another plan.
    """
    plan = replace(plan, samples=_samples(plan.samples, stored["samples"], folder))
    # Through JSON, so that both are of the same types.
    here = json.loads(json.dumps(plan_record(plan)))
    other = [
        key
        for key in here
        if key not in _NOT_COMPARED and _compared(stored, key) != _compared(here, key)
    ]
    if not other and here["identity"] == stored["identity"]:
        return plan
    message = (
        f"{folder}: holds the results of another sweep (they differ in: "
        f"{', '.join(other) or 'study'}); give another folder with --out, or remove this one"
    )
    raise InputError(message, folder=str(folder), differences=other)


def _compared(document: dict[str, Any], key: str) -> Any:
    """A value of a record; of samples all but their number, since more may be added."""
    found = document.get(key)
    return (found["method"], found["seed"]) if key == "samples" and found else found


def _samples(samples: Samples | None, stored: Any, folder: Path) -> Samples | None:
    """Samples in the parts in which the folder has them."""
    if samples is None or stored is None:
        return samples
    if (stored["method"], stored["seed"]) != (samples.method, samples.seed):
        return samples
    if samples.count == stored["count"]:
        return replace(samples, earlier=tuple(stored["earlier"]))
    if samples.method != "sobol":
        message = (
            f"{folder}: holds a Latin hypercube of {stored['count']} points, which is made as a "
            "whole; give another folder with --out, or use sobol, whose count can be raised"
        )
        raise InputError(message, folder=str(folder))
    if samples.count < stored["count"]:
        message = (
            f"{folder}: holds {stored['count']} points, and samples.count = {samples.count} asks "
            "for fewer; raise it, or give another folder with --out"
        )
        raise InputError(message, folder=str(folder))
    return replace(samples, earlier=(*stored["earlier"], stored["count"]))
