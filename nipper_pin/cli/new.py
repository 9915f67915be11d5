"""``nipper-pin new``."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Define the arguments of the command."""
    parser.add_argument(
        "folder",
        metavar="MODEL",
        help="folder to write; its name becomes the model's",
    )
    parser.set_defaults(run=_run)


def _run(options: argparse.Namespace) -> None:
    from ..mechanism.skeleton import write_skeleton

    folder = write_skeleton(Path(options.folder))
    model = options.folder
    sys.stdout.write(
        f"{folder}: a press with one stop to strike and one to come back to, every line explained\n"
        f"  {folder.name}.urdf        links, joints, masses, shapes\n"
        f"  {folder.name}.toml        drive, spring, stops, closures, phases\n"
        "  model.schema.json  what editors complete the TOML by\n"
        "It runs as it stands:\n"
        f"  nipper-pin check {model}\n"
        f"  nipper-pin simulate {model} --window cycle\n"
        "Then replace its parts by yours, and check after each.\n"
    )
