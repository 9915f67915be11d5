"""``nipper-pin verify``."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from ..errors import DamagedError, InputError
from ..texts import read_text
from .arguments import check_outputs, write_json

if TYPE_CHECKING:
    from ..study.verify import Verified


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Define the arguments of the command."""
    parser.add_argument(
        "path",
        metavar="FILE-OR-FOLDER",
        help="a saved run (solution.npz), a case (case.json), or a folder of simulate --out or of "
        "a sweep",
    )
    parser.add_argument(
        "--json", metavar="FILE", help="write what was found as JSON to a file, or - for stdout"
    )
    parser.set_defaults(run=_run)


def _run(options: argparse.Namespace) -> None:
    from ..study.verify import verify

    check_outputs(None, options.json)
    found = verify(options.path)
    problems = [
        f"{item.path}: {problem}"
        for item in found
        for problem in (*item.problems, *_other_tables(item))
    ]
    if found[0].kind != "sweep":
        from ..view.run.export import missing

        problems += [f"{options.path}: {problem}" for problem in missing(Path(options.path))]
    if options.json is not None:
        write_json(_document(found, problems), options.json)
    if options.json != "-":
        _print(found, whole=not problems)
    if problems:
        raise DamagedError("; ".join(problems), problems=problems)


def _print(found: Sequence[Verified], *, whole: bool) -> None:
    from ..view.console import say, unbroken_console

    console = unbroken_console()
    for item in found:
        made = f"nipper-pin {item.version}" if item.version else "an unknown version"
        what = f" ({item.text})" if item.text else ""
        say(console, f"{item.path}: {item.kind}{what}, made by {made}")
    if whole:
        say(console, "whole")


def _document(found: tuple[Verified, ...], problems: list[str]) -> dict[str, object]:
    parts = [
        {"path": str(x.path), "kind": x.kind, "version": x.version, "holds": x.text} for x in found
    ]
    return {"whole": not problems, "parts": parts, "problems": problems}


def _other_tables(item: Verified) -> list[str]:
    """Tables beside a run that are not those of the run."""
    if item.solution is None or item.path.name != "solution.npz":
        return []
    from ..view.run.csv_tables import same_table, tables

    others = []
    for name, text in tables(item.solution):
        file = item.path.with_name(name)
        if file.is_file() and not same_table(_text(file, 2 * len(text)), text):
            others.append(f"{name} beside it is not the table of this run")
    return others


def _text(file: Path, most: int) -> str:
    """Content of a file; none if it is no text, or longer than what it is compared with."""
    try:
        return read_text(file, most)
    except (OSError, InputError, UnicodeDecodeError):
        return ""
