"""``nipper-pin new``."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from ..errors import InputError, UnknownNameError
from ..view.console import paste, say, show_table, unbroken_console
from .arguments import add_flag, add_value, command, refuse_beside


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Define the arguments of the command."""
    text = "folder or NAME.toml to write; its name becomes the machine's"
    parser.add_argument("model", metavar="MODEL", nargs="?", help=text)
    text = "start from this machine of the gallery, not from the commented press"
    add_value(parser, "--from", "NAME", text, str)
    text = "start from a URDF that another program exported: a copy, its meshes, and a TOML"
    add_value(parser, "--urdf", "FILE", text, str)
    text = "write the commented file of a study instead: sweep, optimise or identify"
    add_value(parser, "--study", "KIND", text, str)
    add_flag(parser, "--list", "name the machines of the gallery")
    parser.set_defaults(run=_run)


def _run(options: argparse.Namespace) -> None:
    if options.list:
        refuse_beside(options, "--list", "MODEL", "--from", "--urdf", "--study")
        _list()
    elif options.model is None:
        message = "name the folder to write, as in nipper-pin new my_press"
        raise InputError(message)
    elif options.urdf is not None:
        refuse_beside(options, "--urdf", "--from", "--study")
        _exported(options.urdf, options.model)
    elif options.study is not None:
        refuse_beside(options, "--study", "--from")
        _study(options.study, options.model)
    else:
        _drawing(getattr(options, "from"), options.model)


def _list() -> None:
    from ..mechanism.gallery import GALLERY, drawn

    console = unbroken_console()
    rows = [(name, str(drawn(name).tables["title"])) for name in GALLERY]
    show_table(console, ("machine", "what it is"), rows, text=(0, 1))
    say(console, f"Found: {len(rows)} machines to start from.")
    paste(console, f"Next: nipper-pin new my_machine --from {rows[0][0]}")


def _drawing(name: str | None, model: str) -> None:
    from ..mechanism.gallery import file_of
    from ..mechanism.model_files import new_model
    from ..mechanism.skeleton import write_skeleton

    if name is None:
        write_skeleton(model)
    else:
        new_model(model, file_of(name).read_text(encoding="utf-8"))
    what = name or "a press with one stop to strike and one to come back to, every line explained"
    advice = "Change its points, bodies and joints, and check after each."
    written(f"{model}: {what}; one drawing, in mm. {advice}", model)


def _study(kind: str, file: str) -> None:
    from ..study.starts import STUDIES, write_study

    if kind not in STUDIES:
        raise UnknownNameError(kind="study", name=kind, known=STUDIES, where="--study")
    write_study(kind, file)
    console = unbroken_console()
    say(console, f"{file}: a study of e62, every line explained. It runs as it stands:")
    paste(console, f"  {command(kind, file)}")


def _exported(urdf: str, model: str) -> None:
    from ..mechanism.skeleton import take_urdf

    found, console = take_urdf(urdf, model), unbroken_console()
    say(console, f"{model}: a copy of {Path(urdf).name}, and a TOML file to complete")
    rows = [
        *((f"closure {name}", f"{each['frame_a']} meets {each['frame_b']}, "
           f"{found.gaps_mm[name]:.3g} mm apart") for name, each in found.closures.items()),
        *((f"stop {name}", f"{each['side']} limit of {each['joint']}, {_place(each)}; "
           "restitution guessed") for name, each in found.stops.items()),
        *((f"joint {name}", "may be driven: see the end of the TOML")
          for name in found.drives),
        *((f"frame {name}", "nothing uses it: a pin in a slot?") for name in found.unused),
        *((f"mesh {name}", "is not there") for name in found.lost),
    ]  # fmt: skip
    if rows:
        show_table(console, ("found", "what it is"), rows, text=(0, 1))
    if found.wrong:
        say(console, f"Not yet a machine: {found.wrong}")
    say(console, "What is left to decide, and what looks like mm or g:")
    paste(console, f"  {command('check', model)}")


def _place(stop: dict[str, Any]) -> str:
    return f"{stop['at_mm']:g} mm" if "at_mm" in stop else f"{stop['at_deg']:g} deg"


def written(head: str, model: str) -> None:
    """Tell what was written, and what to run next."""
    console, turns = unbroken_console(), ("--window", "cycle")
    say(console, head)
    say(console, "It runs as it stands:")
    for words in (
        ("check", model),
        ("simulate", model, *turns),
        ("view", model, *turns, "--html", f"{model.removesuffix('.toml')}.html"),
    ):
        paste(console, f"  {command(*words)}")
