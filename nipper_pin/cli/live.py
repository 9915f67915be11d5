"""``nipper-pin live``."""

from __future__ import annotations

import argparse

from ..extras import require
from .arguments import add_model, load_mechanism, speed

_PORT = 7001


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Define the arguments of the command."""
    add_model(parser, json_output=False)
    parser.add_argument(
        "--port", type=int, default=_PORT, metavar="N", help=f"port to serve at (default {_PORT})"
    )
    parser.add_argument("--no-browser", action="store_true", help="serve without opening a browser")
    parser.set_defaults(run=_run)


def _run(options: argparse.Namespace) -> None:
    require("live", what="the live page")
    from ..view.live.serve import serve_live

    mechanism = load_mechanism(options)
    serve_live(mechanism, speed(options, mechanism), options.port, browser=not options.no_browser)
