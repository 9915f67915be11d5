"""Layout of a saved run: what :mod:`.npz` reads has these types, or is refused.

Values are checked while they are read, so that no more of others is kept in memory. Numbers are
those of JSON, without NaN and infinity, which Python's own would read.
"""

from __future__ import annotations

from typing import Annotated, Any

import msgspec
from msgspec import Meta

from ..event import EventKind

_Count = Annotated[int, Meta(ge=0, le=2**53)]
LARGEST = 1e30
"""Largest number of a run, in SI units: products of a few larger ones overflow."""
_Number = Annotated[float, Meta(ge=-LARGEST, le=LARGEST)]
_Above = Annotated[float, Meta(gt=0.0, le=LARGEST)]


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


class PanelRecord(_Record, frozen=True, kw_only=True, array_like=True):
    """A panel: start and length [s], its coordinates, and the place of its arrays."""

    t: _Number
    h: _Above
    dependent: tuple[_Count, ...]
    integrated: bool
    place: _Count


class SegmentRecord(_Record, frozen=True, kw_only=True):
    """Fields of ``Segment``."""

    t_start: _Number
    t_end: _Number
    closed: frozenset[str]
    kinematic: bool
    panels: Annotated[tuple[PanelRecord, ...], Meta(min_length=1)]
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
