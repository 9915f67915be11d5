"""Things of different kinds may have one name: no reading, run or study mixes them up.

Names that have to differ are refused when the files are read: see refusals/.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from small_machines import frame, hinge, link, slide, sources

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
    box = '<geometry><box size="0.01 0.01 0.01"/></geometry>'
    drawn = f'<visual name="{name["visual"]}">{box}</visual>'
    lips = {
        side: f'<collision name="{label}"><origin xyz="{x} 0 0"/>{box}</collision></link>'
        for side, label, x in (("lower", "bed", -0.005), ("upper", name["shape"], 0.005))
    }
    coupled = hinge(name["coupled joint"], "frame", "wheel")
    parts = [
        link(name["link"], 0.3, 1e-3).replace("</link>", f"{drawn}</link>"),
        hinge(name["driven joint"], "frame", name["link"]),
        link("rod", 0.4, 1e-3), hinge("on_crank", name["link"], "rod", (0.05, 0.0)),
        frame(name["end"], "rod", (0.2, 0.0)),
        link("carrier", 0.5, 1e-3).replace("</link>", lips["lower"]),
        slide("along", "frame", "carrier", at=(0.25, 0.0)),
        link("follower", 0.2, 1e-3).replace("</link>", lips["upper"]),
        slide(name["stopped joint"], "carrier", "follower"),
        link("wheel", 0.1, 1e-4),
        coupled.replace("</joint>", f'<mimic joint="{name["stopped joint"]}"/></joint>'),
        link("yoke", 0.1, 1e-3), slide("across", "frame", "yoke", at=(0.25, 0.0)),
    ]  # fmt: skip
    on, ends = {"joint": name["stopped joint"]}, {"frame_a": "frame", "frame_b": "follower"}
    tables: dict[str, Any] = {
        "drives": {name["drive"]: {"joint": name["driven joint"], "law": "constant_speed",
                                   "ratio": 1.0}},
        "closures": {
            name["pin"]: {"frame_a": name["end"], "frame_b": "carrier"},
            name["slot"]: {"frame_a": "yoke", "frame_b": name["end"], "slot_axis": "z",
                           "block_mass_kg": 1e-3},
        },
        "springs": {
            name["spring"]: {**on, "stiffness_N_per_m": 500.0, "preload_length_mm": 3.0},
            name["rows"]: {**on, "coordinate_mm": [-200.0, 200.0], "force_N": [-100.0, 100.0]},
            name["spring between points"]: {**ends, "stiffness_N_per_m": 200.0,
                                            "free_length_mm": 250.0},
        },
        "dampers": {name["damper"]: {**on, "damping_N_s_per_m": 0.1},
                    name["damper between points"]: {**ends, "damping_N_s_per_m": 0.5}},
        "forces": {name["force"]: {**on, "law": "orifice", "c_N_s2_per_m2": 1.0}},
        "stops": {name["stop"]: {**on, "restitution": 0.2,
                                 "contact": {"lower": "bed", "upper": name["shape"]}},
                  name["other stop"]: {**on, "restitution": 0.3, "side": "upper", "at_mm": 300.0}},
        "phases": [{"number": 1, "name": name["phase"], "closed": [name["stop"]]},
                   {"number": 2, "name": "thrown", "closed": []}],
        "shortcuts": {name["shortcut"]: f"springs.{name['spring']}.stiffness_N_per_m"},
    }  # fmt: skip
    urdf, document = sources(parts, 2, gravity=9.81, **tables)
    target = folder / name["model"]
    target.mkdir()
    (target / f"{name['model']}.urdf").write_text(urdf, encoding="utf-8")
    (target / f"{name['model']}.toml").write_text(toml(document), encoding="utf-8")
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
