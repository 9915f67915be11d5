"""Solutions on disk: one ``.npz`` file with the model, the case and every number, without loss.

The file holds arrays and one JSON text; nothing in it is executed when it is read. Floats in JSON
come back bit by bit. What is read of a text has the types of the records below, or is refused:
values are checked while they are read, so that no more of others is kept in memory. NaN and
infinity are no numbers of JSON, though Python's own reads them.
"""

from __future__ import annotations

import json
import struct
import zipfile
import zlib
from dataclasses import asdict, fields
from importlib.metadata import version
from itertools import pairwise
from pathlib import Path
from typing import Annotated, Any, TypeVar

import msgspec
import numpy as np
from msgspec import Meta

from ...arrays import FloatArray
from ...dynamics import Partition, ShaftMotion
from ...errors import InputError
from ...mechanism import Mechanism, model_folder, need_as_written
from ...mechanism.build.mechanism import build_mechanism
from ...mechanism.files.csv_tables import inline_tables
from ...outputs import complete_file
from ...texts import MOST_JSON, opened, read_text
from ...tolerances.hybrid import CLOCK_ROUND_OFF
from ..case import Case, Resolution
from ..history import Event, EventKind, Outcome, Segment
from ..motion.panel import Panel
from ..result.solution import Solution
from .archive import mesh_digests, need_readable, read_archive

FORMAT = 3
# Arrays by what they belong to, each with its place in the file.
_Stored = dict[tuple[object, ...], tuple[int, tuple[FloatArray, ...]]]
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
_Count = Annotated[int, Meta(ge=0, le=2**53)]
LARGEST = 1e30
"""Largest number of a run, in SI units: products of a few larger ones overflow."""
_Number = Annotated[float, Meta(ge=-LARGEST, le=LARGEST)]
_Above = Annotated[float, Meta(gt=0.0, le=LARGEST)]
# A panel: start and length [s], dependent coordinates, integrated or not, place of its arrays.
_Panel = tuple[_Number, _Above, tuple[_Count, ...], bool, _Count]


_Kind = TypeVar("_Kind", bound="Setting")


class _Record(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A table whose keys are all known."""


class AnyFormat(msgspec.Struct):
    """A document of any format."""

    format: Any = None


class Model(_Record, frozen=True, kw_only=True):
    """Sources of a mechanism: its texts, and the folder that relative mesh paths start from."""

    name: str
    urdf: str
    description: dict[str, Any]
    folder: str


class Setting(_Record, frozen=True, kw_only=True):
    """What a run needs to be repeated.

    Attributes:
        version: Of the package that wrote it.
        meshes: SHA-256 of its mesh files by their names in the URDF.
        case: Fields of ``Case``, which checks them itself.
    """

    format: int
    version: str
    mechanism: Model
    meshes: dict[str, str]
    case: dict[str, Any]


class SavedCase(Setting, frozen=True, kw_only=True):
    """A case by itself.

    Attributes:
        sha256: Digest of all else, which cases once had; they may be edited.
        stress: What a campaign has found of it, in files of its failures.
    """

    sha256: str = ""
    stress: dict[str, object] | None = None


class ShaftRecord(_Record, frozen=True, kw_only=True):
    """Fields of ``ShaftMotion``: [rad/s] and [rad]."""

    speed_rad_s: _Above
    start_angle_rad: _Number


class SegmentRecord(_Record, frozen=True, kw_only=True):
    """Fields of ``Segment``."""

    t_start: _Number
    t_end: _Number
    closed: frozenset[str]
    kinematic: bool
    panels: Annotated[tuple[_Panel, ...], Meta(min_length=1)]
    source: _Count


class EventRecord(_Record, frozen=True, kw_only=True):
    """Fields of ``Event``, with the place of its state among the stored ones."""

    number: _Count
    t: _Number
    kind: EventKind
    stops: Annotated[tuple[str, ...], Meta(min_length=1)]
    P_N: dict[str, _Number]
    P_g: tuple[_Number, ...]
    energy_lost: _Number
    closed_before: frozenset[str]
    closed_after: frozenset[str]
    series_error: _Number
    source: _Count
    state: _Count


class Run(Setting, frozen=True, kw_only=True):
    """A whole run."""

    shaft: ShaftRecord
    segments: tuple[SegmentRecord, ...]
    events: tuple[EventRecord, ...]
    outcome: str
    evaluations: _Count
    wall_s: _Number
    repeated_from: int | None


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
    panels: _Stored = {}
    states: _Stored = {}
    document = _setting(solution.mechanism, solution.case) | _fields(
        Run,
        solution,
        shaft=_fields(ShaftRecord, solution.shaft),
        segments=[_segment_record(segment, panels) for segment in solution.segments],
        events=[_event_record(event, states) for event in solution.events],
        outcome=solution.outcome.name,
    )
    stored = {
        "document": np.array(json.dumps(document, default=_plain)),
        **{f"panel{place}": np.stack(arrays) for place, arrays in panels.values()},
        "events": np.array([arrays for _, arrays in states.values()]),
    }
    need_readable(stored)
    with complete_file(target) as partial, partial.open("wb") as stream:
        np.savez_compressed(stream, **stored)  # type: ignore[arg-type]
    return target


def load_solution(path: str | Path) -> Solution:
    """Read a solution written by ``save``; its mechanism is validated again.

    Args:
        path: The file, or the folder of ``simulate --out`` that holds it.

    Returns:
        A solution equal to the saved one in every number.

    Raises:
        InputError: The file is missing, damaged or of another format.
    """
    try:
        # A file of our own is closed whatever is wrong with its content.
        with opened(_file(path, "solution.npz")) as stream:
            stored = read_archive(stream)
        return _solution(_decoded(str(stored.pop("document")), Run, path), stored)
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

    Args:
        path: The file, or the folder of ``simulate --out`` that holds it.

    Raises:
        InputError: The file is missing, damaged or of another format.
    """
    try:
        setting = _decoded(read_text(_file(path, "case.json"), MOST_JSON), SavedCase, path)
        return _mechanism(setting), _case(setting.case)
    except _DAMAGE as error:
        message = f"{path}: not a saved case, or a damaged one ({error})"
        raise InputError(message, file=str(path)) from error


def _file(path: str | Path, name: str) -> Path:
    """A file, or that of its name in the folder of a run."""
    place = Path(path)
    return place / name if place.is_dir() else place


def _setting(mechanism: Mechanism, case: Case) -> dict[str, Any]:
    need_as_written(mechanism)
    return {
        "format": FORMAT,
        "version": version("nipper-pin"),
        "mechanism": _fields(Model, mechanism, folder=mechanism.mesh_folder),
        "meshes": mesh_digests(mechanism.name, mechanism.urdf, Path(mechanism.mesh_folder)),
        "case": asdict(case),
    }


def _decoded(text: str, kind: type[_Kind], path: str | Path) -> _Kind:
    found = msgspec.json.decode(text, type=AnyFormat).format
    if found != FORMAT:
        message = (
            f"{path}: this is format {found!r}, and this version reads format {FORMAT}; simulate "
            "the case again"
        )
        raise InputError(message, file=str(path), format=found)
    return msgspec.json.decode(text, type=kind)


def _mechanism(setting: Setting) -> Mechanism:
    """The mechanism of the texts; of its folder only meshes are read that it was saved with."""
    source = setting.mechanism
    folder = model_folder(source.name, source.folder)
    tables = inline_tables(source.description, None, f"{source.name}.toml")
    for mesh, digest in mesh_digests(source.name, source.urdf, folder).items():
        if digest != setting.meshes.get(mesh):
            message = (
                f"{mesh} in {folder} is not the mesh that this was saved with; put that one back, "
                "or simulate the model again"
            )
            raise InputError(message, mesh=mesh, folder=str(folder))
    return build_mechanism(source.name, source.urdf, tables, folder)


def _case(values: dict[str, Any]) -> Case:
    """The case of these fields, all of them; files of earlier versions name the integrator too."""
    resolution = msgspec.convert(values.get("resolution"), dict[str, Any])
    _need(resolution.pop("integrator", "picard") == "picard", "an unknown integrator")
    for kind, given in ((Case, values), (Resolution, resolution)):
        names = {item.name for item in fields(kind)}
        wrong = ", ".join(sorted(names ^ given.keys()))
        _need(not wrong, f"{kind.__name__}: unknown, or not there: {wrong}")
    return Case(**{**values, "resolution": Resolution(**resolution)})


def _segment_record(segment: Segment, panels: _Stored) -> dict[str, Any]:
    records = []
    for number, panel in enumerate(segment.panels):
        key = segment.source, number, panel.q[0].tobytes()
        place = _place(panels, key, panel.q, panel.v, panel.a)
        records.append([panel.t, panel.h, panel.split.dependent, panel.integrated, place])
    return _fields(SegmentRecord, segment, panels=records)


def _event_record(event: Event, states: _Stored) -> dict[str, Any]:
    key = event.source, event.q.tobytes()
    place = _place(states, key, event.q, event.v_before, event.v_after, event.delta)
    return _fields(EventRecord, event, state=place)


def _place(stored: _Stored, key: tuple[object, ...], *arrays: FloatArray) -> int:
    """Place of arrays in the file; copies of a turn share one, unless hinges have wound on."""
    return stored.setdefault(key, (len(stored), arrays))[0]


def _fields(kind: type, item: object, **others: object) -> dict[str, Any]:
    """Fields that a kind of records has, in its order: the item's own, but for those given."""
    names = kind.__annotations__
    return {name: others[name] if name in others else getattr(item, name) for name in names}


def _plain(value: Any) -> list[Any]:
    """A set or an array as JSON has it."""
    return sorted(value) if isinstance(value, frozenset) else value.tolist()


def _solution(run: Run, stored: dict[str, Any]) -> Solution:
    mechanism = _mechanism(run)
    _check(run, mechanism)
    size = len(mechanism.joints)
    # Copies of a turn share their arrays again, as they did when they were written.
    nodes = {
        place: tuple(_numbers(stored[f"panel{place}"], 3, None, size))
        for place in {place for segment in run.segments for *_, place in segment.panels}
    }
    states = [tuple(row) for row in _numbers(stored["events"], None, 4, size)] if run.events else []
    places = {event.state for event in run.events}
    _need(places == set(range(len(states))), "the events do not belong to the stored states")
    return Solution(
        mechanism=mechanism,
        case=_case(run.case),
        shaft=ShaftMotion(mechanism, run.shaft.speed_rad_s, run.shaft.start_angle_rad),
        events=tuple(_event(item, states[item.state]) for item in run.events),
        segments=tuple(_segment(item, nodes, size) for item in run.segments),
        outcome=Outcome[run.outcome],
        evaluations=run.evaluations,
        wall_s=run.wall_s,
        repeated_from=run.repeated_from,
    )


def _segment(record: SegmentRecord, nodes: dict[int, tuple[FloatArray, ...]], size: int) -> Segment:
    panels = []
    for t, h, dependent, integrated, place in record.panels:
        q, v, a = nodes[place]
        panels.append(Panel(t, h, q, v, a, Partition.of(dependent, size), integrated))
    return Segment(**_fields(Segment, record, panels=tuple(panels)))


def _event(record: EventRecord, state: tuple[FloatArray, ...]) -> Event:
    arrays = dict(zip(("q", "v_before", "v_after", "delta"), state, strict=True))
    return Event(**_fields(Event, record, P_g=np.array(record.P_g), **arrays))


def _need(right: bool, message: str) -> None:
    if not right:
        raise ValueError(message)


def _check(run: Run, mechanism: Mechanism) -> None:
    """Refuse a run whose parts do not belong to one another, or to the machine."""
    wrong = "its events or segments are not in order"
    times = [event.t for event in run.events]
    edges = [time for item in run.segments for time in (item.t_start, item.t_end)]
    for before, after in (*pairwise(times), *pairwise(edges)):
        # Copies of a turn are moved by a sum of turns, which is rounded.
        _need(before - after <= CLOCK_ROUND_OFF * abs(before), wrong)
    rows, size = mechanism.closure_rows, len(mechanism.joints)
    stops = set[str]()
    for place, segment in enumerate(run.segments):
        stops |= segment.closed
        _need(segment.source <= place, f"segment {place} is a copy of {segment.source}")
        for _, _, dependent, *_ in segment.panels:
            right = len(set(dependent) & set(range(size))) == len(dependent) == rows
            _need(right, f"{dependent} are not the dependent coordinates of a panel")
    for number, event in enumerate(run.events, 1):
        _need(event.number == number, wrong)
        stops |= {*event.stops, *event.P_N, *event.closed_before, *event.closed_after}
        _need(event.source <= event.number, f"event {event.number} is a copy of {event.source}")
        _need(len(event.P_g) == rows, f"event {event.number} has not {rows} impulses of closures")
        right = event.kind is not EventKind.COLLISION or event.P_N.keys() >= set(event.stops)
        _need(right, f"the collision of {event.stops} has no impulse")
    unknown = ", ".join(sorted(stops - {stop.name for stop in mechanism.stops}))
    _need(not unknown, f"{mechanism.name} has no stop {unknown}")


def _numbers(array: Any, *shape: int | None) -> FloatArray:
    """An array of finite numbers of this shape, None for any length but none at all."""
    fits = array.ndim == len(shape) and all(
        length > 0 if wanted is None else length == wanted
        for length, wanted in zip(array.shape, shape, strict=True)
    )
    right = array.dtype == np.float64 and fits and bool((np.abs(array) <= LARGEST).all())
    _need(right, f"an array of {array.dtype} {array.shape} where numbers {shape} should be")
    return np.asarray(array)
