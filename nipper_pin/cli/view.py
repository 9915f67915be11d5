"""``nipper-pin view``."""

from __future__ import annotations

import argparse
from pathlib import Path

from ..errors import InputError
from ..hybrid import Solution, Window, need_sound, simulate
from ..hybrid.result.json_document import record
from ..view import show
from .arguments import (
    add_look,
    add_model,
    add_server,
    add_value,
    need_suffix,
    refuse_beside,
    write_document,
)
from .case_options import add_window, machine_and_case


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Define the arguments of the command."""
    add_model(parser)
    add_window(parser, Window.CYCLE)
    text = "show a saved run (solution.npz of simulate --out); what would change it is refused"
    add_value(parser, "--solution", "FILE", text, str)
    add_look(parser)
    text = "write one self-contained page instead of serving it"
    add_value(parser, "--html", "FILE", text, str)
    text = "write the film in side view as a GIF instead of serving it"
    add_value(parser, "--gif", "FILE", text, str)
    add_server(parser, show.PORT)
    parser.set_defaults(run=_run)


def _run(options: argparse.Namespace) -> None:
    need_suffix("--html", options.html, ".html")
    need_suffix("--gif", options.gif, ".gif")
    files = [Path(file) for file in (options.html, options.gif) if file is not None]
    served, port = not files, show.PORT if options.port is None else options.port
    show.need_libraries(*files)
    from ..view.console import ending, unbroken_console
    from ..view.scene import Look

    if options.json == "-" and served:
        message = "--json - needs stdout to itself, and so does the server; add --html FILE"
        raise InputError(message, argument="--json -")
    if not served:
        refuse_beside(options, "--html and --gif, which serve nothing", "--port", "--no-browser")
    look = Look(slow=options.slow, exaggerate=options.exaggerate)
    if served:
        from ..view.local import listening

        # A port that cannot be used is told before anything is computed.
        listening(port).close()
    solution = _solution(options)
    need_sound(solution)
    free = write_document(lambda: record(solution), options.json)
    for place in files:
        show.write(solution, place, look)
    if free:
        ending(unbroken_console(), written=(options.html, options.gif, options.json))
    if served:
        from ..view.local import serve

        serve(show.shown_page(solution, look), port, browser=not options.no_browser)


def _solution(options: argparse.Namespace) -> Solution:
    """The saved run of the arguments, or a new one."""
    if options.solution is None:
        return simulate(*machine_and_case(options, Window.CYCLE))
    done = f"--solution {options.solution}, a run that is done"
    machine = (f"MODEL {options.model}", "--set", "--restitution", "--stiffness", "--speed")
    refuse_beside(options, done, *machine, "--window", "--start-index")
    from ..hybrid.files.npz import load_solution

    return load_solution(options.solution)
