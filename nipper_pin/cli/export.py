"""``nipper-pin export``."""

from __future__ import annotations

import argparse

from .arguments import add_set, load_mechanism
from .new import written


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Define the arguments of the command."""
    text = "a model's name, a folder, or the TOML file of a drawing"
    parser.add_argument("model", metavar="MODEL", help=text)
    text = "folder to write; its name becomes the model's"
    parser.add_argument("folder", metavar="FOLDER", help=text)
    add_set(parser)
    parser.set_defaults(run=_run)


def _run(options: argparse.Namespace) -> None:
    from ..mechanism.export import export

    mechanism = load_mechanism(options)
    export(mechanism, options.folder)
    written(f"{options.folder}: {mechanism.title}, as URDF and TOML", options.folder)
