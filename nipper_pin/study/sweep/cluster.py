"""Chunks on an existing Dask scheduler."""

from __future__ import annotations

from collections.abc import Generator, Iterable
from concurrent.futures import CancelledError
from importlib.util import find_spec

from ...arrays import FloatArray
from ...errors import InputError, SimulationError
from .chunks import run_chunk
from .plan import Chunk

_CONNECT_S = 20.0
# Chunks on the scheduler for each thread of its workers: one runs, others wait at hand.
_AHEAD = 3


def on_scheduler(
    job_text: bytes, tasks: Iterable[tuple[Chunk, FloatArray]], address: str
) -> Generator[tuple[Chunk, bytes], None, None]:
    """Compute chunks on the workers of a scheduler, and give each as it finishes.

    The scheduler gives the chunks of a worker that dies to others. Results come back here, where
    each chunk is taken once.

    Args:
        job_text: Text of the job.
        tasks: Chunks with their rows.
        address: Address of the scheduler, such as ``tcp://host:8786``.

    Raises:
        InputError: The scheduler cannot be reached, has no workers, or these have other versions.
        SimulationError: The scheduler was lost, or a chunk took down every worker that had it.
    """
    if find_spec("distributed") is None:
        message = "--scheduler needs Dask: pip install 'nipper-pin[cluster]'"
        raise InputError(message, package="distributed")
    from distributed import Client, Future, as_completed
    from distributed.scheduler import KilledWorker

    try:
        client = Client(address, timeout=_CONNECT_S, set_as_default=False)
    except (OSError, TimeoutError, ValueError) as error:
        message = f"--scheduler {address}: cannot be reached ({error}); start `dask scheduler`"
        raise InputError(message, scheduler=address) from error
    with client:
        try:
            client.wait_for_workers(1, timeout=_CONNECT_S)
        except TimeoutError as error:
            message = f"--scheduler {address}: has no workers; start `dask worker {address}`"
            raise InputError(message, scheduler=address) from error
        running: dict[str, Chunk] = {}
        done = as_completed(loop=client.loop)

        def result(future: Future) -> tuple[Chunk, bytes]:
            content: bytes = future.result()
            future.release()
            return running.pop(future.key), content

        try:
            for chunk, rows in tasks:
                while len(running) >= _AHEAD * max(1, sum(client.nthreads().values())):
                    yield result(next(done))
                future = client.submit(run_chunk, job_text, chunk.start, rows, pure=False)
                running[future.key] = chunk
                done.add(future)
            while running:
                yield result(next(done))
        except KilledWorker as error:
            message = (
                f"a chunk took down several workers of {address}, perhaps for want of memory; what "
                "is finished is kept: run the same command again"
            )
            raise SimulationError(message, scheduler=address) from error
        except (OSError, CancelledError) as error:
            message = (
                f"the scheduler {address} was lost ({error}); what is finished is kept: run the "
                "same command again"
            )
            raise SimulationError(message, scheduler=address) from error
