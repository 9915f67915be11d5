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
SPEED, VALUES = 900.0, [500.0, 550.0]


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


def facts(model: Path, shortcut: str) -> tuple[list[float], list[float]]:
    """What a check, a run, tables of turns and a comparison say of a machine.

    Behind that the clamped share of each of its turns, with both values of the shortcut.
    """
    machines = [nip.load(model, {shortcut: value}) for value in VALUES]
    case = nip.Case(speed_rpm=SPEED, window=nip.Window.CYCLE)
    runs = [nip.simulate(item, case) for item in machines]
    report = nip.check(machines[0], SPEED)
    tables = [nip.turn_table(item, speed_rpm=SPEED, turns=1, torques=True) for item in machines]
    hits = runs[0].to_frame("pyarrow").to_pydict()
    assert hits["stop"]
    shares = numbers([table.clamped_share for table in tables])
    return shares + numbers([
        [hits[key] for key in ("time_s", "impulse_N_s", "rebound_amplitude")],
        [[table.collisions, table.largest_torque] for table in tables],
        [(row.a, row.b) for row in nip.compare(*runs).rows], report.condition.value,
    ]), shares  # fmt: skip


def swept(model: Path, shortcut: str) -> list[float]:
    """The clamped shares of a sweep over the shortcut."""
    study = model / "study.toml"
    head = {"format": 1, "model": str(model), "case": {"window": "cycle", "turns": 1}}
    parameters = {shortcut: {"values": VALUES}, "speed_rpm": {"values": [SPEED]}}
    study.write_text(toml({**head, "parameters": parameters}), encoding="utf-8")
    nip.sweep(study, model / "out", workers=1)
    return numbers(nip.read_sweep(model / "out").to_frame("pyarrow").to_pydict()["clamped_share"])


@pytest.fixture(scope="module")
def apart(tmp_path_factory: pytest.TempPathFactory) -> tuple[list[float], list[float]]:
    """Of the machine all of whose names differ."""
    return facts(write(tmp_path_factory.mktemp("apart"), {}), "shortcut")


@pytest.mark.sampled(9)
@pytest.mark.parametrize("first", range(3))
@pytest.mark.parametrize("second", range(3))
def test_things_of_one_name_do_not_meet(
    first: int, second: int, tmp_path: Path, apart: tuple[list[float], list[float]]
) -> None:
    """In nine machines any two kinds that may share a name do, with one kind of every row."""
    places = (first, second, first + second, first, second)
    chosen = [kinds[place % len(kinds)] for kinds, place in zip(KINDS, places, strict=False)]
    chosen += [kind for (kind,) in KINDS[len(places) :]]
    same = dict.fromkeys(chosen, "same")
    model = write(tmp_path, same)
    whole, shares = apart
    # Coordinates are in the order of names: the same equations in another order.
    np.testing.assert_allclose(facts(model, "same")[0], whole, rtol=1e-7, atol=1e-10)
    np.testing.assert_allclose(swept(model, "same"), shares, rtol=1e-7, atol=0.0)
