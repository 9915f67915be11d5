"""``nipper-pin live``."""

from __future__ import annotations

import argparse

from ..extras import require
from .arguments import add_model, add_server, load_mechanism, speed

_PORT = 7001


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Define the arguments of the command."""
    add_model(parser, json_output=False)
    add_server(parser, _PORT)
    parser.set_defaults(run=_run)


def _run(options: argparse.Namespace) -> None:
    require("live", what="the live page")
    from ..view.live.serve import serve_live

    mechanism = load_mechanism(options)
    port = _PORT if options.port is None else options.port
    serve_live(mechanism, speed(options, mechanism), port, browser=not options.no_browser)
