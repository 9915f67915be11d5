"""The largest inputs that are read, and one more: at most 1 GB of memory each.

Each is read by a process of its own, whose memory the system tells.
"""

from __future__ import annotations

import json
import struct
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from refusals import packed, stored_run
from small_machines import frame, hinge, link, sources

from nipper_pin import Case, load, save, simulate
from nipper_pin.hybrid.files import archive
from nipper_pin.mechanism.elements import MOST_ROWS
from nipper_pin.mechanism.files import toml
from nipper_pin.mechanism.files.urdf_shapes import MOST_MESH
from nipper_pin.study.sweep.results import chunk_file
from nipper_pin.texts import MOST_JSON, MOST_TABLE, MOST_TEXT
from tests.refusals.bases import TENSION, model
from tests.refusals.hostile import LIP

BYTES = 10**9
# What grows with the square of a file would take hours: a process that takes minutes is ended.
READ = """
import json, resource, sys
from pathlib import Path
from numpy import linspace
from nipper_pin import NipperError, load, load_case, load_solution
from nipper_pin.reduced.turns import turn_quantities, turns
from nipper_pin.study.sweep.results.chunk_file import read_file
from nipper_pin.view.scene.meshes import read_mesh
def most_turns(_):
    many = {"mechanism": load("e62"), "speed_rpm": linspace(300.0, 600.0, 100)}
    turns(load("e62"), speed_rpm=450.0, cycles=10_000)
    turn_quantities(**many, turns=10_000, last=8_600)
    turn_quantities(**many, max_collisions=1_000_000)
resource.setrlimit(resource.RLIMIT_CPU, (120, 120))
readers = {"model": load, "case": load_case, "run": load_solution, "chunk": read_file,
           "mesh": read_mesh, "turns": most_turns}
said = ""
try:
    readers[sys.argv[1]](Path(sys.argv[2]))
except NipperError as error:
    said = error.message
# The largest memory of getrusage may be that of the process that started this one.
status = Path("/proc/self/status").read_text().splitlines()
memory = next(int(line.split()[1]) for line in status if line.startswith("VmHWM"))
print(json.dumps([1024 * memory, said]))
"""


def written(folder: Path, parts: list[str], freedom: int, **tables: Any) -> Path:
    """A model folder of these parts, with a stop at the first joint if no other is given."""
    urdf, document = sources(parts, freedom, **tables)
    home = folder / "m"
    home.mkdir()
    (home / "m.urdf").write_text(urdf)
    (home / "m.toml").write_text(toml({key: item for key, item in document.items() if item != ""}))
    return home


def four_bars(count: int, phases: int, frames: int) -> tuple[list[str], dict[str, Any]]:
    """Parts and tables of four-bars side by side, each with a stop, and frames on the root link."""
    parts = list[str]()
    for k in range(count):
        parts += [link(f"{name}{k}") for name in ("crank", "rod", "rocker")]
        parts += [
            hinge(f"a{k}", "frame", f"crank{k}", (10.0 * k, 0.0)),
            hinge(f"b{k}", f"crank{k}", f"rod{k}", (0.0, 1.0)),
            hinge(f"c{k}", "frame", f"rocker{k}", (10.0 * k + 3.0, 0.0)),
            frame(f"end{k}", f"rod{k}", (4.0, 1.0)), frame(f"pin{k}", f"rocker{k}", (1.0, 2.0)),
        ]  # fmt: skip
    parts += [frame(f"f{k}", "frame", (float(k), 0.0)) for k in range(frames)]
    tables = {
        "closures": {f"l{k}": {"frame_a": f"end{k}", "frame_b": f"pin{k}"} for k in range(count)},
        "stops": {f"s{k}": {"joint": f"a{k}", "restitution": 0.1} for k in range(count)},
        "phases": [{"number": k + 1, "name": "p", "closed": [f"s{place}" for place in range(k)]}
                   for k in range(phases)],
    }  # fmt: skip
    return parts, tables


def many_parts(folder: Path) -> Path:
    parts, tables = four_bars(166, 64, 2000 - 5 * 166 - 1)
    return written(folder, parts, 166, **tables)


def chain(folder: Path) -> Path:
    """Links that hang from one another."""
    names = ["frame", *(f"l{k}" for k in range(499))]
    parts = [link(name) + hinge(f"h{k}", names[k], name, (1.0, 0.0))
             for k, name in enumerate(names[1:])]  # fmt: skip
    springs = {f"t{k}": {"joint": f"h{k}", "stiffness_N_m_per_rad": 1.0, "preload_deg": 0.0}
               for k in range(300)}  # fmt: skip
    return written(folder, parts, 499, springs=springs)


def long_words(folder: Path) -> Path:
    """A URDF and a TOML file of the most letters."""
    parts, tables = four_bars(1, 1, 0)
    home = written(folder, [*parts, f"<!--{'x' * (MOST_TEXT - 5000)}-->"], 1, **tables)
    row = '"title.{0}" = "word"\n'
    rows = "".join(map(row.format, range((MOST_TEXT - 5000) // len(row) - 40_000)))
    with (home / "m.toml").open("a") as stream:
        stream.write(f"[provenance]\n{rows}")
    return home


def table(folder: Path) -> Path:
    """The E62 with a drive that has a table of the most rows and bytes."""
    law = '[drives.tension]\njoint = "tension_shaft"\nlaw = "table"\nfile = "t.csv"\n\n'
    home = model("e62", (TENSION, law), folder)
    angle = np.linspace(0.0, 360.0, MOST_ROWS)
    drive = next(item for item in load("e62").drives if item.name == "tension")
    place = drive.law.evaluate(np.radians(angle))[0]
    place[-1] = place[0]
    width = MOST_TABLE // MOST_ROWS - 1
    lines = [f"{a:.12f},{b:.17f}".ljust(width) for a, b in zip(angle, place, strict=True)]
    (home / "t.csv").write_text("\n".join(["cylinder_angle_deg,coordinate_rad", *lines]))
    return home


def case_of_lists(folder: Path) -> Path:
    """What takes the most memory of JSON: lists of nothing."""
    path = folder / "case.json"
    head = '{"format": 3, "meshes": {}, "mechanism": {"name": "x", "urdf": "", "folder": ".", '
    head += '"description": {"a": ['
    path.write_text(head + "[]," * ((MOST_JSON - 300) // 3) + "[]]}}}")
    return path


def long_run(folder: Path) -> Path:
    """A run of as many arrays as are read."""
    mechanism = load("e62")
    case = Case(speed_rpm=650.0, window="cycle", cycles=20, reuse_cycles=False)
    path = save(simulate(mechanism, case), folder / "run.npz")
    document, arrays = stored_run(path)
    whole, count = document["segments"], len(arrays) - 1
    # A little more than a copy lasts: round-off must not make them overlap.
    span = 1.001 * (whole[-1]["t_end"] - whole[0]["t_start"])
    copies = archive.MOST_ARRAYS // len(arrays) - 1
    document["segments"] = [
        {
            **item,
            "source": copy * len(whole) + number,
            "t_start": item["t_start"] + copy * span,
            "t_end": item["t_end"] + copy * span,
            "panels": [
                [t + copy * span, *rest, place + copy * count] for t, *rest, place in item["panels"]
            ],
        }
        for copy in range(copies)
        for number, item in enumerate(whole)
    ]
    panels = {name: rows for name, rows in arrays.items() if name != "events"}
    for copy in range(1, copies):
        for name, rows in panels.items():
            arrays[f"panel{int(name.removeprefix('panel')) + copy * count}"] = rows
    path.write_bytes(packed(document, arrays))
    return path


def numbers(folder: Path) -> Path:
    """A run of as many numbers as are read, and of the longest text."""
    path = folder / "run.npz"
    rest = np.zeros((archive.MOST_BYTES - archive.MOST_TEXT) // 8 - 1000)
    text = np.array("[" + "[]," * (archive.MOST_TEXT // 12 - 100) + "[]]")
    np.savez(path, document=text, events=rest)
    return path


def triangles(path: Path) -> Path:
    """A mesh of as many bytes as are read, no two of its corners equal."""
    count = (MOST_MESH - 84) // 50
    rows = np.zeros(count, dtype=[("corners", "<f4", 12), ("unused", "<u2")])
    rows["corners"] = np.random.default_rng(1).random((count, 12))
    path.write_bytes(bytes(80) + struct.pack("<I", count) + rows.tobytes())
    return path


def mesh_that_touches(folder: Path) -> Path:
    """The E62 with a mesh in place of a lip, which it does not fit."""
    home = model("e62", (LIP, '<mesh filename="lip.stl"/>'), folder)
    triangles(home / "lip.stl")
    return home


def chunk(folder: Path) -> Path:
    """A chunk of as many numbers as are read."""
    pytest.importorskip("pyarrow")
    rows = 65_536
    columns: dict[str, Any] = {"scenario": np.arange(rows)}
    noise = np.random.default_rng(1)
    for place in range(chunk_file.MOST_BYTES // (8 * rows) - 4):
        columns[f"x{place}"] = noise.random(rows)
    path = folder / "0000000.parquet"
    path.write_bytes(chunk_file.encode(columns, units={}, about={}))
    return path


Made = Callable[[Path], Path]
LARGEST: dict[str, tuple[str, Made, str]] = {
    "parts": ("model", many_parts, ""),
    "chain": ("model", chain, ""),
    "words": ("model", long_words, ""),
    "table": ("model", table, ""),
    "case": ("case", case_of_lists, "not a saved case"),
    "run": ("run", long_run, ""),
    "numbers": ("run", numbers, "not a saved solution"),
    "mesh": ("mesh", lambda folder: triangles(folder / "a.stl"), ""),
    "mesh that touches": ("model", mesh_that_touches, "apart at jaw"),
    "chunk": ("chunk", chunk, ""),
    "turns": ("turns", lambda folder: folder, ""),
}


@pytest.mark.campaign
@pytest.mark.parametrize("name", LARGEST)
def test_the_largest_inputs_take_little(name: str, tmp_path: Path) -> None:
    kind, make, refusal = LARGEST[name]
    command = [sys.executable, "-c", READ, kind, str(make(tmp_path))]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    memory, said = json.loads(done.stdout)
    assert memory <= BYTES
    assert refusal in said
    assert bool(said) == bool(refusal)
