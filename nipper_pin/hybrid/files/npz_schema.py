"""Layout of a saved run: what :mod:`.storage` reads has these types, or is refused."""

from __future__ import annotations

from typing import Annotated, Any, Literal

import msgspec
from msgspec import UNSET, Meta, UnsetType

_Count = Annotated[int, Meta(ge=0, le=2**53)]
LARGEST = 1e30
"""Largest number of a run, in SI units: products of a few larger ones overflow."""
_Number = Annotated[float, Meta(ge=-LARGEST, le=LARGEST)]
_Stops = tuple[str, ...]


class _Record(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A table whose keys are all known."""


class Model(_Record, frozen=True):
    """Sources of the mechanism.

    Attributes:
        description: The TOML document as plain data.
        folder: Folder that relative mesh paths start from.
    """

    name: str
    urdf: str
    description: dict[str, Any]
    folder: str


class ResolutionRecord(_Record, frozen=True):
    """Fields of ``Resolution``; files of earlier versions name the one integrator as well."""

    tolerance: float
    flight_nodes: _Count
    kinematic_nodes: _Count
    panels_per_turn: _Count
    adaptive: bool
    integrator: Literal["picard"] | UnsetType = UNSET


class CaseRecord(_Record, frozen=True):
    """Fields of ``Case``."""

    speed_rpm: float
    window: str
    cycles: _Count
    start_index: float
    drive: str
    rest_rate: float | None
    resolution: ResolutionRecord
    reuse_cycles: bool
    max_collisions: _Count


class Setting(_Record, frozen=True, kw_only=True):
    """What a run needs to be repeated.

    Attributes:
        format: Of the file.
        version: Of the package that wrote it.
        mechanism: Sources of the mechanism.
        meshes: SHA-256 of its mesh files by their names in the URDF.
    """

    format: int
    version: str
    mechanism: Model
    meshes: dict[str, str]
    case: CaseRecord


class SavedCase(Setting, frozen=True, kw_only=True):
    """A case by itself.

    Attributes:
        sha256: Digest of all else, which cases once had; they may be edited.
        stress: What a campaign has found of it, in files of its failures.
    """

    sha256: str = ""
    stress: dict[str, object] | None = None


class ShaftRecord(_Record, frozen=True):
    """Fields of ``ShaftMotion``: [rad/s] and [rad]."""

    speed_rad_s: Annotated[float, Meta(gt=0.0, le=LARGEST)]
    start_angle_rad: _Number


class PanelRecord(_Record, frozen=True, array_like=True):
    """A panel: start and length [s], its coordinates, and the place of its arrays."""

    t: _Number
    h: Annotated[float, Meta(gt=0.0, le=LARGEST)]
    dependent: tuple[_Count, ...]
    integrated: bool
    place: _Count


class SegmentRecord(_Record, frozen=True):
    """Fields of ``Segment``; times in [s]."""

    t_start: _Number
    t_end: _Number
    closed: _Stops
    kinematic: bool
    panels: Annotated[tuple[PanelRecord, ...], Meta(min_length=1)]
    source: _Count


class EventRecord(_Record, frozen=True):
    """Fields of ``Event``, with the place of its state among the stored ones."""

    number: _Count
    t: _Number
    kind: str
    stops: Annotated[_Stops, Meta(min_length=1)]
    P_N: dict[str, _Number]
    P_g: tuple[_Number, ...]
    energy_lost: _Number
    closed_before: _Stops
    closed_after: _Stops
    series_error: _Number
    state: _Count
    source: _Count


class Run(Setting, frozen=True):
    """A whole run."""

    shaft: ShaftRecord
    segments: tuple[SegmentRecord, ...]
    events: tuple[EventRecord, ...]
    outcome: str
    evaluations: _Count
    wall_s: _Number
    repeated_from: int | None


class _Anything(msgspec.Struct, frozen=True):
    """A document of any format."""

    format: Any = None


def format_of(text: str) -> object:
    """The format of a document.

    Args:
        text: Its JSON.

    Raises:
        msgspec.MsgspecError: It is no JSON, or says nothing of it; a ``ValueError``.
    """
    return msgspec.json.decode(text, type=_Anything).format


def setting(text: str) -> Setting:
    """Read the document of a case.

    Values are checked while they are read, so that no more of others is kept in memory.

    Args:
        text: Its JSON, without NaN and infinity, which Python's JSON would read.

    Raises:
        msgspec.MsgspecError: A key is unknown or missing, or has another type; a ``ValueError``.
    """
    return msgspec.json.decode(text, type=SavedCase)


def run(text: str) -> Run:
    """Read the document of a run; as :func:`setting`."""
    return msgspec.json.decode(text, type=Run)
