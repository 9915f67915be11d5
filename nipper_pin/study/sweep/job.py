"""The data of a sweep for its workers, as one JSON text."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from importlib.metadata import PackageNotFoundError, version

import msgspec

from ...dynamics import DriveMode
from ...errors import InputError
from .axes import Axis

# Packages whose versions can change a bit of a result.
_PACKAGES = ("nipper-pin", "pin", "numpy", "scipy", "numba")
_ABSENT = "none"
COLUMNS = ("scenario", "engine", "outcome", "message", "collisions", "premise_holds")
"""Columns of the results that every sweep has."""
TURN_COLUMNS = (*COLUMNS, "turns", "repeats_after")
"""Those that every sweep of turns has."""
NO_MODEL = "no_model"
"""Outcome of a scenario whose machine cannot be built."""


class TurnJob(msgspec.Struct, frozen=True, kw_only=True):
    """What a sweep of whole turns follows.

    Attributes:
        turns: Largest number of turns of a scenario.
        least_force_N: Force above which the transition stop clamps [N].
    """

    turns: int
    least_force_N: float


# Left out of the text where it is None: sweeps of transitions keep their identity.
class Job(msgspec.Struct, frozen=True, kw_only=True, omit_defaults=True):
    """One sweep, without its rows.

    Attributes:
        urdf: The URDF text with everything that is fixed at its value, without visuals.
        document: The TOML document likewise.
        folder: Folder that collision meshes start from, where the study was read.
        axes: Parameters, in the order of the columns of a row.
        speed_rpm: Cylinder speed where it is no parameter [r/min].
        drive: Behaviour of the driven shafts.
        rest_rate: Separation rate at which a transition ends [rad/s or m/s], or None.
        tolerance: Relative accuracy.
        max_collisions: Largest number of collisions of a scenario.
        quantities: Names of what is kept.
        versions: Versions of the packages that compute, by name.
        drawn: How sampled parameters are drawn, in words; empty if there are none.
        units: Unit of each column of the results that has one.
        study: Text of the study.
        turn: What is followed in a sweep of whole turns; None in one of transitions.
    """

    name: str
    urdf: str
    document: Mapping[str, object]
    folder: str
    axes: tuple[Axis, ...]
    speed_rpm: float
    drive: DriveMode
    rest_rate: float | None
    tolerance: float
    max_collisions: int
    quantities: tuple[str, ...]
    versions: Mapping[str, str]
    drawn: str
    units: Mapping[str, str]
    study: str
    turn: TurnJob | None = None

    @property
    def identity(self) -> str:
        """Name of what the rows depend on, however many there are."""
        # Results depend on neither the path of the model's folder nor comments.
        text = msgspec.structs.replace(self, folder="", study="").text()
        return hashlib.sha256(text).hexdigest()

    @property
    def columns(self) -> tuple[str, ...]:
        """Columns of the results beside parameters and quantities."""
        return COLUMNS if self.turn is None else TURN_COLUMNS

    @property
    def moving(self) -> tuple[int, ...]:
        """Columns of a row that need a mechanism of their own."""
        return tuple(place for place, item in enumerate(self.axes) if item.target.kind == "model")

    def text(self) -> bytes:
        """The job as JSON; equal jobs give equal texts."""
        return msgspec.json.encode(self, order="deterministic")


def read_job(text: bytes) -> Job:
    """Rebuild a job from what :meth:`Job.text` gave.

    Raises:
        InputError: This process runs other versions than the one that planned the sweep.
    """
    job = msgspec.json.decode(text, type=Job)
    here = versions()
    if dict(job.versions) != here:
        message = (
            f"a worker has {other_versions(here, job.versions)}: results would depend on who "
            "computes them; install the same versions everywhere"
        )
        raise InputError(message, here=here, planned=dict(job.versions))
    return job


def other_versions(found: Mapping[str, str], wanted: Mapping[str, str]) -> str:
    """Versions that are not those that are wanted, in words."""
    return ", ".join(
        f"{name} {found.get(name)} instead of {version}"
        for name, version in wanted.items()
        if found.get(name) != version
    )


def versions() -> dict[str, str]:
    """Versions of the packages that compute, here; "none" for one that is not installed."""
    return {name: _version(name) for name in _PACKAGES}


def _version(package: str) -> str:
    try:
        return version(package)
    except PackageNotFoundError:
        return _ABSENT
