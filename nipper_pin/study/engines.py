"""Which of the two engines computes many cases of one mechanism."""

from __future__ import annotations

from collections.abc import Callable
from typing import Literal, TypeVar

from ..dynamics import DriveMode
from ..errors import InputError, NipperError
from ..extras import installed
from ..reduced.inputs import checked_run
from .cases import Settings

Engine = Literal["auto", "direct", "reduced"]
T = TypeVar("T")


def check_engine(engine: str, settings: Settings) -> None:
    """Refuse an engine that does not exist, and settings that no engine has.

    Raises:
        InputError: One of them cannot be used.
    """
    if not isinstance(engine, str) or engine not in ("auto", "direct", "reduced"):
        message = f"engine = {engine!r} cannot be used: auto, direct or reduced"
        raise InputError(message, engine=engine)
    drive = settings.drive
    if not isinstance(drive, str) or drive not in set(DriveMode):
        message = f"drive = {drive!r} cannot be used: held or inertial"
        raise InputError(message, drive=drive)
    checked_run(settings.rest_rate, settings.tolerance, settings.max_collisions)


def chosen(
    tables: Callable[[], T],
    *,
    engine: Engine,
    count: int,
    pays_from: int,
    unfit: Callable[[], str | None],
) -> tuple[T | None, str]:
    """Choose by what was asked for, the mechanism, the number of cases and what is installed.

    Args:
        tables: Builds the tables of the reduced engine, or raises a NipperError.
        engine: What was asked for.
        count: Number of cases.
        pays_from: Number of cases from which on tables pay.
        unfit: Says why the mechanism has none, or None.

    Returns:
        The tables, or None for the direct engine, and the reason.
    """
    if engine == "direct":
        return None, "direct: asked for"
    if engine == "reduced":
        return tables(), "reduced: asked for"
    reason = unfit()
    if reason is not None:
        return None, f"direct: {reason}"
    if count < pays_from:
        return None, f"direct: the reduced engine pays from {pays_from} cases on"
    if not installed("numba"):
        return None, "direct: the reduced engine needs numba, which is not installed"
    try:
        return tables(), f"reduced: {count} cases of one mechanism"
    except NipperError as error:
        return None, f"direct: {error.message}"
