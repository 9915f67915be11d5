"""``nipper-pin view``."""

from __future__ import annotations

import argparse

from ..errors import InputError
from ..hybrid.case import Case, Window
from ..hybrid.solution import Solution
from .arguments import add_model, load_mechanism, speed, write_json

_PORT = 7000


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Define the arguments of the command."""
    add_model(parser)
    parser.add_argument(
        "--window",
        choices=[item.value for item in Window],
        help="transition: first collision to rest; cycle: one whole turn (default)",
    )
    parser.add_argument(
        "--start-index",
        type=float,
        default=24.0,
        metavar="INDEX",
        help="index at which the turn starts (default 24, foremost)",
    )
    parser.add_argument(
        "--solution", metavar="FILE", help="show a saved run (solution.npz of simulate --out)"
    )
    parser.add_argument(
        "--slow",
        type=float,
        default=1000.0,
        metavar="N",
        help="stretch time 1:N around events (default 1000)",
    )
    parser.add_argument(
        "--exaggerate",
        type=float,
        default=1.0,
        metavar="N",
        help="draw the gap of the jaw N times as large, 1 to 50 (default 1)",
    )
    parser.add_argument(
        "--html", metavar="FILE", help="write one self-contained page instead of serving it"
    )
    parser.add_argument(
        "--gif", metavar="FILE", help="write the film in side view as a GIF instead of serving it"
    )
    parser.add_argument(
        "--port", type=int, default=_PORT, metavar="N", help=f"port to serve at (default {_PORT})"
    )
    parser.add_argument("--no-browser", action="store_true", help="serve without opening a browser")
    parser.set_defaults(run=_run)


def _run(options: argparse.Namespace) -> None:
    from ..view.scene import Look, film, scene_page, serve, write_page

    served = options.html is None and options.gif is None
    if options.json == "-" and served:
        message = "--json - needs stdout to itself, and so does the server; add --html FILE"
        raise InputError(message, argument="--json -")
    look = Look(slow=options.slow, exaggerate=options.exaggerate)
    solution = _solution(options)
    if options.json is not None:
        from ..hybrid.record import record

        write_json(record(solution), options.json)
    if options.html is not None:
        write_page(solution, options.html, look)
    if options.gif is not None:
        from ..view.scene.gif import write_gif

        write_gif(solution, options.gif, look)
    if served:
        serve(scene_page(film(solution, look)), options.port, browser=not options.no_browser)


def _solution(options: argparse.Namespace) -> Solution:
    """The saved run of the arguments, or a new one.

    Raises:
        InputError: Arguments contradict one another, or a file or value cannot be used.
    """
    if options.solution is None:
        from ..hybrid.simulate import simulate

        mechanism = load_mechanism(options)
        window = Window(options.window or Window.CYCLE)
        case = Case(
            speed_rpm=speed(options, mechanism), window=window, start_index=options.start_index
        )
        return simulate(mechanism, case)
    given = [name for name in ("speed", "restitution", "stiffness", "window")
             if getattr(options, name) is not None]  # fmt: skip
    if options.set:
        given.append("set")
    if given:
        message = (
            f"--{given[0]} changes a run, and --solution {options.solution} shows one that is "
            "done; leave one of them out"
        )
        raise InputError(message, argument=given[0])
    from ..hybrid.storage import load_solution

    return load_solution(options.solution)
