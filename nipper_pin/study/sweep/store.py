"""A sweep on disk: ``plan.json``, and one Parquet file a chunk, each complete or not there."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ...errors import InputError
from ...hybrid.storage import complete_file
from ..folders import make_folder
from .plan import Chunk, Plan

if TYPE_CHECKING:
    import pyarrow as pa

_FORMAT = 1
_PLAN, _CHUNKS = "plan.json", "chunks"


class Store:
    """The folder of one sweep.

    Args:
        folder: The folder; made if it does not exist.
        plan: The plan whose results it holds.

    Raises:
        InputError: It cannot be written, or holds the results of another plan.
    """

    def __init__(self, folder: str | Path, plan: Plan) -> None:
        """Open the folder, and take up what is there if it belongs to the plan."""
        need_pyarrow()
        self._folder = Path(folder)
        self._chunks = self._folder / _CHUNKS
        make_folder(self._chunks)
        file = self._folder / _PLAN
        if file.exists():
            _check_same(file, plan)
            return
        if any(self._chunks.iterdir()):
            message = f"{folder}: holds chunks and no {_PLAN}; give another folder with --out"
            raise InputError(message, folder=str(folder))
        with complete_file(file) as partial:
            partial.write_text(json.dumps(_record(plan), indent=1) + "\n", encoding="utf-8")

    def missing(self, chunks: Sequence[Chunk]) -> list[Chunk]:
        """Chunks that are not there, or are not what was written."""
        return [chunk for chunk in chunks if not _whole(self._path(chunk), chunk)]

    def write(self, chunk: Chunk, content: bytes) -> None:
        """Store one chunk; its file appears only when it is complete."""
        with complete_file(self._path(chunk)) as partial:
            partial.write_bytes(content)

    def _path(self, chunk: Chunk) -> Path:
        return self._chunks / f"{chunk.number:07d}.parquet"


@dataclass(frozen=True, eq=False, kw_only=True)
class SweepTable:
    """Scenarios of a sweep, all of them or evenly thinned out.

    Attributes:
        title: What the sweep is about.
        model: What the model is, in a few words.
        axes: Parameters, each with ``name``, ``path``, ``low``, ``high``, ``scale`` and ``values``
            (empty if it is sampled).
        quantities: Names of what was kept.
        scenarios: Scenarios of the plan.
        stored: Scenarios on disk.
        table: The rows.
    """

    title: str
    model: str
    axes: tuple[dict[str, Any], ...]
    quantities: tuple[str, ...]
    scenarios: int
    stored: int
    table: pa.Table


def read_sweep(folder: str | Path, most: int | None = None) -> SweepTable:
    """Read what a sweep has stored so far.

    Args:
        folder: Folder of the sweep.
        most: Most rows to read, evenly spread over all scenarios.

    Raises:
        InputError: The folder holds no sweep, or nothing of it yet, or is damaged.
    """
    need_pyarrow()
    import pyarrow as pa
    import pyarrow.parquet as pq

    document = _document(Path(folder) / _PLAN)
    files = sorted((Path(folder) / _CHUNKS).glob("*.parquet"))
    step = 1 if most is None else -(-int(document["scenarios"]) // most)
    # Every k-th scenario has to meet all values of the grids: k shares no factor with them.
    sizes = 2 * math.prod(len(axis["values"]) or 1 for axis in document["axes"])
    while step > 1 and math.gcd(step, sizes) > 1:
        step += 1
    parts, stored = [], 0
    for file in files:
        try:
            part = pq.read_table(file, partitioning=None)
        except (OSError, pa.ArrowInvalid) as error:
            message = f"{file}: damaged ({error}); run the sweep again, it computes what is missing"
            raise InputError(message, file=str(file)) from error
        stored += len(part)
        if step > 1:
            first = -part["scenario"][0].as_py() % step
            part = part.take(pa.array(range(first, len(part), step), type=pa.int64()))
        parts.append(part)
    if not parts:
        message = f"{folder}: nothing is computed yet; run nipper-pin sweep"
        raise InputError(message, folder=str(folder))
    return SweepTable(
        title=document["title"],
        model=document["description"].get("title") or document["model"],
        axes=tuple(document["axes"]),
        quantities=tuple(document["quantities"]),
        scenarios=document["scenarios"],
        stored=stored,
        table=pa.concat_tables(parts),
    )


def need_pyarrow() -> None:
    """Refuse to go on without pyarrow, and say how to get it.

    Raises:
        InputError: It is not installed.
    """
    from importlib.util import find_spec

    if find_spec("pyarrow") is None:
        message = "sweeps are stored by pyarrow: pip install 'nipper-pin[sweep]'"
        raise InputError(message, package="pyarrow")


def _record(plan: Plan) -> dict[str, Any]:
    """What the folder says of its plan."""
    job, samples = plan.job, plan.samples
    return {
        "format": _FORMAT,
        "hash": plan.hash,
        "title": plan.title,
        "model": job.name,
        "scenarios": plan.scenarios,
        "mechanisms": plan.mechanisms,
        "chunks": len(plan.chunks()),
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
        else {"method": samples.method, "count": samples.count, "seed": samples.seed},
        "quantities": list(job.quantities),
        "speed_rpm": job.speed_rpm,
        "drive": job.drive.value,
        "rest_rate": job.rest_rate,
        "tolerance": job.tolerance,
        "max_collisions": job.max_collisions,
        "versions": dict(job.versions),
        "urdf": job.urdf,
        "description": dict(job.document),
    }


def _document(file: Path) -> dict[str, Any]:
    try:
        document: dict[str, Any] = json.loads(file.read_text(encoding="utf-8"))
        if document["format"] == _FORMAT:
            return document
    except (OSError, ValueError, LookupError, TypeError) as error:
        message = f"{file}: not the plan of a sweep, or a damaged one ({error})"
        raise InputError(message, file=str(file)) from error
    message = f"{file}: format {document['format']}, and this version reads {_FORMAT}"
    raise InputError(message, file=str(file))


def _check_same(file: Path, plan: Plan) -> None:
    """Refuse to mix results of two plans."""
    stored, here = _document(file), _record(plan)
    if stored.get("hash") == here["hash"]:
        return
    # Through JSON, so that both are of the same types.
    here = json.loads(json.dumps(here))
    other = [key for key in here if key != "hash" and stored.get(key) != here[key]]
    keys = ", ".join(other) or "chunk"
    message = (
        f"{file.parent}: holds the results of another sweep (they differ in: {keys}); "
        "give another folder with --out, or remove this one"
    )
    raise InputError(message, folder=str(file.parent), differences=other)


def _whole(path: Path, chunk: Chunk) -> bool:
    """Whether a chunk is on disk with all its rows."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    if not path.is_file():
        return False
    try:
        found = pq.read_metadata(path).num_rows
    except (OSError, pa.ArrowInvalid):
        return False
    return bool(found == chunk.stop - chunk.start)
