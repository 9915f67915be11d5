"""Solutions on disk: one ``.npz`` file with the model, the case and every number, without loss.

The file holds arrays and one JSON text; nothing in it is executed when it is read. Python writes
and reads floats in JSON so that every bit comes back.
"""

from __future__ import annotations

import json
import os
import struct
import zipfile
import zlib
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from ..arrays import FloatArray
from ..dynamics.assembly import Partition
from ..dynamics.shaft import ShaftMotion
from ..errors import InputError
from ..mechanism import Mechanism, from_sources
from .case import Case, Resolution
from .event import Event, EventKind
from .panel import Panel
from .segment import Segment
from .solution import Outcome, Solution

FORMAT = 2
# What reading an archive or a document can run into that is not what it should be.
_DAMAGE = (
    OSError,
    ValueError,
    LookupError,
    TypeError,
    AttributeError,
    EOFError,
    RuntimeError,
    struct.error,
    zipfile.BadZipFile,
    zlib.error,
)


def save(solution: Solution, path: str | Path) -> Path:
    """Write a solution; the file appears only when it is complete.

    Args:
        solution: The solution.
        path: File to write; the suffix ``.npz`` is added if it lacks one.

    Returns:
        The path written.
    """
    target = Path(path)
    if target.suffix != ".npz":
        target = target.with_name(target.name + ".npz")
    arrays: dict[str, FloatArray] = {}
    places: dict[int, int] = {}
    segments = [_segment_record(segment, arrays, places) for segment in solution.segments]
    states: dict[tuple[int, int, int], int] = {}
    rows: list[list[FloatArray]] = []
    events = []
    for event in solution.events:
        # Copies of a turn share their arrays here, too.
        key = (id(event.q), id(event.v_before), id(event.v_after))
        if key not in states:
            states[key] = len(rows)
            rows.append([event.q, event.v_before, event.v_after, event.delta])
        events.append({**_event_record(event), "state": states[key]})
    arrays["events"] = np.array(rows)
    document = {
        **_setting(solution.mechanism, solution.case),
        "shaft": {
            "speed_rad_s": solution.shaft.speed_rad_s,
            "start_angle_rad": solution.shaft.start_angle_rad,
        },
        "segments": segments,
        "events": events,
        "outcome": solution.outcome.name,
        "evaluations": solution.evaluations,
        "wall_s": solution.wall_s,
        "repeated_from": solution.repeated_from,
    }
    with complete_file(target) as partial, partial.open("wb") as stream:
        np.savez_compressed(stream, document=np.array(json.dumps(document)), **arrays)  # type: ignore[arg-type]
    return target


def load_solution(path: str | Path) -> Solution:
    """Read a solution written by :func:`save`; its mechanism is validated again.

    Args:
        path: The file.

    Returns:
        A solution equal to the saved one in every number.

    Raises:
        InputError: The file is missing, damaged or of another format.
    """
    try:
        # A file of our own is closed whatever is wrong with its content.
        with Path(path).open("rb") as stream, np.load(stream, allow_pickle=False) as stored:
            document = json.loads(str(stored["document"]))
            _check_format(document, path)
            return _solution(document, stored)
    except _DAMAGE as error:
        message = f"{path}: not a saved solution, or a damaged one ({error}); simulate again"
        raise InputError(message, file=str(path)) from error


def save_case(mechanism: Mechanism, case: Case, path: str | Path) -> Path:
    """Write everything that a run needs to be repeated, model included, as one JSON file."""
    with complete_file(Path(path)) as partial:
        partial.write_text(json.dumps(_setting(mechanism, case), indent=1), encoding="utf-8")
    return Path(path)


def load_case(path: str | Path) -> tuple[Mechanism, Case]:
    """Read a case written by :func:`save_case`; its mechanism is validated again.

    Raises:
        InputError: The file is missing, damaged or of another format.
    """
    try:
        document = json.loads(Path(path).read_text(encoding="utf-8"))
        _check_format(document, path)
        return _mechanism(document), _case(document)
    except _DAMAGE as error:
        message = f"{path}: not a saved case, or a damaged one ({error})"
        raise InputError(message, file=str(path)) from error


@contextmanager
def complete_file(target: Path) -> Iterator[Path]:
    """Give a temporary path beside the target that takes its place only if nothing fails."""
    partial = target.with_name(f".{target.name}.{os.getpid()}.partial")
    try:
        yield partial
        partial.replace(target)
    except OSError as error:
        message = f"{target}: cannot be written ({error.strerror or error})"
        raise InputError(message, file=str(target)) from error
    finally:
        # Where no file can be there is none to remove, and the first error is the one to tell.
        with suppress(OSError):
            partial.unlink()


def _setting(mechanism: Mechanism, case: Case) -> dict[str, Any]:
    return {
        "format": FORMAT,
        "mechanism": {
            "name": mechanism.name,
            "urdf": mechanism.urdf,
            "description": mechanism.description,
            "folder": mechanism.mesh_folder,
        },
        "case": asdict(case),
    }


def _check_format(document: dict[str, Any], path: str | Path) -> None:
    if document["format"] != FORMAT:
        message = (
            f"{path}: this is format {document['format']!r}, and this version reads format "
            f"{FORMAT}; simulate the case again"
        )
        raise InputError(message, file=str(path), format=document["format"])


def _mechanism(document: dict[str, Any]) -> Mechanism:
    source = document["mechanism"]
    return from_sources(
        source["name"], source["urdf"], source["description"], Path(source["folder"])
    )


def _case(document: dict[str, Any]) -> Case:
    values = document["case"]
    return Case(**{**values, "resolution": Resolution(**values["resolution"])})


def _segment_record(
    segment: Segment, arrays: dict[str, FloatArray], places: dict[int, int]
) -> dict[str, Any]:
    panels = []
    for panel in segment.panels:
        # Copies of a turn share their arrays, in memory and on disk.
        place = places.setdefault(id(panel.q), len(places))
        if f"panel{place}" not in arrays:
            arrays[f"panel{place}"] = np.stack([panel.q, panel.v, panel.a])
        panels.append([panel.t, panel.h, panel.split.dependent, panel.integrated, place])
    return {
        "t_start": segment.t_start,
        "t_end": segment.t_end,
        "closed": sorted(segment.closed),
        "kinematic": segment.kinematic,
        "panels": panels,
    }


def _event_record(event: Event) -> dict[str, Any]:
    return {
        "number": event.number,
        "t": event.t,
        "kind": event.kind.value,
        "stops": event.stops,
        "P_N": event.P_N,
        "P_g": event.P_g.tolist(),
        "energy_lost": event.energy_lost,
        "closed_before": sorted(event.closed_before),
        "closed_after": sorted(event.closed_after),
        "series_error": event.series_error,
    }


def _solution(document: dict[str, Any], stored: Any) -> Solution:
    mechanism = _mechanism(document)
    panels: dict[int, tuple[FloatArray, FloatArray, FloatArray]] = {}
    size = len(mechanism.joints)
    segments = []
    for record in document["segments"]:
        for *_, place in record["panels"]:
            if place not in panels:
                q, v, a = stored[f"panel{place}"]
                panels[place] = (q, v, a)
        segments.append(
            Segment(
                t_start=record["t_start"],
                t_end=record["t_end"],
                closed=frozenset(record["closed"]),
                panels=tuple(
                    Panel(t, h, *panels[place], Partition.of(dependent, size), integrated)
                    for t, h, dependent, integrated, place in record["panels"]
                ),
                kinematic=record["kinematic"],
            )
        )
    events = []
    states = [tuple(row) for row in stored["events"]]
    if {record["state"] for record in document["events"]} != set(range(len(states))):
        message = "the events do not belong to the stored states"
        raise ValueError(message)
    for record in document["events"]:
        q, v_before, v_after, delta = states[record["state"]]
        events.append(
            Event(
                number=record["number"],
                t=record["t"],
                kind=EventKind(record["kind"]),
                stops=tuple(record["stops"]),
                q=q,
                v_before=v_before,
                v_after=v_after,
                delta=delta,
                P_N=record["P_N"],
                P_g=np.array(record["P_g"]),
                energy_lost=record["energy_lost"],
                closed_before=frozenset(record["closed_before"]),
                closed_after=frozenset(record["closed_after"]),
                series_error=record["series_error"],
            )
        )
    return Solution(
        mechanism=mechanism,
        case=_case(document),
        shaft=ShaftMotion(mechanism, **document["shaft"]),
        events=tuple(events),
        segments=tuple(segments),
        outcome=Outcome[document["outcome"]],
        evaluations=document["evaluations"],
        wall_s=document["wall_s"],
        repeated_from=document["repeated_from"],
    )
