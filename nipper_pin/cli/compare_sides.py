"""The two sides of a comparison: the options of each, as of a run of its own, and the runs."""

from __future__ import annotations

import argparse
from pathlib import Path

from ..errors import InputError
from ..hybrid import Solution, Window, simulate
from ..written_units import number_in
from .arguments import MODEL, load_mechanism, overrides, refuse_beside
from .case_options import changed_case, given_settings, machine_and_case

_SPEED = "speed"
_SAVED = "solution.npz"


def sides(options: argparse.Namespace) -> list[argparse.Namespace]:
    """The options of both sides, like those of ``simulate``.

    Each has ``saved`` and ``beside`` as well: the saved run that it is, and that of the other side,
    whose settings a model takes over; both empty without one.

    Raises:
        InputError: There are more than two, a number is given twice, or a saved run is to have
            other turns or drives.
    """
    named = [item for item in (options.a, options.b) if item is not None]
    names = [*named, *getattr(options, "behind", [])] or [MODEL]
    if len(names) > 2:
        message = f"compare takes two, A and B, and these are {len(names)}: {', '.join(names)}"
        raise InputError(message, argument=names[2])
    names = [names[0], names[-1]]
    files = [_saved(name) for name in names]
    for file in filter(None, files):
        beside = f"{file}, a saved run, which keeps its own turns and drive"
        refuse_beside(options, beside, "--cycles", "--drive")
    return [
        argparse.Namespace(model=name, saved=file, beside=other, **_own(options, place))
        for place, (name, file, other) in enumerate(zip(names, files, files[::-1], strict=True))
    ]


def simulated(side: argparse.Namespace) -> Solution:
    """The run of a side: a saved one as it is, a new one for a model or for changes."""
    from ..hybrid.files.npz import load_solution

    if side.saved:
        run = load_solution(side.saved)
        if not (overrides(side) or given_settings(side)):
            return run
        return simulate(*machine_and_case(side, Window.CYCLE, (run.mechanism, run.case)))
    if side.beside:
        case = changed_case(load_solution(side.beside).case, side)
        return simulate(load_mechanism(side), case)
    return simulate(*machine_and_case(side, Window.CYCLE))


def _saved(name: str) -> str:
    """File of a saved run; empty for what is none."""
    path = Path(name)
    try:
        if path.suffix == ".npz":
            return name
        return str(path / _SAVED) if (path / _SAVED).is_file() else ""
    except (OSError, ValueError):
        # A name that no file can have; that there is no such model is told later.
        return ""


def _own(options: argparse.Namespace, place: int) -> dict[str, object]:
    """What side A (0) or B (1) is given: of what is for both, and its own.

    Raises:
        InputError: The speed is given twice, or is none.
    """
    shared = {name: getattr(options, name) for name in ("window", "start_index", "cycles")
              if hasattr(options, name)}  # fmt: skip
    paired = {name: getattr(options, name, None) for name in
              (_SPEED, "restitution", "stiffness", "drive")}  # fmt: skip
    own = {name: values and values[min(place, len(values) - 1)] for name, values in paired.items()}
    if own["drive"] is None:
        del own["drive"]
    changes = [*options.set, *(options.set_b if place else options.set_a)]
    speeds = [item for item in changes if item.partition("=")[0].strip() == _SPEED]
    for item in speeds:
        changes.remove(item)
        if own[_SPEED] is not None:
            message = f"--speed {own[_SPEED]:g} and {item}: leave one out"
            raise InputError(message, argument=_SPEED)
        own[_SPEED] = _number(item.partition("=")[2])
    return {"set": changes, **own, **shared}


def _number(text: str) -> float:
    try:
        return number_in(text.strip(), "rpm")
    except ValueError:
        message = f"speed={text}: write a number of revolutions per minute, as in speed=450"
        raise InputError(message, argument=_SPEED) from None
