"""``nipper-pin new``."""

from __future__ import annotations

import argparse
import shlex
import sys
from pathlib import Path

from ..errors import InputError
from .arguments import refuse_beside


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Define the arguments of the command."""
    parser.add_argument(
        "folder",
        metavar="MODEL",
        nargs="?",
        help="folder to write; its name becomes the model's",
    )
    parser.add_argument(
        "--from",
        dest="start",
        metavar="NAME",
        help="start from this machine of the gallery, not from the commented press",
    )
    parser.add_argument("--list", action="store_true", help="name the machines of the gallery")
    parser.set_defaults(run=_run)


def _run(options: argparse.Namespace) -> None:
    if options.list:
        refuse_beside(options, "--list", {"folder": "MODEL", "start": "--from"})
        _list()
    elif options.folder is None:
        message = "name the folder to write, as in nipper-pin new my_press"
        raise InputError(message)
    elif options.start is None:
        _skeleton(options.folder)
    else:
        _from_gallery(options.start, options.folder)


def _list() -> None:
    from ..mechanism.gallery import GALLERY

    width = max(map(len, GALLERY))
    for name, draw in GALLERY.items():
        sys.stdout.write(f"{name:<{width}}  {draw().title}\n")


def _skeleton(model: str) -> None:
    from ..mechanism.skeleton import write_skeleton

    folder = write_skeleton(Path(model))
    sys.stdout.write(
        f"{folder}: a press with one stop to strike and one to come back to, every line explained\n"
        f"  {folder.name}.urdf        links, joints, masses, shapes\n"
        f"  {folder.name}.toml        drive, spring, stops, closures, phases\n"
        "  model.schema.json  what editors complete the TOML by\n"
        "It runs as it stands:\n"
        f"  {shlex.join(['nipper-pin', 'check', model])}\n"
        f"  {shlex.join(['nipper-pin', 'simulate', model, '--window', 'cycle'])}\n"
        "Then replace its parts by yours, and check after each.\n"
    )


def _from_gallery(name: str, model: str) -> None:
    from ..mechanism.drawing import write_drawing
    from ..mechanism.gallery import drawn

    drawing, turns = drawn(name), ("--window", "cycle")
    write_drawing(drawing, model)
    sys.stdout.write(
        f"{model}: {drawing.title}\n"
        f"  {drawing.known or drawing.invented}\n"
        "It runs as it stands:\n"
        f"  {shlex.join(['nipper-pin', 'check', model])}\n"
        f"  {shlex.join(['nipper-pin', 'simulate', model, *turns])}\n"
        f"  {shlex.join(['nipper-pin', 'view', model, *turns, '--html', f'{model}.html'])}\n"
    )
