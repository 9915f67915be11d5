"""The commands, and what they have in common: to say what is done, and what becomes of a result."""

from __future__ import annotations

import sys
from collections.abc import Callable
from typing import Any

from nipper_pin.cli.arguments import write_json
from nipper_pin.errors import InputError


def tell(text: str) -> None:
    """Say on a terminal what is being done."""
    if sys.stderr.isatty():
        sys.stderr.write(f"{text} ...\n")


def need_least(options: Any, **least: int) -> None:
    """Refuse numbers that are smaller."""
    for name, lowest in least.items():
        value = getattr(options, name)
        if value is not None and value < lowest:
            message = f"--{name} {value}: at least {lowest}"
            raise InputError(message, argument=value)


def hand_over(
    result: Any, options: Any, write: Callable[..., object], show: Callable[..., None]
) -> None:
    """Write files and the document as they are asked for, and show the result elsewhere."""
    from nipper_pin.view.console import Terminal

    if options.out is not None:
        write(result, options.out)
    if options.json is not None:
        write_json(result.record(), options.json)
    if options.json != "-":
        show(result, Terminal())
