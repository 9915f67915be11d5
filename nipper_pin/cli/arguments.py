"""What several commands share: model arguments, the mechanism they mean, JSON output."""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path
from typing import Any

from ..errors import InputError, UnknownNameError
from ..mechanism import Mechanism, load


def add_model(parser: argparse.ArgumentParser, *, json_output: bool = True) -> None:
    """Arguments that name a model, change its numbers and, if any is written, place JSON."""
    parser.add_argument(
        "model",
        nargs="?",
        default="e62",
        metavar="MODEL",
        help="name of a model that comes with the package, or a folder",
    )
    parser.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="PATH=VALUE",
        help="change a number of the model, for example "
        "stops.steeve.restitution=0.1; may be repeated",
    )
    parser.add_argument("--restitution", type=float, metavar="E", help="restitution of the jaw")
    parser.add_argument(
        "--stiffness", type=float, metavar="N_PER_M", help="spring rate; the preload length is kept"
    )
    parser.add_argument(
        "--speed",
        type=float,
        metavar="RPM",
        help="cylinder speed (default: the model's rated speed)",
    )
    if json_output:
        parser.add_argument("--json", metavar="FILE", help="write the result as JSON; - for stdout")


def load_mechanism(options: argparse.Namespace) -> Mechanism:
    """Load the mechanism that the arguments mean.

    Raises:
        InputError: A value or the model cannot be used.
    """
    overrides: dict[str, object] = {}
    for item in options.set:
        path, equals, value = item.partition("=")
        if not equals:
            message = f"--set {item}: write PATH=VALUE, for example stops.jaw.restitution=0.1"
            raise InputError(message, argument=item)
        overrides[path.strip()] = value.strip()
    mechanism = load(options.model, overrides)
    short = {
        name: value
        for name in ("restitution", "stiffness")
        if (value := getattr(options, name)) is not None
    }
    if not short:
        return mechanism
    for name in short:
        if name not in mechanism.shortcuts:
            raise UnknownNameError(
                kind="shortcut", name=name, known=mechanism.shortcuts, where=options.model
            )
    return load(
        options.model,
        {**overrides, **{mechanism.shortcuts[name]: value for name, value in short.items()}},
    )


def speed(options: argparse.Namespace, mechanism: Mechanism) -> float:
    """Cylinder speed of the arguments, or the model's rated speed [r/min]."""
    if options.speed is not None:
        return float(options.speed)
    return mechanism.cylinder.rated_speed_rpm


def check_outputs(folder: str | None, document: str | None) -> None:
    """Refuse what cannot be written before anything is computed for it.

    Args:
        folder: Folder of files, or None.
        document: File of the JSON document, - for stdout, or None.

    Raises:
        InputError: One of them cannot be written.
    """
    from ..hybrid.writable import check_file, check_folder

    if folder is not None:
        check_folder(folder)
    if document is not None and document != "-":
        check_file(document)


def write_json(document: dict[str, Any], target: str) -> None:
    """Write a document to a file, which appears only when it is complete, or to stdout."""
    text = json.dumps(document, indent=1, allow_nan=False) + "\n"
    if target == "-":
        sys.stdout.write(text)
        return
    from ..hybrid.storage import complete_file

    with complete_file(Path(target)) as partial:
        partial.write_text(text, encoding="utf-8")
