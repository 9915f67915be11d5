"""Chunks on the processors of this machine."""

from __future__ import annotations

from collections.abc import Generator, Iterable
from functools import partial

from ...arrays import FloatArray
from ..processes import KEPT, Workers
from .chunks import DefectError, run_chunk
from .plan import Chunk


def on_this_machine(
    job_text: bytes, tasks: Iterable[tuple[Chunk, FloatArray]], workers: int
) -> Generator[tuple[Chunk, bytes | DefectError], None, None]:
    """Compute chunks in processes, and give each as it finishes, or the defect that it met.

    Even one worker is a process of its own: what it computes does not depend on what else this
    one does.

    Raises:
        WorkerError: A process died.
    """
    with Workers(workers, advice=KEPT, apart=True) as pool:
        yield from pool.as_completed(
            (chunk, partial(_content, job_text, chunk.start, rows)) for chunk, rows in tasks
        )


def _content(job_text: bytes, start: int, rows: FloatArray) -> bytes | DefectError:
    """The bytes of a chunk, or the defect that it met: other chunks go on."""
    try:
        return run_chunk(job_text, start, rows)
    except DefectError as defect:
        return defect
