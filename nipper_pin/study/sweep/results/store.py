"""A sweep on disk: ``plan.json``, and one Parquet file a chunk, each complete or not there."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING

from ....errors import InputError
from ....extras import require
from ....outputs import complete_file
from ...folders import make_folder
from ..plan import Chunk, Plan
from .chunk_file import check, read_file
from .record import continued, plan_record, read_document

if TYPE_CHECKING:
    import pyarrow as pa

PLAN, CHUNKS = "plan.json", "chunks"


class Store:
    """The folder of one sweep. Jobs of an array may have it open, on several machines.

    Args:
        folder: The folder; made if it does not exist.
        plan: The plan whose results it holds.

    Attributes:
        plan: The plan in the chunks of this folder: those of a study that had fewer points of a
            Sobol sequence stay as they are.

    Raises:
        InputError: It cannot be written, or holds the results of another plan.
    """

    def __init__(self, folder: str | Path, plan: Plan) -> None:
        """Open the folder, and take up what is there if it belongs to the plan."""
        self._folder = Path(folder)
        self._chunks = self._folder / CHUNKS
        make_folder(self._chunks)
        self.plan = self._taken_up(plan)
        job = self.plan.job
        self._identity = job.identity
        self._columns = (*job.columns, *(axis.name for axis in job.axes), *job.quantities)

    def rows(self, chunk: Chunk) -> pa.Table | None:
        """Rows of a chunk; None if it is not on disk.

        Raises:
            DamageError: It is there, and is not what was written.
        """
        path = self._path(chunk)
        if not path.is_file():
            return None
        table = read_file(path, self._columns)
        check(table, path.name, chunk.start, chunk.stop, self._identity)
        return table

    def write(self, chunk: Chunk, content: bytes) -> None:
        """Store one chunk; its file appears only when it is complete."""
        with complete_file(self._path(chunk)) as partial:
            partial.write_bytes(content)

    def _path(self, chunk: Chunk) -> Path:
        return self._chunks / f"{chunk.number:07d}.parquet"

    def _taken_up(self, plan: Plan) -> Plan:
        # Another job may store the plan and its first chunk at this moment.
        file, chunks = self._folder / PLAN, any(self._chunks.iterdir())
        if file.exists():
            document = read_document(file)
            plan = continued(plan, document, self._folder)
            if plan.hash == document["hash"]:
                return plan
        elif chunks:
            message = f"{self._folder}: holds chunks and no {PLAN}; give another folder with --out"
            raise InputError(message, folder=str(self._folder))
        with complete_file(file) as partial:
            partial.write_text(json.dumps(plan_record(plan), indent=1) + "\n", encoding="utf-8")
        return plan


def need_pyarrow() -> None:
    """Refuse to go on without pyarrow, and say how to get it.

    Raises:
        InputError: It is not installed.
    """
    require("sweep", "pyarrow", what="the storage of sweeps")
