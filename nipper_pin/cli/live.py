"""``nipper-pin live``."""

from __future__ import annotations

import argparse
from importlib.util import find_spec

from ..errors import InputError
from .arguments import load_mechanism, speed

_PORT = 7001


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Define the arguments of the command."""
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
        help="change a number of the model; may be repeated",
    )
    parser.add_argument(
        "--speed",
        type=float,
        metavar="RPM",
        help="speed at which the slider starts (default: the model's rated speed)",
    )
    parser.add_argument(
        "--restitution", type=float, metavar="E", help="restitution at which the slider starts"
    )
    parser.add_argument(
        "--stiffness",
        type=float,
        metavar="N_PER_M",
        help="spring rate at which the slider starts; the preload length is kept",
    )
    parser.add_argument(
        "--port", type=int, default=_PORT, metavar="N", help=f"port to serve at (default {_PORT})"
    )
    parser.add_argument("--no-browser", action="store_true", help="serve without opening a browser")
    parser.set_defaults(run=_run)


def _run(options: argparse.Namespace) -> None:
    if find_spec("viser") is None:
        message = (
            "the live page needs viser, which is not installed; install the extra: "
            "pip install 'nipper-pin[live]'"
        )
        raise InputError(message, missing="viser")
    from ..view.live.serve import serve_live

    mechanism = load_mechanism(options)
    serve_live(mechanism, speed(options, mechanism), options.port, browser=not options.no_browser)
