"""``nipper-pin view``."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from ..errors import InputError, one_line
from ..hybrid import Solution, Window, need_sound
from ..view.show import PORT, need_film, need_page
from .arguments import (
    add_model,
    check_outputs,
    load_mechanism,
    need_suffix,
    refuse_beside,
    write_json,
)
from .case_options import add_window, new_case


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Define the arguments of the command."""
    add_model(parser)
    add_window(parser, Window.CYCLE)
    parser.add_argument(
        "--solution",
        metavar="FILE",
        help="show a saved run (solution.npz of simulate --out); what would change it is refused",
    )
    parser.add_argument(
        "--slow",
        type=float,
        metavar="N",
        help="stretch time 1:N around events (default 1000, less for films above two minutes)",
    )
    parser.add_argument(
        "--exaggerate",
        type=float,
        metavar="N",
        help="draw rebounds N times as large, 1 to 1000 (default: so that they are seen)",
    )
    parser.add_argument(
        "--html", metavar="FILE", help="write one self-contained page instead of serving it"
    )
    parser.add_argument(
        "--gif", metavar="FILE", help="write the film in side view as a GIF instead of serving it"
    )
    parser.add_argument("--port", type=int, metavar="N", help=f"port to serve at (default {PORT})")
    parser.add_argument("--no-browser", action="store_true", help="serve without opening a browser")
    parser.set_defaults(run=_run)


def _run(options: argparse.Namespace) -> None:
    served = options.html is None and options.gif is None
    if options.html is not None or served:
        need_page()
    if options.gif is not None:
        need_film()
    from ..view.scene import Look
    from ..view.show import shown_page, write_page

    if options.json == "-" and served:
        message = "--json - needs stdout to itself, and so does the server; add --html FILE"
        raise InputError(message, argument="--json -")
    if not served:
        refuse_beside(
            options,
            "--html and --gif, which serve nothing",
            {"port": "--port", "no_browser": "--no-browser"},
        )
    look = Look(slow=options.slow, exaggerate=options.exaggerate)
    need_suffix("--html", options.html, ".html")
    need_suffix("--gif", options.gif, ".gif")
    for file in (options.html, options.gif, options.json):
        check_outputs(None, file)
    solution = _solution(options)
    need_sound(solution)
    if options.json is not None:
        from ..hybrid.result.json_document import record

        write_json(record(solution), options.json)
    if options.html is not None:
        write_page(solution, Path(options.html), look)
    if options.gif is not None:
        from ..view.scene.gif import write_gif

        write_gif(solution, options.gif, look)
    if options.json != "-":
        for place in filter(None, (options.html, options.gif, options.json)):
            sys.stdout.write(f"{one_line(f'written: {place}')}\n")
    if served:
        from ..view.scene.server import serve

        port = PORT if options.port is None else options.port
        serve(shown_page(solution, look), port, browser=not options.no_browser)


def _solution(options: argparse.Namespace) -> Solution:
    """The saved run of the arguments, or a new one.

    Raises:
        InputError: Arguments contradict one another, or a file or value cannot be used.
    """
    if options.solution is None:
        from ..hybrid import simulate

        mechanism = load_mechanism(options)
        return simulate(mechanism, new_case(options, mechanism, Window.CYCLE))
    refuse_beside(
        options,
        f"--solution {options.solution}, a run that is done",
        {
            "model": f"{options.model} (a model)",
            "set": "--set",
            "restitution": "--restitution",
            "stiffness": "--stiffness",
            "speed": "--speed",
            "window": "--window",
            "start_index": "--start-index",
        },
    )
    from ..hybrid.files.npz import load_solution

    return load_solution(options.solution)
