"""One chunk of a sweep: rows of parameters to the bytes of a Parquet file."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from functools import lru_cache
from itertools import pairwise
from pathlib import Path
from traceback import extract_tb
from typing import Any

import numpy as np

from ...arrays import FloatArray
from ...errors import NipperError, SimulationError
from ...hybrid.result.turns import is_of_drive
from ...mechanism import Mechanism, changed, from_sources, model_folder
from ..cases import Cases, Settings, cases_of
from ..transitions import FAILED, TURN, TransitionTable, table_of
from ..turns import TurnSettings, TurnTable, turns_of
from .axes import restitution_path
from .job import NO_MODEL, Job, read_job
from .quantities import quantity
from .results.chunk_file import encode

_NO_ENGINE = "none"
_LEFT = "the reduced engine"
_TURNS = "whole turns, since the premise of a transition does not hold"


class DefectError(SimulationError):
    """A fault of the program: an error that none of its parts raises on purpose.

    Evidence: ``scenario`` (the first one that it may be of), ``error``.
    """


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
        DefectError: A scenario meets a fault of the program.
    """
    job = _job(job_text)
    columns = _Columns(job, start, rows)
    for first, last in _runs(rows[:, list(job.moving)]):
        try:
            _solve(job, job_text, rows, columns, slice(first, last))
        except Exception as error:
            raise _defect(error, start + first, start + last) from error
    return columns.parquet()


class _Columns:
    """Results of all scenarios of a chunk as they come in."""

    def __init__(self, job: Job, start: int, rows: FloatArray) -> None:
        n = len(rows)
        self.numbers = np.arange(start, start + n, dtype=np.int64)
        self.rows = rows
        self.job = job
        # Rows that the direct engine had to serve, by the reason.
        self.direct: Counter[str] = Counter()
        self.engine = np.full(n, _NO_ENGINE, dtype="U12")
        self.outcome = np.full(n, FAILED, dtype="U24")
        self.message = [""] * n
        self.collisions = np.zeros(n, dtype=np.int32)
        self.premise = np.full(n, None, dtype=object)
        self.turns = np.zeros((0 if job.turn is None else 2, n), dtype=np.int32)
        self.values = {name: np.full(n, np.nan) for name in job.quantities}

    def fail(self, part: slice, outcome: str, message: str) -> None:
        """Mark scenarios that have no result."""
        self.outcome[part] = outcome
        self.message[part] = [message] * (part.stop - part.start)

    def keep(self, part: slice, table: TransitionTable | TurnTable) -> None:
        """Take over scenarios of one mechanism, and count why the direct engine served."""
        if isinstance(table, TurnTable):
            hits = table.collisions[table.mechanism.transition_stop]
            self.collisions[part] = np.nan_to_num(hits)
            self.turns[:, part] = table.turns, table.repeats_after
        else:
            self.collisions[part] = table.collisions
            self.premise[part] = table.premise_holds
        for name, found in self.values.items():
            found[part] = quantity(table, name)
        self.engine[part], self.outcome[part] = table.engine, table.outcome
        self.message[part] = table.message
        chosen, _, why = table.why.partition(";")[0].partition(": ")
        for engine, message in zip(table.engine, table.message, strict=True):
            if engine == TURN:
                self.direct[_TURNS] += 1
            elif engine == "direct" and chosen == "direct":
                self.direct[why] += 1
            elif engine == "direct":
                left = message.startswith(_LEFT)
                self.direct[message if left else f"{_LEFT} did not solve them"] += 1

    def parquet(self) -> bytes:
        """The bytes of the file."""
        import pyarrow as pa

        job = self.job
        return encode(
            {
                "scenario": self.numbers,
                **{axis.name: self.rows[:, place] for place, axis in enumerate(job.axes)},
                "engine": self.engine.tolist(),
                "outcome": self.outcome.tolist(),
                "message": self.message,
                "collisions": self.collisions,
                "premise_holds": pa.array(self.premise.tolist(), type=pa.bool_()),
                **dict(zip(("turns", "repeats_after"), self.turns, strict=False)),
                **self.values,
            },
            units=job.units,
            about={
                "model": job.name,
                "versions": dict(job.versions),
                "plan": job.identity,
                "study": job.study,
                "direct": dict(sorted(self.direct.items())),
            },
        )


def _runs(keys: FloatArray) -> Iterator[tuple[int, int]]:
    """Ranges of rows that are equal."""
    new = np.flatnonzero((keys[1:] != keys[:-1]).any(axis=1)) + 1
    edges = [0, *new.tolist(), len(keys)]
    yield from pairwise(edges)


def _solve(job: Job, text: bytes, rows: FloatArray, columns: _Columns, part: slice) -> None:
    """Compute the scenarios of one mechanism."""
    values = {job.axes[place].target.path: float(rows[part.start, place]) for place in job.moving}
    try:
        mechanism = _machine(text)
        if values:
            mechanism = changed(mechanism, values)
    except NipperError as error:
        columns.fail(part, NO_MODEL, error.message)
        return
    try:
        columns.keep(part, _table(job, mechanism, _cases(job, mechanism, rows[part])))
    except NipperError as error:
        columns.fail(part, FAILED, error.message)


def _table(job: Job, mechanism: Mechanism, cases: Cases) -> TransitionTable | TurnTable:
    shared: dict[str, Any] = {
        "drive": job.drive,
        "rest_rate": job.rest_rate,
        "tolerance": job.tolerance,
        "max_collisions": job.max_collisions,
    }
    if job.turn is None:
        return table_of(mechanism, cases, Settings(**shared))
    settings = TurnSettings(
        **shared,
        turns=job.turn.turns,
        least_force=job.turn.least_force_N,
        torques=any(is_of_drive(name, mechanism) for name in job.quantities),
        wanted=frozenset(job.quantities),
    )
    return turns_of(mechanism, cases, settings)


def _defect(error: Exception, first: int, last: int) -> DefectError:
    """Message about an error that is not the outcome of a scenario."""
    place = extract_tb(error.__traceback__)[-1]
    numbers = f"scenario {first}" if last - first == 1 else f"scenarios {first} to {last - 1}"
    message = (
        f"{numbers}: a fault of the program, please report it: {type(error).__name__}: {error} "
        f"({Path(place.filename).name}, line {place.lineno})"
    )
    return DefectError(message, scenario=first, error=repr(error))


def _cases(job: Job, mechanism: Mechanism, rows: FloatArray) -> Cases:
    n = len(rows)
    speed, restitution = np.full(n, job.speed_rpm), {}
    stops = {restitution_path(stop.name): stop.name for stop in mechanism.stops}
    stiffness = np.tile([spring.stiffness for spring in mechanism.springs], (n, 1))
    preload = np.tile([spring.preload for spring in mechanism.springs], (n, 1))
    for column, axis in zip(rows.T, job.axes, strict=True):
        target = axis.target
        if target.kind == "speed":
            speed = column
        elif target.kind == "restitution":
            restitution[stops[target.path]] = column
        elif target.kind == "stiffness":
            stiffness[:, target.spring] = column
        elif target.kind == "preload":
            preload[:, target.spring] = target.scale * column
    return cases_of(mechanism, speed, restitution, stiffness, preload)


_job = lru_cache(maxsize=4)(read_job)


@lru_cache(maxsize=4)
def _machine(text: bytes) -> Mechanism:
    """The mechanism of a sweep before its numbers are changed, built once a process."""
    job = _job(text)
    return from_sources(job.name, job.urdf, job.document, model_folder(job.name, job.folder))
