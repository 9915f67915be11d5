"""Is a saved run, case or sweep whole, and which version made it?

Everything is read as it is read for use. Besides, whatever has a checksum is compared with it, a
run is held against its own closures and energy balance, and a sweep against its plan.
"""

from __future__ import annotations

import zipfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..errors import InputError, NipperError
from ..hybrid.files.npz import load_case, load_solution, made_by
from ..hybrid.result.self_check import need_sound
from ..hybrid.result.solution import Solution
from ..outputs.seal import is_as_written
from ..texts import opened
from .sweep.results.chunk_file import DamageError, about, read_file
from .sweep.results.record import read_document
from .sweep.results.store import CHUNKS, PLAN, need_pyarrow

_PACKAGE = "nipper-pin"
_EDITED = "it is not as it was written: edited, or damaged"


@dataclass(frozen=True)
class Verified:
    """What was found of one file or folder.

    Attributes:
        path: The file or folder.
        kind: "run", "case" or "sweep".
        version: Version of the package that wrote it; empty if that cannot be told.
        text: What it holds, in a line; empty if it cannot be read.
        problems: What is wrong with it, a sentence each; none if it is whole.
        solution: Of a run that can be read.
    """

    path: Path
    kind: str
    version: str
    text: str
    problems: tuple[str, ...]
    solution: Solution | None = None


def verify(path: str | Path) -> tuple[Verified, ...]:
    """Read a saved run, case or sweep as a whole.

    Args:
        path: A file ``.npz`` or ``.json``, or a folder of ``simulate --out`` or of ``sweep``.

    Returns:
        What was found; of a folder of a run its case and its run.

    Raises:
        InputError: There is no such file or folder, or nothing of ours in it.
    """
    place = Path(path)
    if (place / PLAN).is_file() or (place / CHUNKS).is_dir():
        return (_sweep(place),)
    if place.is_dir():
        found = [place / name for name in ("case.json", "solution.npz") if (place / name).is_file()]
        if not found:
            message = f"{place}: holds no saved run, case or sweep; name one, or its folder"
            raise InputError(message, folder=str(place))
        return _agreeing(place, tuple(verify(file)[0] for file in found))
    if not place.exists():
        message = f"{place}: there is no such file or folder; name a saved run, case or sweep"
        raise InputError(message, path=str(place))
    return (_run(place) if place.suffix == ".npz" else _case(place),)


def _run(file: Path) -> Verified:
    version = made_by(file)
    try:
        solution = load_solution(file)
        with opened(file) as stream, zipfile.ZipFile(stream) as archive:
            damaged = archive.testzip()
        need_sound(solution)
        asked = (solution.collisions, solution.phases, solution.transitions, solution.errors)
    except NipperError as error:
        return Verified(file, "run", version, "", (error.message,))
    wrong = () if damaged is None else (f"{damaged} is damaged",)
    case = solution.case
    text = (
        f"{solution.mechanism.name}, {case.speed_rpm:g} r/min, {case.window.value}, "
        f"{len(asked[0])} collision{'' if len(asked[0]) == 1 else 's'}: {solution.outcome.value}"
    )
    return Verified(file, "run", version, text, wrong, solution)


def _case(file: Path) -> Verified:
    version = made_by(file)
    try:
        mechanism, case = load_case(file)
    except NipperError as error:
        return Verified(file, "case", version, "", (error.message,))
    text = f"{mechanism.name}, {case.speed_rpm:g} r/min, {case.window.value}"
    return Verified(file, "case", version, text, ())


def _agreeing(folder: Path, found: tuple[Verified, ...]) -> tuple[Verified, ...]:
    """The parts of a folder, the last with what it does not share with the others."""
    *cases, last = found
    if not cases or last.solution is None or cases[0].problems:
        return found
    mechanism, case = load_case(cases[0].path)
    run = last.solution
    same = (mechanism.urdf, mechanism.description, case) == (
        run.mechanism.urdf, run.mechanism.description, run.case,
    )  # fmt: skip
    if same:
        return found
    problem = f"{last.path.name} is a run of another case than {cases[0].path.name} in {folder}"
    return (*cases, Verified(last.path, last.kind, last.version, last.text, (problem,)))


def _sweep(folder: Path) -> Verified:
    need_pyarrow()
    try:
        plan = read_document(folder / PLAN)
        total, identity, version = _sizes(plan, folder)
    except InputError as error:
        return Verified(folder, "sweep", "", "", (error.message,))
    problems, done = [], 0
    if is_as_written(plan) is False:
        problems.append(f"{PLAN}: {_EDITED}")
    for file, count in _chunks(folder, identity):
        done += count if isinstance(count, int) else 0
        if isinstance(count, str):
            problems.append(f"{CHUNKS}/{file}: {count}")
    if done < total:
        left = total - done
        problems.append(
            f"{left} of {total} scenarios are missing; the same sweep with --out {folder} computes "
            "them"
        )
    return Verified(folder, "sweep", version, f"{done} of {total} scenarios", tuple(problems))


def _sizes(plan: dict[str, Any], folder: Path) -> tuple[int, str, str]:
    """Scenarios and identity of a plan, and the version that made it."""
    total, identity, versions = (plan.get(key) for key in ("scenarios", "identity", "versions"))
    if isinstance(total, int) and isinstance(identity, str) and isinstance(versions, dict):
        return total, identity, str(versions.get(_PACKAGE, ""))
    message = f"{folder / PLAN}: not the plan of a sweep, or a damaged one"
    raise InputError(message, file=str(folder / PLAN))


def _chunks(folder: Path, identity: str) -> Iterator[tuple[str, int | str]]:
    """Each chunk with the count of its scenarios that no other has, or with what is wrong."""
    last = 0
    for file in sorted((folder / CHUNKS).glob("*.parquet")):
        try:
            table = read_file(file)
            plan = about(table).get("plan")
        except DamageError as error:
            yield file.name, error.message.removeprefix(f"{file}: ")
            continue
        numbers = table["scenario"].to_pylist()
        rows = range(numbers[0], numbers[-1] + 1) if numbers else range(0)
        if plan != identity or list(rows) != numbers:
            yield file.name, "holds scenarios of another plan"
        elif rows.start < last:
            yield file.name, "holds scenarios of another chunk"
        else:
            last = rows.stop
            yield file.name, len(numbers)
