"""The two sides of a comparison: what the command line names, and the runs of them."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from ..errors import InputError
from ..hybrid import Case, Solution, Window
from ..written_units import number_in
from .arguments import MODEL, ask_back, overrides, refuse_beside
from .case_options import changed_case

_SPEED = "speed"
_SAVED = "solution.npz"
_OF_MODELS = {"cycles": "--cycles", "drive": "--drive"}


@dataclass(frozen=True)
class Source:
    """One side.

    Attributes:
        name: Model or file, as it was written.
        file: The saved run; empty for a model.
        given: Numbers of the model that are changed, and ``speed``, by path or shortcut.
        beside: Saved run of the other side, whose settings a model takes over; empty without one.
        drive: The drive that is asked for; empty for the default.
    """

    name: str
    file: str
    given: tuple[tuple[str, object], ...]
    beside: str
    drive: str = ""


def sources(options: argparse.Namespace) -> tuple[Source, Source]:
    """Both sides of the arguments.

    Raises:
        InputError: There are more than two, a number is given twice, or a saved run is to have
            other turns or drives.
    """
    named = [item for item in (options.a, options.b) if item is not None]
    names = [*named, *getattr(options, "behind", [])]
    if len(names) > 2:
        message = f"compare takes two, A and B, and these are {len(names)}: {', '.join(names)}"
        raise InputError(message, argument=names[2])
    first = names[0] if names else MODEL
    second = names[1] if len(names) > 1 else first
    files = [_saved(first), _saved(second)]
    for file in filter(None, files):
        beside = f"{file}, a saved run, which keeps its own turns and drive"
        refuse_beside(options, beside, _OF_MODELS)
    given = [_given(options, place) for place in (0, 1)]
    drives = options.drive or [""]
    return (
        Source(first, files[0], given[0], files[1], drives[0]),
        Source(second, files[1], given[1], files[0], drives[-1]),
    )


def simulated(source: Source, options: argparse.Namespace) -> Solution:
    """The run of a side: a saved one as it is, a new one for a model or for changes.

    Args:
        source: The side.
        options: The arguments, for window and start.

    Raises:
        InputError: A file or value cannot be used.
        SimulationError: The motion cannot be followed.
    """
    from ..hybrid import simulate
    from ..hybrid.files.npz import load_solution
    from ..mechanism import changed, load

    numbers = dict(source.given)
    speed = numbers.pop(_SPEED, None)
    run = load_solution(source.file) if source.file else None
    again = numbers or speed is not None or hasattr(options, "window")
    if run is not None and not (again or hasattr(options, "start_index")):
        return run
    if run is None:
        mechanism = load(source.name, numbers)
        ask_back(mechanism, source.name, numbers)
        case = Case(speed_rpm=mechanism.cylinder.rated_speed_rpm, window=Window.CYCLE)
        if source.beside:
            case = load_solution(source.beside).case
    else:
        mechanism = changed(run.mechanism, numbers) if numbers else run.mechanism
        case = run.case
    if speed is not None:
        case = replace(case, speed_rpm=_number(speed))
    settings = _window(options) | ({"drive": source.drive} if source.drive else {})
    return simulate(mechanism, changed_case(case, argparse.Namespace(**settings)))


def told_settings(source: Source, window: Sequence[str]) -> list[str]:
    """Words of the command that shows one side alone.

    Args:
        source: The side.
        window: Words of what both show, where no saved case says it.
    """
    case = Path(source.file).with_name("case.json") if source.file else None
    if case is not None and not (source.given and case.is_file()):
        return ["view", "--solution", source.file]
    machine = told_machine(source)
    begin = [*machine, *window] if case is None else ["--case", str(case), *machine[1:]]
    words = ["simulate", *begin]
    words += told_drive(source)
    speed = dict(source.given).get(_SPEED)
    return words if speed is None else [*words, "--speed", f"{speed}"]


def told_machine(source: Source) -> list[str]:
    """Words that make the machine of a side, without its speed."""
    changed = (f"{name}={value}" for name, value in source.given if name != _SPEED)
    return [source.name, *(word for item in changed for word in ("--set", item))]


def told_drive(source: Source) -> list[str]:
    """Words of the drive of a side, if it was given."""
    return ["--drive", source.drive] if source.drive else []


def told_window(options: argparse.Namespace) -> list[str]:
    """Words of window, start and number of turns, as they were given."""
    names = {"window": "--window", "start_index": "--start-index", "cycles": "--cycles"}
    given = {name: word for name, word in names.items() if hasattr(options, name)}
    return [word for name, item in given.items() for word in (item, f"{getattr(options, name)}")]


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


def _given(options: argparse.Namespace, place: int) -> tuple[tuple[str, object], ...]:
    """Numbers of side A (0) or B (1): those of both and its own.

    Raises:
        InputError: A number is given twice.
    """
    own = options.set_b if place else options.set_a
    paired = {
        name: values[min(place, len(values) - 1)]
        for name in (_SPEED, "restitution", "stiffness")
        if (values := getattr(options, name)) is not None
    }
    speed = paired.pop(_SPEED, None)
    sets = argparse.Namespace(set=[*options.set, *own], **paired)
    found = overrides(sets)
    if speed is not None:
        if _SPEED in found:
            message = f"--speed {speed:g} and {_SPEED}={found[_SPEED]}: leave one out"
            raise InputError(message, argument=_SPEED)
        found[_SPEED] = speed
    return tuple(found.items())


def _number(value: object) -> float:
    try:
        return number_in(str(value), "rpm")
    except ValueError:
        message = f"speed={value}: write a number of revolutions per minute, as in speed=450"
        raise InputError(message, argument=_SPEED) from None


def _window(options: argparse.Namespace) -> dict[str, object]:
    """Window, start and turns of the arguments, without what this command reads itself."""
    names = ("window", "start_index", "cycles")
    return {"speed": None} | {
        name: getattr(options, name) for name in names if hasattr(options, name)
    }
