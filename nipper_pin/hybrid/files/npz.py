"""Solutions on disk: one ``.npz`` file with the model, the case and every number, without loss.

The file holds arrays and one JSON text; nothing in it is executed when it is read. Python writes
and reads floats in JSON so that every bit comes back.
"""

from __future__ import annotations

import json
import struct
import zipfile
import zlib
from dataclasses import asdict
from importlib.metadata import version
from itertools import pairwise
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from ...arrays import FloatArray
from ...dynamics import Partition, ShaftMotion
from ...errors import InputError
from ...mechanism import Mechanism, from_sources, model_folder, need_as_written
from ...outputs import complete_file
from ...texts import MOST_JSON, opened, read_text
from ...tolerances.hybrid import CLOCK_ROUND_OFF
from ..case import Case, Resolution
from ..event import Event, EventKind, Outcome
from ..motion.panel import Panel
from ..result.solution import Solution
from ..segment import Segment
from . import npz_schema
from .archive import need_readable, read_archive
from .own_files import mesh_digests, need_own_files

FORMAT = 3
# Versions that read other formats.
_READERS = {2: "nipper-pin 0.1.0 of 2026-11-23"}
_Nodes = tuple[FloatArray, FloatArray, FloatArray]
# What reading an archive or a document can run into that is not what it should be.
_DAMAGE = (
    OSError,
    ValueError,
    LookupError,
    TypeError,
    AttributeError,
    OverflowError,
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

    Raises:
        InputError: It cannot be written, is too large to be read again, or parts of its mechanism
            were replaced, which is saved by its texts.
    """
    target = Path(path)
    if target.suffix != ".npz":
        target = target.with_name(target.name + ".npz")
    arrays: dict[str, FloatArray] = {}
    places: dict[tuple[int, int, bytes], int] = {}
    segments = [_segment_record(segment, arrays, places) for segment in solution.segments]
    states: dict[tuple[int, bytes], int] = {}
    rows: list[list[FloatArray]] = []
    events = []
    for event in solution.events:
        # Copies of a turn are stored once, unless hinges have wound on.
        key = (event.source, event.q.tobytes())
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
    stored = {"document": np.array(json.dumps(document)), **arrays}
    need_readable(stored)
    with complete_file(target) as partial, partial.open("wb") as stream:
        np.savez_compressed(stream, **stored)  # type: ignore[arg-type]
    return target


def load_solution(path: str | Path) -> Solution:
    """Read a solution written by ``save``; its mechanism is validated again.

    Args:
        path: The file.

    Returns:
        A solution equal to the saved one in every number.

    Raises:
        InputError: The file is missing, damaged or of another format.
    """
    try:
        # A file of our own is closed whatever is wrong with its content.
        with opened(Path(path)) as stream:
            stored = read_archive(stream)
        text = str(stored.pop("document"))
        _check_format(text, path)
        return _solution(npz_schema.run(text), stored)
    except _DAMAGE as error:
        message = f"{path}: not a saved solution, or a damaged one ({error}); simulate again"
        raise InputError(message, file=str(path)) from error


def save_case(mechanism: Mechanism, case: Case, path: str | Path) -> Path:
    """Write everything that a run needs to be repeated, model included, as one JSON file.

    Raises:
        InputError: It cannot be written, or parts of the mechanism were replaced.
    """
    with complete_file(Path(path)) as partial:
        partial.write_text(json.dumps(_setting(mechanism, case), indent=1), encoding="utf-8")
    return Path(path)


def load_case(path: str | Path) -> tuple[Mechanism, Case]:
    """Read a case written by ``save_case``; its mechanism is validated again.

    Raises:
        InputError: The file is missing, damaged or of another format.
    """
    try:
        text = read_text(Path(path), MOST_JSON)
        _check_format(text, path)
        setting = npz_schema.setting(text)
        return _mechanism(setting), _case(setting)
    except _DAMAGE as error:
        message = f"{path}: not a saved case, or a damaged one ({error})"
        raise InputError(message, file=str(path)) from error


def _setting(mechanism: Mechanism, case: Case) -> dict[str, Any]:
    need_as_written(mechanism)
    return {
        "format": FORMAT,
        "version": version("nipper-pin"),
        "mechanism": {
            "name": mechanism.name,
            "urdf": mechanism.urdf,
            "description": mechanism.description,
            "folder": mechanism.mesh_folder,
        },
        "meshes": mesh_digests(mechanism.name, mechanism.urdf, Path(mechanism.mesh_folder)),
        "case": asdict(case),
    }


def _check_format(text: str, path: str | Path) -> None:
    found = npz_schema.format_of(text)
    if found != FORMAT:
        reader = _READERS.get(found) if isinstance(found, int) else None
        other = f", which {reader} reads" if reader else ""
        message = (
            f"{path}: this is format {found!r}{other}, and this version reads format {FORMAT}; "
            "simulate the case again"
        )
        raise InputError(message, file=str(path), format=found)


def _mechanism(setting: npz_schema.Setting) -> Mechanism:
    source = setting.mechanism
    folder = model_folder(source.name, source.folder)
    need_own_files(source.name, source.urdf, source.description, folder, setting.meshes)
    return from_sources(source.name, source.urdf, source.description, folder)


def _case(setting: npz_schema.Setting) -> Case:
    values = msgspec.structs.asdict(setting.case)
    resolution = msgspec.structs.asdict(setting.case.resolution)
    resolution.pop("integrator")
    return Case(**{**values, "resolution": Resolution(**resolution)})


def _segment_record(
    segment: Segment, arrays: dict[str, FloatArray], places: dict[tuple[int, int, bytes], int]
) -> dict[str, Any]:
    panels = []
    for number, panel in enumerate(segment.panels):
        key = (segment.source, number, panel.q[0].tobytes())
        place = places.setdefault(key, len(places))
        if f"panel{place}" not in arrays:
            arrays[f"panel{place}"] = np.stack([panel.q, panel.v, panel.a])
        panels.append([panel.t, panel.h, panel.split.dependent, panel.integrated, place])
    return {
        "t_start": segment.t_start,
        "t_end": segment.t_end,
        "closed": sorted(segment.closed),
        "kinematic": segment.kinematic,
        "panels": panels,
        "source": segment.source,
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
        "source": event.source,
    }


def _solution(run: npz_schema.Run, stored: Any) -> Solution:
    mechanism = _mechanism(run)
    size = len(mechanism.joints)
    # Copies of a turn share their arrays again, as they did when they were written.
    panels: dict[int, _Nodes] = {}
    for segment in run.segments:
        for panel in segment.panels:
            if panel.place not in panels:
                panels[panel.place] = tuple(_numbers(stored[f"panel{panel.place}"], 3, None, size))
    states = [tuple(row) for row in _numbers(stored["events"], None, 4, size)] if run.events else []
    if {event.state for event in run.events} != set(range(len(states))):
        message = "the events do not belong to the stored states"
        raise ValueError(message)
    _check_order(run)
    rows = mechanism.closure_rows
    return Solution(
        mechanism=mechanism,
        case=_case(run),
        shaft=ShaftMotion(mechanism, run.shaft.speed_rad_s, run.shaft.start_angle_rad),
        events=tuple(_event(item, states[item.state], mechanism, rows) for item in run.events),
        segments=tuple(
            _segment(place, item, panels, mechanism) for place, item in enumerate(run.segments)
        ),
        outcome=Outcome[run.outcome],
        evaluations=run.evaluations,
        wall_s=run.wall_s,
        repeated_from=run.repeated_from,
    )


def _check_order(run: npz_schema.Run) -> None:
    """Refuse events and segments that do not follow one another in time."""
    times = [event.t for event in run.events]
    edges = [time for item in run.segments for time in (item.t_start, item.t_end)]
    numbers = [event.number for event in run.events]
    counted = numbers == list(range(1, len(numbers) + 1))
    # Copies of a turn are moved by a sum of turns, which is rounded.
    ordered = all(
        before - after <= CLOCK_ROUND_OFF * abs(before)
        for row in (times, edges)
        for before, after in pairwise(row)
    )
    if not (ordered and counted):
        message = "its events or segments are not in order"
        raise ValueError(message)


def _source(source: int, own: int) -> int:
    """Number of the original of a segment or an event: an earlier one, or its own."""
    if source > own:
        message = f"number {own} is a copy of a later one, {source}"
        raise ValueError(message)
    return source


def _numbers(array: Any, *shape: int | None) -> FloatArray:
    """An array of finite numbers of this shape, None for any length but none at all."""
    fits = array.ndim == len(shape) and all(
        length > 0 if wanted is None else length == wanted
        for length, wanted in zip(array.shape, shape, strict=True)
    )
    if array.dtype != np.float64 or not fits or not (np.abs(array) <= npz_schema.LARGEST).all():
        message = f"an array of {array.dtype} {array.shape} where numbers {shape} should be"
        raise ValueError(message)
    return np.asarray(array)


def _segment(
    place: int,
    record: npz_schema.SegmentRecord,
    panels: dict[int, _Nodes],
    mechanism: Mechanism,
) -> Segment:
    size = len(mechanism.joints)
    rows = mechanism.closure_rows
    for panel in record.panels:
        if sorted(set(panel.dependent) & set(range(size))) != sorted(panel.dependent) or (
            len(panel.dependent) != rows
        ):
            message = f"{panel.dependent} are not the dependent coordinates of a panel"
            raise ValueError(message)
    return Segment(
        t_start=record.t_start,
        t_end=record.t_end,
        closed=_stops(record.closed, mechanism),
        panels=tuple(
            _panel(panel, *panels[panel.place], Partition.of(panel.dependent, size))
            for panel in record.panels
        ),
        kinematic=record.kinematic,
        source=_source(record.source, place),
    )


def _panel(
    record: npz_schema.PanelRecord, q: FloatArray, v: FloatArray, a: FloatArray, split: Partition
) -> Panel:
    return Panel(record.t, record.h, q, v, a, split, record.integrated)


def _event(
    record: npz_schema.EventRecord,
    state: tuple[FloatArray, ...],
    mechanism: Mechanism,
    rows: int,
) -> Event:
    q, v_before, v_after, delta = state
    kind = EventKind(record.kind)
    _stops((*record.stops, *record.P_N), mechanism)
    if kind is EventKind.COLLISION and not set(record.stops) <= record.P_N.keys():
        message = f"the collision of {record.stops} has no impulse"
        raise ValueError(message)
    return Event(
        number=record.number,
        t=record.t,
        kind=kind,
        stops=record.stops,
        q=q,
        v_before=v_before,
        v_after=v_after,
        delta=delta,
        P_N=record.P_N,
        P_g=_numbers(np.array(record.P_g), rows) if rows else np.empty(0),
        energy_lost=record.energy_lost,
        closed_before=_stops(record.closed_before, mechanism),
        closed_after=_stops(record.closed_after, mechanism),
        series_error=record.series_error,
        source=_source(record.source, record.number),
    )


def _stops(names: tuple[str, ...], mechanism: Mechanism) -> frozenset[str]:
    """Names of stops that there are."""
    return frozenset(mechanism.stop(name).name for name in names)
