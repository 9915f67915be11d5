"""Things of different kinds may have one name: no reading, run or study mixes them up.

Names that have to differ are refused when the files are read: see refusals/.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from programs import study_text

import nipper_pin as nip
from nipper_pin.mechanism.files import toml

# Kinds of one row need names of their own; of any two rows two may have the same.
KINDS = (
    ("driven joint", "stopped joint", "coupled joint"),
    ("link", "end", "shape"),
    ("spring", "rows", "spring between points"),
    ("damper", "damper between points"),
    ("stop", "other stop"),
    ("drive",), ("pin",), ("force",), ("phase",), ("shortcut",), ("visual",), ("model",),
)  # fmt: skip
SPEED = 900.0


def write(folder: Path, same: Mapping[str, str]) -> Path:
    """A crank whose rod drives a carrier, on which a follower rides that is thrown off its lip.

    Args:
        folder: Where its folder is written.
        same: Names by kind; each other thing has the name of its kind.
    """
    name = {kind: same.get(kind, kind) for kinds in (*KINDS, ("slot",)) for kind in kinds}
    target = folder / name["model"]
    target.mkdir()
    for suffix in ("urdf", "toml"):
        text = study_text(f"names/names.{suffix}")
        for kind, called in name.items():
            text = text.replace(f"@{kind}@", called)
        (target / f"{name['model']}.{suffix}").write_text(text, encoding="utf-8")
    return target


def numbers(data: Any) -> list[float]:
    """All numbers of plain data, in their order."""
    if isinstance(data, Mapping):
        data = list(data.values())
    if isinstance(data, list | tuple | np.ndarray):
        return [number for item in data for number in numbers(item)]
    return [float(data)] if isinstance(data, int | float | np.number) else []


def facts(model: Path, shortcut: str) -> list[float]:
    """What a check, a run, a table of turns, a comparison and a sweep say of a machine."""
    mechanism, other = nip.load(model), nip.load(model, {shortcut: 550.0})
    case = nip.Case(speed_rpm=SPEED, window=nip.Window.CYCLE)
    runs = [nip.simulate(item, case) for item in (mechanism, other)]
    report = nip.check(mechanism, SPEED)
    table = nip.turn_table(mechanism, speed_rpm=SPEED, turns=1, torques=True)
    study = model / "study.toml"
    head = {"format": 1, "model": str(model), "case": {"window": "cycle", "turns": 1}}
    parameters = {shortcut: {"values": [500.0, 550.0]}, "speed_rpm": {"values": [SPEED]}}
    study.write_text(toml({**head, "parameters": parameters}), encoding="utf-8")
    nip.sweep(study, model / "out", workers=1)
    rows = nip.read_sweep(model / "out").to_frame("pyarrow").to_pydict()
    hits = runs[0].to_frame("pyarrow").to_pydict()
    assert hits["stop"]
    return numbers([
        [hits[key] for key in ("time_s", "impulse_N_s", "rebound_amplitude")],
        table.clamped_share, table.collisions, table.largest_torque, rows["clamped_share"],
        [(row.a, row.b) for row in nip.compare(*runs).rows], report.condition.value,
    ])  # fmt: skip


@pytest.fixture(scope="module")
def apart(tmp_path_factory: pytest.TempPathFactory) -> list[float]:
    """Of the machine all of whose names differ."""
    return facts(write(tmp_path_factory.mktemp("apart"), {}), "shortcut")


@pytest.mark.sampled(9)
@pytest.mark.parametrize("first", range(3))
@pytest.mark.parametrize("second", range(3))
def test_things_of_one_name_do_not_meet(
    first: int, second: int, tmp_path: Path, apart: list[float]
) -> None:
    """In nine machines any two kinds that may share a name do, with one kind of every row."""
    places = (first, second, first + second, first, second)
    chosen = [kinds[place % len(kinds)] for kinds, place in zip(KINDS, places, strict=False)]
    chosen += [kind for (kind,) in KINDS[len(places) :]]
    same = dict.fromkeys(chosen, "same")
    found = facts(write(tmp_path, same), "same")
    # Coordinates are in the order of names: the same equations in another order.
    np.testing.assert_allclose(found, apart, rtol=1e-7, atol=1e-10)
