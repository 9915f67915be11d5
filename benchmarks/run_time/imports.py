"""Times of imports: of the package beside Pinocchio's, and of libraries imported only if used."""

from __future__ import annotations

from dataclasses import dataclass

from nipper_pin.units import MS_PER_S, MS_PER_US

from .cost import run_python

# Never needed by a run that prints and draws nothing; rich alone is always installed.
_LIBRARIES = ("matplotlib.figure", "rich.console", "yourdfpy", "meshcat", "pandas")
_MISSING = "missing"


@dataclass(frozen=True)
class ImportCost:
    """Time of the imports of a headless run, by ``python -X importtime``.

    Attributes:
        pinocchio_ms: ``import pinocchio``, numpy included [ms].
        added_ms: What ``import nipper_pin`` adds to it [ms].
        used_ms: What it adds with all that ``load``, ``Case`` and ``simulate`` stand for [ms].
        ratio: The last by the first [-].
    """

    pinocchio_ms: float
    added_ms: float
    used_ms: float
    ratio: float


def left_out(runs: int) -> list[tuple[str, float, float]]:
    """Libraries that the command does not import at its start.

    Args:
        runs: Fresh interpreters for each of them; the fastest counts, for the first reads from the
            disk.

    Returns:
        Name of the library, time of ``import nipper_pin.cli`` without it and with it [ms]; none
        for one that is not installed.
    """
    found = []
    for library in _LIBRARIES:
        code = (
            "import time\nbegin = time.perf_counter()\nimport nipper_pin.cli\n"
            "own = time.perf_counter() - begin\n"
            f"try:\n    import {library}\n"
            "    print(own, time.perf_counter() - begin)\n"
            f"except ImportError:\n    print({_MISSING!r})\n"
        )
        answers = [run_python(code).split() for _ in range(runs)]
        if answers[0] == [_MISSING]:
            continue
        own, both = (
            MS_PER_S * min(float(answer[column]) for answer in answers) for column in (0, 1)
        )
        found.append((library.partition(".")[0], own, both))
    return found


def import_cost(runs: int = 3) -> ImportCost:
    """What the package adds to ``import pinocchio``; fastest of several interpreters."""
    code = "import pinocchio, nipper_pin; nipper_pin.load, nipper_pin.Case, nipper_pin.simulate"
    logs = [run_python(code, "-X", "importtime") for _ in range(runs)]
    pinocchio, added = (
        min(cumulative_ms(log, name) for log in logs) for name in ("pinocchio", "nipper_pin")
    )
    used = min(following_ms(log, "pinocchio") for log in logs)
    return ImportCost(pinocchio, added, used, used / pinocchio)


def cumulative_ms(log: str, module: str) -> float:
    """Cumulative time of a module in a log of import times: ``... self | cumulative | name``."""
    return MS_PER_US * next(total for _, total, name in _import_times(log) if name == module)


def following_ms(log: str, module: str) -> float:
    """Time of all imports that a log of import times shows after that of a module."""
    times = _import_times(log)
    last = max(place for place, (_, _, name) in enumerate(times) if name == module)
    return MS_PER_US * sum(own for own, _, _ in times[last + 1 :])


def _import_times(log: str) -> list[tuple[float, float, str]]:
    """Own and cumulative time of each module of such a log [us], and its name."""
    columns = (line.split(":")[-1].split("|") for line in log.splitlines() if line.count("|") == 2)
    return [
        (float(own), float(total), name.strip())
        for own, total, name in columns
        if own.strip().isdigit()
    ]
