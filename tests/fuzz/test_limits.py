"""The largest inputs that are read, and one more: at most 1 GB of memory and some 10 s each.

Each is read by a process of its own, whose memory and processor time the system tells. Time on the
clock depends on what else the machine does.
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

from nipper_pin import Case, load, save, simulate
from nipper_pin.hybrid.files import archive
from nipper_pin.mechanism import find_model
from nipper_pin.mechanism.elements import MOST_ROWS
from nipper_pin.mechanism.files.meshes import MOST_MESH
from nipper_pin.study.sweep.results import chunk_file
from nipper_pin.texts import MOST_JSON, MOST_TABLE, MOST_TEXT

HERE = Path(__file__).parent
BYTES = 10**9
# Processors differ by a factor of three. What grows with the square of a file takes minutes.
SECONDS = 30.0
LINK = (
    '<link name="{0}"><inertial><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" '
    'izz="1"/></inertial></link>\n'
)
JOINT = (
    '<joint name="{0}" type="continuous"><parent link="{1}"/><child link="{2}"/>'
    '<origin xyz="{3} 0 {4}"/><axis xyz="0 -1 0"/></joint>\n'
)
FRAME = (
    '<link name="{0}"/><joint name="{0}_fixed" type="fixed"><parent link="{1}"/>'
    '<child link="{0}"/><origin xyz="{2} 0 {3}"/></joint>\n'
)
HEAD = """format = 1
title = "large"
degrees_of_freedom = {0}
gravity_m_s2 = 9.81
transition_stop = "s0"
initial_phase = 1
[cylinder]
rated_speed_rpm = 60.0
direction = "clockwise"
angle_at_touch_deg = 0.0
reference_index = 0.0
reference_angle_deg = 0.0
"""
READ = """
import json, resource, sys
from pathlib import Path
sys.path.insert(0, sys.argv[1])
import targets
from nipper_pin import NipperError, load, load_case, load_solution
from nipper_pin.study.identify.problem.measured import read_measured
from nipper_pin.study.sweep.results.chunk_file import read_file
from nipper_pin.view.scene.meshes import read_mesh
import scipy.interpolate
load("e62")
def used():
    found = resource.getrusage(resource.RUSAGE_SELF)
    return found.ru_utime + found.ru_stime
readers = {"model": load, "case": load_case, "run": load_solution, "measured": read_measured,
           "chunk": read_file, "mesh": read_mesh}
before, said = used(), ""
try:
    found = readers[sys.argv[2]](Path(sys.argv[3]))
except NipperError as error:
    said = error.message
# The largest memory of getrusage may be that of the process that started this one.
status = Path("/proc/self/status").read_text().splitlines()
memory = next(int(line.split()[1]) for line in status if line.startswith("VmHWM"))
print(json.dumps({"s": used() - before, "bytes": 1024 * memory, "said": said}))
"""


def read(kind: str, path: Path) -> dict[str, Any]:
    """Time [s], memory [byte] and refusal of a file that is read."""
    command = [sys.executable, "-c", READ, str(HERE), kind, str(path)]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    found: dict[str, Any] = json.loads(done.stdout)
    return found


def written(folder: Path, urdf: str, toml: str) -> Path:
    folder.mkdir()
    (folder / f"{folder.name}.urdf").write_text(f'<robot name="m">{urdf}</robot>')
    (folder / f"{folder.name}.toml").write_text(toml)
    return folder


def four_bars(count: int, phases: int, frames: int) -> tuple[str, str]:
    """Four-bars side by side, each with a stop, and frames that hang from the root link."""
    urdf, toml = ['<link name="frame"/>\n'], [HEAD.format(count)]
    for k in range(count):
        names = [f"{part}{k}" for part in ("crank", "rod", "rocker", "end", "pin")]
        urdf += [LINK.format(name) for name in names[:3]]
        urdf += [
            JOINT.format(f"a{k}", "frame", names[0], 10 * k, 0),
            JOINT.format(f"b{k}", names[0], names[1], 0, 1),
            JOINT.format(f"c{k}", "frame", names[2], 10 * k + 3, 0),
            FRAME.format(names[3], names[1], 4, 1),
            FRAME.format(names[4], names[2], 1, 2),
        ]
        toml += [
            f'[closures.l{k}]\nframe_a = "end{k}"\nframe_b = "pin{k}"\n',
            f'[stops.s{k}]\njoint = "a{k}"\nrestitution = 0.1\n',
        ]
    urdf += [FRAME.format(f"f{k}", "frame", k, 0) for k in range(frames)]
    for k in range(phases):
        closed = [f"s{place}" for place in range(k)]
        toml.append(f'[[phases]]\nnumber = {k + 1}\nname = "p"\nclosed = {json.dumps(closed)}\n')
    return "".join(urdf), "".join(toml)


def many_parts(folder: Path) -> Path:
    return written(folder / "m", *four_bars(166, 64, 2000 - 5 * 166 - 1))


def chain(folder: Path) -> Path:
    """Links that hang from one another."""
    urdf = '<link name="l0"/>' + "".join(
        LINK.format(f"l{k + 1}") + JOINT.format(f"h{k}", f"l{k}", f"l{k + 1}", 1, 0)
        for k in range(499)
    )
    rows = "".join(
        f'[springs.t{k}]\njoint = "h{k}"\nstiffness_N_m_per_rad = 1.0\npreload_deg = 0.0\n'
        for k in range(300)
    )
    stop = '[stops.s0]\njoint = "h0"\nrestitution = 0.0\n[[phases]]\nnumber = 1\nname = "p"\n'
    return written(folder / "m", urdf, HEAD.format(499) + rows + stop + "closed = []\n")


def long_words(folder: Path) -> Path:
    """A URDF and a TOML file of the most letters."""
    urdf, toml = four_bars(1, 1, 0)
    urdf += f"<!--{'x' * (MOST_TEXT - len(urdf) - 100)}-->"
    row = '"title.{0}" = "word"\n'
    rows = "".join(map(row.format, range((MOST_TEXT - len(toml)) // len(row) - 40_000)))
    return written(folder / "m", urdf, f"{toml}[provenance]\n{rows}")


def spring_rows(folder: Path) -> Path:
    """Springs whose tables are written out in the TOML file."""
    urdf, toml = four_bars(1, 1, 0)
    rows = ",".join(map(str, range(MOST_TEXT // 16)))
    spring = f'[springs.x]\njoint = "b0"\ncoordinate_deg = [{rows}]\ntorque_N_m = [{rows}]\n'
    return written(folder / "m", urdf, toml + spring)


def table(folder: Path, rows: int, width: int = 0) -> Path:
    """The E62 with a drive that has a table."""
    home = folder / "e62"
    home.mkdir()
    for file in find_model("e62").glob("*.*"):
        (home / file.name).write_bytes(file.read_bytes())
    angle = np.linspace(0.0, 360.0, rows)
    drive = next(item for item in load("e62").drives if item.name == "tension")
    place = drive.law.evaluate(np.radians(angle))[0]
    place[-1] = place[0]
    lines = [f"{a:.12f},{b:.17f}".ljust(width) for a, b in zip(angle, place, strict=True)]
    (home / "t.csv").write_text("\n".join(["cylinder_angle_deg,coordinate_rad", *lines]))
    text = (home / "e62.toml").read_text()
    begin, end = text.index("[drives.tension]"), text.index("# A spring pushes")
    law = '[drives.tension]\njoint = "tension_shaft"\nlaw = "table"\nfile = "t.csv"\n\n'
    (home / "e62.toml").write_text(text[:begin] + law + text[end:])
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
    with np.load(path) as stored:
        arrays = {name: stored[name] for name in stored.files}
    document = json.loads(str(arrays.pop("document")))
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
    np.savez(path, document=np.array(json.dumps(document)), **arrays)
    return path


def numbers(folder: Path) -> Path:
    """A run of as many numbers as are read, and of the longest text."""
    path = folder / "run.npz"
    rest = np.zeros((archive.MOST_BYTES - archive.MOST_TEXT) // 8 - 1000)
    text = np.array("[" + "[]," * (archive.MOST_TEXT // 12 - 100) + "[]]")
    np.savez(path, document=text, events=rest)
    return path


def measurements(folder: Path) -> Path:
    path = folder / "m.csv"
    line = "450,rebound_time_s_1,0.0042,1e-4,0.2\n"
    path.write_text("speed_rpm,quantity,value,sigma,restitution\n" + line * 10_000)
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
    home = folder / "e62"
    home.mkdir()
    for file in find_model("e62").glob("*.*"):
        (home / file.name).write_bytes(file.read_bytes())
    triangles(home / "lip.stl")
    text = (home / "e62.urdf").read_text(encoding="utf-8")
    lip = '<box size="0.012 0.2 0.0003"/>'
    assert lip in text
    (home / "e62.urdf").write_text(text.replace(lip, '<mesh filename="lip.stl"/>', 1))
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
    "rows in TOML": ("model", spring_rows, "at most 100000 rows"),
    "table": ("model", lambda folder: table(folder, MOST_ROWS), ""),
    "wide table": (
        "model",
        lambda folder: table(folder, MOST_ROWS, MOST_TABLE // MOST_ROWS - 1),
        "",
    ),
    "million rows": ("model", lambda folder: table(folder, 10**6), "larger than 16 MiB"),
    "case": ("case", case_of_lists, "not a saved case"),
    "run": ("run", long_run, ""),
    "numbers": ("run", numbers, "not a saved solution"),
    "measurements": ("measured", measurements, ""),
    "mesh": ("mesh", lambda folder: triangles(folder / "a.stl"), ""),
    "mesh that touches": ("model", mesh_that_touches, "apart at jaw"),
    "chunk": ("chunk", chunk, ""),
}


@pytest.mark.campaign
@pytest.mark.parametrize("name", LARGEST)
def test_the_largest_inputs_take_little(name: str, tmp_path: Path) -> None:
    kind, make, refusal = LARGEST[name]
    found = read(kind, make(tmp_path))
    print(name, found)
    assert found["s"] <= SECONDS
    assert found["bytes"] <= BYTES
    assert refusal in found["said"]
    assert bool(found["said"]) == bool(refusal)
