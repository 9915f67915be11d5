"""Every kind of file and message that comes from other people, as a function of its bytes.

Each gives True if the input was taken and False if it was refused as it should be: by an error of
the package, in one line. All else comes through. The tests of the corpus call them.
"""

from __future__ import annotations

import atexit
import json
import os
import re
import shutil
import tempfile
import zlib
from collections.abc import Callable
from functools import cache
from pathlib import Path
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

from nipper_pin import (
    Case,
    Mechanism,
    NipperError,
    Solution,
    load,
    load_case,
    load_solution,
)
from nipper_pin.mechanism import find_model

if TYPE_CHECKING:
    from nipper_pin.study.sweep import Plan

HERE = Path(__file__).parent
CORPUS = HERE / "corpus"
_BASES = {"parts": HERE / "bases" / "parts", "e62": find_model("e62")}
# One of so many models that can be used is simulated as well, and another one followed by turns.
_SIMULATED = 50
_COLLISIONS = 8


class NotOneLineError(AssertionError):
    """A refusal without words, or one that is longer than a line."""


def judged(use: Callable[[], object]) -> bool:
    """Whether an input was taken; refused it may be by one line alone."""
    try:
        use()
    except NipperError as error:
        if not error.message.strip() or len(error.message.splitlines()) != 1:
            raise NotOneLineError(repr(error.message)) from error
        return False
    return True


@cache
def home() -> Path:
    """Folder of this process in memory, with a folder for each base."""
    root = Path("/dev/shm") if os.access("/dev/shm", os.W_OK) else None
    folder = Path(tempfile.mkdtemp(prefix="nipper_fuzz_", dir=root))
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    for name, base in _BASES.items():
        shutil.copytree(base, folder / name)
    return folder


def _base(data: bytes) -> str:
    """The model that a text belongs to: the one that its first line names."""
    return "e62" if b"e62" in data[:200] else "parts"


def _used(mechanism: Mechanism, data: bytes) -> None:
    """What is cheap and what commands do with a model first."""
    from nipper_pin.view.scene.solids import solids

    repr(mechanism)
    mechanism._repr_html_()
    solids(mechanism)
    chance = zlib.crc32(data) % _SIMULATED
    if chance == 0:
        simulated(mechanism)
    elif chance == 1:
        turned(mechanism)


def turned(mechanism: Mechanism) -> None:
    """A few turns of the reduced engine at three speeds, which may fail in one line."""
    from nipper_pin.reduced.turns import turn_quantities

    rated = mechanism.cylinder.rated_speed_rpm
    speeds = [0.5 * rated, rated, 3.0 * rated]
    judged(lambda: turn_quantities(mechanism, speed_rpm=speeds, turns=4, last=2))


def simulated(mechanism: Mechanism) -> None:
    """A short transition, which may fail in one line."""
    from nipper_pin import Resolution, simulate

    fine = Resolution(tolerance=1e-8)
    case = Case(
        speed_rpm=mechanism.cylinder.rated_speed_rpm, max_collisions=_COLLISIONS, resolution=fine
    )
    judged(lambda: simulate(mechanism, case))


def _model(data: bytes, suffix: str) -> bool:
    name = _base(data)
    folder = home() / name
    file = folder / f"{name}.{suffix}"
    file.write_bytes(data)
    try:
        return judged(lambda: _used(load(folder), data))
    finally:
        shutil.copyfile(_BASES[name] / file.name, file)


def urdf(data: bytes) -> bool:
    """A URDF beside the TOML of its base."""
    return _model(data, "urdf")


def toml(data: bytes) -> bool:
    """A TOML file beside the URDF of its base."""
    return _model(data, "toml")


_TABLES = {
    b"coordinate_deg": '[springs.tab]\njoint = "jaw"\nfile = "t.csv"\n',
    b"coordinate_mm": '[springs.tab]\njoint = "steeve"\nfile = "t.csv"\n',
}
_DRIVE = '[drives.tension]\njoint = "tension_shaft"\nlaw = "table"\nfile = "t.csv"\n'


def csv(data: bytes) -> bool:
    """A table of a spring or a drive, by its first word."""
    folder = home() / "e62"
    text = (_BASES["e62"] / "e62.toml").read_text(encoding="utf-8")
    (folder / "t.csv").write_bytes(data)
    head = next((key for key in _TABLES if data.startswith(key)), None)
    if head is None:
        text = re.sub(r"\[drives.tension\].*?(?=\n\[|\n#)", _DRIVE, text, flags=re.DOTALL)
    else:
        text += "\n" + _TABLES[head]
    (folder / "e62.toml").write_text(text, encoding="utf-8")
    try:
        return judged(lambda: _used(load(folder), data))
    finally:
        shutil.copyfile(_BASES["e62"] / "e62.toml", folder / "e62.toml")


def measured(data: bytes) -> bool:
    """Measured rebounds."""
    from nipper_pin.study.identify.problem.measured import read_measured

    file = home() / "measured.csv"
    file.write_bytes(data)
    return judged(lambda: read_measured(file))


def case(data: bytes) -> bool:
    """A saved case; the folder of its model is that of the base."""
    file = home() / "case.json"
    file.write_bytes(data.replace(b"@HOME@", str(home()).encode()))
    return judged(lambda: _used(load_case(file)[0], data))


def npz(data: bytes) -> bool:
    """A saved run, and all that is computed of it when it is asked for."""
    file = home() / "run.npz"
    file.write_bytes(data)
    read: list[Solution] = []
    if not judged(lambda: read.append(load_solution(file))):
        return False
    judged(lambda: _asked(read[0]))
    return True


def _asked(solution: Solution) -> None:
    """Everything that a solution computes."""
    repr(solution)
    solution._repr_html_()
    for question in ("collisions", "phases", "transitions", "drive_impulses", "errors", "energy"):
        getattr(solution, question)
    assert solution.checks is not None
    start, end = solution.trajectory.span
    solution.trajectory.reactions(0.5 * (start + end))
    for event in solution.events[:4]:
        solution.motion_at(event)
    json.dumps(solution.collisions, default=repr)


def parquet(data: bytes) -> bool:
    """A chunk of a sweep, alone and in the folder of its sweep."""
    from nipper_pin.study.sweep import read_sweep
    from nipper_pin.study.sweep.results import Tally
    from nipper_pin.study.sweep.results.chunk_file import check, read_file
    from nipper_pin.study.sweep.results.tally import SUMMARY

    folder = home() / "sweep"
    file = folder / "chunks" / "0000000.parquet"
    if not folder.exists():
        file.parent.mkdir(parents=True)
        shutil.copyfile(HERE / "bases" / "plan.json", folder / "plan.json")
    file.write_bytes(data)

    def use() -> None:
        table = read_file(file, SUMMARY)
        plan = json.loads((folder / "plan.json").read_bytes())["identity"]
        check(table, file.name, 0, 4, plan)
        Tally().add(table)

    judged(use)
    return judged(lambda: read_sweep(folder).to_frame("pandas"))


def plan(data: bytes) -> bool:
    """The record of a sweep's plan: read with its chunks, and gone on with."""
    from nipper_pin.study.sweep import read_sweep
    from nipper_pin.study.sweep.results import Store

    folder = home() / "plan"
    if not folder.exists():
        (folder / "chunks").mkdir(parents=True)
        shutil.copyfile(HERE / "bases" / "0000000.parquet", folder / "chunks" / "0000000.parquet")
    planned = _sweep()
    (folder / "plan.json").write_bytes(
        data.replace(b"@IDENTITY@", planned.job.identity.encode())
        .replace(b"@HASH@", planned.hash.encode())
        .replace(b'"@VERSIONS@"', json.dumps(planned.job.versions).encode())
    )
    judged(lambda: repr(read_sweep(folder, most=2)))
    return judged(lambda: Store(folder, planned))


@cache
def _sweep() -> Plan:
    from nipper_pin.study.sweep import read_plan

    return read_plan(str(HERE / "bases" / "sweep.toml"))


def study(data: bytes) -> bool:
    """The file of a sweep, a design problem or an identification, by its keys."""
    from nipper_pin.study.identify import read_problem
    from nipper_pin.study.optimise.problem.problem_file import read_problem as read_design
    from nipper_pin.study.sweep import read_plan

    file = home() / "study.toml"
    file.write_bytes(data)
    if re.search(rb"minimise|maximise", data):
        return judged(lambda: read_design(file))
    if re.search(rb"targets|measured", data):
        shutil.copyfile(HERE / "bases" / "rebounds.csv", home() / "rebounds.csv")
        return judged(lambda: read_problem(file))
    return judged(lambda: read_plan(str(file)).chunks())


def live(data: bytes) -> bool:
    """A message to the live page, and the answer to the value that it asks for."""
    from viser import _messages

    from nipper_pin.view.live.answer import answer
    from nipper_pin.view.live.guard import _taken

    if not _taken(data):
        return False
    message = _messages.Message.deserialize(data)
    controls, filter_ = _page()
    if not isinstance(message, _messages.GuiUpdateMessage):
        _placed(message)
        return True
    value = filter_.allowed(message.uuid, message.updates)
    if value is None or message.uuid == "play":
        return value is not None
    shown = {item.key: item.start for item in controls} | {message.uuid: value}
    if zlib.crc32(data) % _SIMULATED == 0:
        repr(answer(load("e62"), controls, shown))
    return True


@cache
def _page() -> tuple[Any, Any]:
    """Controls of the page of the E62, and the filter before them."""
    from viser import _messages

    from nipper_pin.view.live.guard import Filter
    from nipper_pin.view.live.settings import knobs

    controls = knobs(load("e62"), 450.0)
    interface = SimpleNamespace(
        _incoming_handlers={_messages.GuiUpdateMessage: [lambda *_: None]},
        unregister_handler=lambda *_: None,
        register_handler=lambda *_: None,
    )
    server = SimpleNamespace(gui=SimpleNamespace(_websock_interface=interface))
    ranges = {item.key: (item.low, item.high) for item in controls}
    return controls, Filter(server, ranges, frozenset({"play"}))


def _placed(message: object) -> None:
    """What viser does with the place of a camera: four or three numbers each."""
    import numpy as np

    for name, size in (("wxyz", 4), ("position", 3), ("look_at", 3), ("up_direction", 3)):
        value = np.array(getattr(message, name))
        assert value.shape == (size,), name
        assert value.dtype.kind in "fi", name


TARGETS: dict[str, Callable[[bytes], bool]] = {
    item.__name__: item
    for item in (urdf, toml, csv, measured, case, npz, parquet, plan, study, live)
}
"""Name of a folder of the corpus, and what reads its files."""
