"""What a command may find where it is started: outputs that are closed, and interrupts."""

from __future__ import annotations

import os
import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager


def open_streams() -> None:
    """Open again what this process was started without, or files would take these numbers.

    What is written to a closed output is lost, and that is told as of any output that fails; where
    errors are told is closed as well, nobody is to be told.
    """
    # Each gets the lowest number that is free, which is its own.
    for name, mode, flags in (
        ("stdin", "r", os.O_RDONLY), ("stdout", "w", os.O_RDONLY), ("stderr", "w", os.O_WRONLY),
    ):  # fmt: skip
        if getattr(sys, name) is None:
            setattr(sys, name, open(os.open(os.devnull, flags), mode, encoding="utf-8"))  # noqa: SIM115


@contextmanager
def interrupts() -> Iterator[list[int]]:
    """Gives a list of the interrupts that came: a library may make another error of one.

    An extension module that is being imported does.
    """
    came: list[int] = []

    def note(number: int, _: object) -> None:
        came.append(number)
        raise KeyboardInterrupt

    # Whoever ignores or handles them goes on doing so, and only the main thread is interrupted.
    free = signal.getsignal(signal.SIGINT) is signal.default_int_handler
    if not free or threading.current_thread() is not threading.main_thread():
        yield came
        return
    before = signal.signal(signal.SIGINT, note)
    try:
        yield came
    finally:
        signal.signal(signal.SIGINT, before)
