"""Faults while results are written: kills, full disks, broken disks, and two writers at once.

    python scripts/maintain/confirm/faults/campaign.py --kills 200 --seed 1
    python scripts/maintain/confirm/faults/campaign.py --writes
    python scripts/maintain/confirm/faults/campaign.py --pairs 10

Each command runs with something before it at its target, or nothing. After a fault the target holds
nothing, all that was there before, or all of the new result, as undisturbed runs wrote them; for a
sweep and other work that is kept in parts, each part by itself. A process that lived on has told of
the fault in one sentence, and left no partial file. Then the command is run again, without any
cleaning, and has to end with the undisturbed result. Whatever is not so is counted as wrong and
told, and the status is 1. Needs gcc.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from collections import Counter
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
from arena import Arena, NoCompilerError, build
from commands import COMMANDS, Command, write_inputs
from field import Field, Seen, shown
from kills import random_kills
from pairs import racing_pairs
from writes import KINDS, every_write

_STUDY = "study paper"


def campaign(options: argparse.Namespace, home: Path) -> int:
    """Run what the arguments ask for, and print a row for each command and kind of fault.

    Args:
        options: The arguments.
        home: Folder to work in.

    Returns:
        Number of wrong outcomes.
    """
    chosen = [item for item in COMMANDS if _asked(item, options)]
    shim = build(home)
    inputs = home / "in"
    write_inputs(inputs)
    sys.stdout.write(f"{'command':<20} {'fault':<8} {'runs':>5} {'wrong':>5}  found\n")
    wrong = 0
    study = any(item.name == _STUDY for item in chosen)
    with _arenas(shim, study=study, pairs=options.pairs > 0) as (one, two):
        for name in ("sweep", "sweep_before"):
            folder = str(inputs / name.replace("sweep", "swept"))
            one.run(["sweep", str(inputs / f"{name}.toml"), "--out", folder], home)
        for number, command in enumerate(chosen):
            field = Field(command, inputs, home / str(number), one)
            rng = np.random.default_rng([options.seed, number])
            if options.kills:
                every = sum(item.kills for item in COMMANDS)
                kills = round(options.kills * command.kills / every)
                wrong += _row(command, "kill -9", random_kills(field, kills, rng))
            for kind in KINDS if options.writes else ():
                step = options.step * command.step
                wrong += _row(command, kind, every_write(field, kind, step))
            if options.pairs:
                wrong += _row(command, "pair", racing_pairs(field, two, options.pairs, rng))
    return wrong


def _asked(command: Command, options: argparse.Namespace) -> bool:
    if options.only:
        return command.name in options.only
    return command.kills > 0 or not options.kills


@contextmanager
def _arenas(shim: Path, *, study: bool, pairs: bool) -> Iterator[tuple[Arena, Arena]]:
    with Arena(shim, study=study) as one:
        if not pairs:
            yield one, one
            return
        with Arena(shim, study=study) as two:
            yield one, two


def _row(command: Command, kind: str, runs: Iterable[Seen]) -> int:
    """Print how the runs of one command ended; returns how many were wrong."""
    found: Counter[str] = Counter()
    wrong: list[Seen] = []
    for seen in runs:
        told = " told" if seen.ended.status > 0 else ""
        found[shown(seen.states) + told] += 1
        wrong += [seen] if seen.wrong else []
    states = ", ".join(f"{name} {count}" for name, count in sorted(found.items()))
    row = f"{command.name:<20} {kind:<8} {found.total():>5} {len(wrong):>5}  {states}\n"
    sys.stdout.write(row)
    for seen in wrong[:5]:
        where = f"at {seen.fault.at} ({seen.ended.disturbed})" if seen.fault.at else ""
        sys.stdout.write(f"    {where} {seen.wrong}\n")
    sys.stdout.flush()
    return len(wrong)


def main() -> int:
    """Run the campaign.

    Returns:
        0 right, 1 something is wrong, 2 there is no gcc.
    """
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--kills", type=int, default=0, metavar="N", help="kills at random moments")
    parser.add_argument(
        "--writes", action="store_true", help="every call that writes, failing or killed"
    )
    parser.add_argument("--step", type=int, default=1, metavar="N", help="every N-th call only")
    parser.add_argument("--pairs", type=int, default=0, metavar="N", help="pairs of each command")
    parser.add_argument("--seed", type=int, default=1, metavar="S", help="seed of the moments")
    parser.add_argument("--only", action="append", metavar="NAME", help="this command alone")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as home:
        try:
            wrong = campaign(options, Path(home).resolve())
        except NoCompilerError as error:
            sys.stderr.write(f"not run: {error}\n")
            return 2
    sys.stdout.write(f"{wrong} wrong\n")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
