"""One chunk of a sweep: rows of parameters to the bytes of a Parquet file."""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache
from itertools import pairwise
from typing import Any

import numpy as np

from ...arrays import FloatArray
from ...errors import NipperError
from ...mechanism import Mechanism
from ..transitions import FAILED, transition_table
from .changes import changed
from .job import Job, read_job
from .quantities import quantity

NO_MODEL = "no_model"
"""Outcome of a scenario whose machine cannot be built."""
_NO_ENGINE = "none"
# A scenario out of millions that meets a case nobody foresaw must not cost all the others.
MARKED = (NipperError, ArithmeticError, ValueError, RuntimeError)
"""Errors that mark one scenario and do not end a study."""


def run_chunk(job_text: bytes, start: int, rows: FloatArray) -> bytes:
    """Compute one chunk; plain data in, plain data out, wherever it runs.

    Args:
        job_text: Text of the :class:`~nipper_pin.study.sweep.job.Job`.
        start: Number of the first scenario.
        rows: Values of the parameters, shape (scenarios, parameters).

    Returns:
        A Parquet file with one row a scenario. The same arguments give the same bytes.

    Raises:
        InputError: This process runs other versions than the planning one.
    """
    job = _job(job_text)
    columns = _Columns(job, start, rows)
    for first, last in _runs(rows[:, list(job.moving)]):
        _solve(job, job_text, rows, columns, slice(first, last))
    return columns.parquet()


class _Columns:
    """Results of all scenarios of a chunk as they come in."""

    def __init__(self, job: Job, start: int, rows: FloatArray) -> None:
        n = len(rows)
        self.numbers = np.arange(start, start + n, dtype=np.int64)
        self.rows = rows
        self.axes = [axis.name for axis in job.axes]
        self.engine = np.full(n, _NO_ENGINE, dtype="U8")
        self.outcome = np.full(n, FAILED, dtype="U24")
        self.message = [""] * n
        self.collisions = np.zeros(n, dtype=np.int32)
        self.values = {name: np.full(n, np.nan) for name in job.quantities}

    def fail(self, part: slice, outcome: str, message: str) -> None:
        """Mark scenarios that have no result."""
        self.outcome[part] = outcome
        self.message[part] = [message] * (part.stop - part.start)

    def parquet(self) -> bytes:
        """The bytes of the file."""
        import pyarrow as pa
        import pyarrow.parquet as pq

        words = ["engine", "outcome", "message"]
        data: dict[str, Any] = {
            "scenario": self.numbers,
            **{name: self.rows[:, place] for place, name in enumerate(self.axes)},
            "engine": self.engine.tolist(),
            "outcome": self.outcome.tolist(),
            "message": self.message,
            "collisions": self.collisions,
            **self.values,
        }
        sink = pa.BufferOutputStream()
        # Bytes of numbers of the same size compress when they stand byte by byte.
        split = [*self.axes, *self.values]
        pq.write_table(
            pa.table(data),
            sink,
            compression="zstd",
            use_dictionary=words,
            use_byte_stream_split=split,
        )
        return bytes(sink.getvalue())


def _runs(keys: FloatArray) -> Iterator[tuple[int, int]]:
    """Ranges of rows that are equal."""
    new = np.flatnonzero((keys[1:] != keys[:-1]).any(axis=1)) + 1
    edges = [0, *new.tolist(), len(keys)]
    yield from pairwise(edges)


def _solve(job: Job, text: bytes, rows: FloatArray, columns: _Columns, part: slice) -> None:
    """Compute the scenarios of one mechanism."""
    values = {job.axes[place].target.path: float(rows[part.start, place]) for place in job.moving}
    try:
        mechanism = changed(job, values) if values else _unchanged(text)
    except MARKED as error:
        columns.fail(part, NO_MODEL, sentence(error))
        return
    try:
        speed, restitution, stiffness, preload = _cases(job, mechanism, rows[part])
        table = transition_table(
            mechanism,
            speed_rpm=speed,
            restitution=restitution,
            stiffness=stiffness,
            preload=preload,
            rest_rate=job.rest_rate,
            tolerance=job.tolerance,
            max_collisions=job.max_collisions,
            drive=job.drive,
        )
    except MARKED as error:
        columns.fail(part, FAILED, sentence(error))
        return
    columns.engine[part], columns.outcome[part] = table.engine, table.outcome
    columns.message[part] = table.message
    columns.collisions[part] = table.collisions
    for name, found in columns.values.items():
        found[part] = quantity(table, name)


def sentence(error: Exception) -> str:
    """What went wrong, and that it is a fault of the program if it is.

    Args:
        error: The error.
    """
    if isinstance(error, NipperError):
        return error.message
    return f"unforeseen, please report it: {type(error).__name__}: {error}"


def _cases(
    job: Job, mechanism: Mechanism, rows: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Speed and restitution, each shape (n,), stiffness and preload, each shape (n, springs)."""
    n = len(rows)
    stop = mechanism.stop(mechanism.transition_stop)
    speed, restitution = np.full(n, job.speed_rpm), np.full(n, stop.restitution)
    stiffness = np.tile([spring.stiffness for spring in mechanism.springs], (n, 1))
    preload = np.tile([spring.preload for spring in mechanism.springs], (n, 1))
    for column, axis in zip(rows.T, job.axes, strict=True):
        target = axis.target
        if target.kind == "speed":
            speed = column
        elif target.kind == "restitution":
            restitution = column
        elif target.kind == "stiffness":
            stiffness[:, target.spring] = column
        elif target.kind == "preload":
            preload[:, target.spring] = target.scale * column
    return speed, restitution, stiffness, preload


@lru_cache(maxsize=4)
def _job(text: bytes) -> Job:
    return read_job(text)


@lru_cache(maxsize=4)
def _unchanged(text: bytes) -> Mechanism:
    """The mechanism of a sweep that changes no dimension, built once a process."""
    return changed(_job(text), {})
