"""``nipper-pin live``."""

from __future__ import annotations

import argparse
from importlib.util import find_spec

from ..errors import InputError
from .arguments import add_model, load_mechanism, speed

_PORT = 7001
_LIBRARIES = ("viser", "trimesh", "manifold3d")  # of the extra


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Define the arguments of the command."""
    add_model(parser, json_output=False)
    parser.add_argument(
        "--port", type=int, default=_PORT, metavar="N", help=f"port to serve at (default {_PORT})"
    )
    parser.add_argument("--no-browser", action="store_true", help="serve without opening a browser")
    parser.set_defaults(run=_run)


def _run(options: argparse.Namespace) -> None:
    missing = next((name for name in _LIBRARIES if find_spec(name) is None), None)
    if missing is not None:
        message = (
            f"the live page needs {missing}, which is not installed; install the extra: "
            "pip install 'nipper-pin[live]'"
        )
        raise InputError(message, missing=missing)
    from ..view.live.serve import serve_live

    mechanism = load_mechanism(options)
    serve_live(mechanism, speed(options, mechanism), options.port, browser=not options.no_browser)
