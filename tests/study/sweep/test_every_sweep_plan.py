"""Every number of a sweep's plan and of its record, by hand."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from importlib.metadata import PackageNotFoundError
from pathlib import Path

import numpy as np
import pytest
from sweep_studies import FULL, GEOMETRY, TABLE, plan

from nipper_pin import InputError, load
from nipper_pin.dynamics.system import DriveMode
from nipper_pin.mechanism import Mechanism
from nipper_pin.study.sweep.axes import Axis, Target, find_target
from nipper_pin.study.sweep.chunks import _cases
from nipper_pin.study.sweep.job import versions
from nipper_pin.study.sweep.plan import chosen
from nipper_pin.study.sweep.results.record import continued, plan_record
from nipper_pin.study.sweep.units import unit_of


def test_every_key_of_a_study(tmp_path: Path) -> None:
    found = plan(tmp_path, FULL)
    job, samples = found.job, found.samples
    assert (found.title, found.chunk, job.name) == ("test", 3, "e62")
    assert (job.speed_rpm, job.drive, job.rest_rate) == (512.5, DriveMode.INERTIAL, 2e-4)
    assert (job.tolerance, job.max_collisions) == (1e-3, 77)
    assert job.quantities == ("duration_s", "rebound_amplitude_1")
    assert samples is not None
    assert (samples.method, samples.count, samples.seed) == ("latin_hypercube", 6, 9)
    assert samples.earlier == ()
    assert job.drawn == "latin_hypercube of 6, seed 9"
    assert job.study == (tmp_path / "study.toml").read_text(encoding="utf-8")
    restitution, preload, mass = job.axes
    assert (restitution.low, restitution.high, restitution.values) == (0.1, 0.3, ())
    assert (restitution.scale, preload.scale, mass.scale) == ("linear", "log", "linear")
    assert preload.values == pytest.approx((9.0, 12.0, 16.0))
    assert (preload.low, preload.high) == (9.0, 16.0)
    assert (mass.low, mass.high, mass.values) == (1.1, 1.4, (1.4, 1.1))
    assert [axis.target.kind for axis in job.axes] == ["restitution", "preload", "model"]
    assert job.moving == (2,)
    assert job.units == {
        "duration_s": "s", "rebound_amplitude_1": "rad", "restitution": "1", "preload": "mm",
        "links.top_nipper.mass_kg": "kg",
    }  # fmt: skip
    assert (found.scenarios, found.mechanisms) == (36, 2)
    plain = plan(tmp_path, "[parameters.restitution]\nvalues = [0.1]\n")
    job = plain.job
    assert (job.speed_rpm, job.drive, job.rest_rate) == (450.0, DriveMode.HELD, None)
    assert (job.tolerance, job.max_collisions, job.drawn) == (1e-10, 256, "")
    assert (plain.samples, plain.chunk) == (None, None)
    assert job.quantities == (
        "duration_s", "duration_error_s", "first_two_share", "impulse_N_s_1",
        "rebound_amplitude_1", "rebound_time_s_1",
    )  # fmt: skip
    assert plan(tmp_path, TABLE).job.drawn == "sobol, seed 7"


def test_the_record_of_a_plan(tmp_path: Path) -> None:
    """Each key of ``plan.json``; the keys that count refuse another sweep by their name."""
    found = plan(tmp_path, FULL)
    job = found.job
    record = plan_record(found)
    assert record == {
        "format": 2, "hash": found.hash, "identity": job.identity, "title": "test", "model": "e62",
        "scenarios": 36, "mechanisms": 2, "chunk": 3, "quantities": [*job.quantities],
        "axes": [
            {"name": axis.name, "path": axis.target.path, "low": axis.low, "high": axis.high,
             "scale": axis.scale, "values": [*axis.values]}
            for axis in job.axes
        ],
        "samples": {"method": "latin_hypercube", "seed": 9, "count": 6, "earlier": []},
        "speed_rpm": 512.5, "drive": "inertial", "rest_rate": 2e-4, "tolerance": 1e-3,
        "max_collisions": 77, "versions": versions(), "urdf": job.urdf,
        "description": dict(job.document), "study": job.study,
    }  # fmt: skip
    stored = json.loads(json.dumps(record))
    for key in ("title", "study", "scenarios", "mechanisms", "hash"):
        assert continued(found, {**stored, key: "other"}, tmp_path) == found
    for key in ("model", "chunk", "axes", "quantities", "speed_rpm", "drive", "rest_rate",
                "tolerance", "max_collisions", "versions", "urdf", "description"):  # fmt: skip
        with pytest.raises(InputError, match="holds the results of another sweep") as caught:
            continued(found, {**stored, key: "other"}, tmp_path)
        assert caught.value.evidence == {"folder": str(tmp_path), "differences": [key]}
    with pytest.raises(InputError, match="they differ in: study"):
        continued(found, {**stored, "identity": "other"}, tmp_path)


def test_samples_that_are_added_to_stored_ones(tmp_path: Path) -> None:
    """More points of the same sequence; fewer, another seed, or a hypercube are refused."""
    found = plan(tmp_path, TABLE)
    assert found.samples is not None
    stored = json.loads(json.dumps(plan_record(found)))
    stored["samples"] = {"method": "sobol", "seed": 7, "count": 500, "earlier": [100, 200]}
    more = continued(found, stored, tmp_path).samples
    assert more is not None
    assert more.earlier == (100, 200, 500)
    # Added in parts, the points are those of a sweep that asks for all of them at once.
    grown = continued(found, stored, tmp_path)
    parts = [
        np.concatenate([rows for _, rows in item.rows(item.chunks())]) for item in (found, grown)
    ]
    np.testing.assert_array_equal(*(np.unique(rows, axis=0) for rows in parts))
    stored["samples"]["count"] = 600
    same = continued(found, stored, tmp_path).samples
    assert same is not None
    assert same.earlier == (100, 200)
    for changes, words in (
        ({"count": 601}, "holds 601 points, and samples.count = 600 asks for fewer"),
        ({"seed": 8, "count": 500}, "they differ in: samples"),
        ({"method": "latin_hypercube"}, "they differ in: samples"),
    ):
        other = {**stored, "samples": {**stored["samples"], **changes}}
        with pytest.raises(InputError, match=words):
            continued(found, other, tmp_path)
    with pytest.raises(InputError, match="they differ in: samples"):
        continued(found, {**stored, "samples": None}, tmp_path)
    cube = plan(tmp_path, TABLE.replace("sobol", "latin_hypercube"))
    kept = {**json.loads(json.dumps(plan_record(cube)))}
    kept["samples"] = {**kept["samples"], "count": 599}
    with pytest.raises(InputError, match="holds a Latin hypercube of 599 points"):
        continued(cube, kept, tmp_path)


@pytest.mark.parametrize(
    ("count", "number"),
    # 64 chunks, as long as they have no fewer than 8192 and no more than 65 536 scenarios.
    [(8192, 1), (8193, 2), (100_000, 13), (524_288, 64), (600_000, 64), (4_194_304, 64),
     (4_194_305, 65), (10**9, 15_259)],
)  # fmt: skip
def test_chunks_of_one_mechanism(tmp_path: Path, count: int, number: int) -> None:
    found = plan(tmp_path, TABLE.replace("600", str(count)))
    sizes = [item.stop - item.start for item in found.chunks()]
    assert len(sizes) == number
    assert max(sizes) - min(sizes) <= 1


@pytest.mark.parametrize(
    ("radii", "speeds", "of_chunk"),
    [
        # Two scenarios of 2.5 ms after 6 ms of a mechanism: 23 of them last a quarter of a second,
        # 182 two seconds; 64 chunks between these.
        (20, 2, 20), (1000, 2, 23), (3200, 2, 50), (20_000, 2, 182),
        # 100 scenarios of 20 us after 46 ms of a mechanism and its tables: 48 ms.
        (1000, 100, 16), (200, 100, 6), (9600, 100, 42), (1000, 31, 16), (300, 31, 5),
    ],
)  # fmt: skip
def test_chunks_of_whole_mechanisms(tmp_path: Path, radii: int, speeds: int, of_chunk: int) -> None:
    text = GEOMETRY.replace("chunk = 4\n", "").replace("points = 5", f"points = {radii}")
    text = text.replace("values = [2.0, 2.2, 2.4]", "values = [2.0]")
    text = text.replace("values = [450.0, 650.0]", f"low = 450.0\nhigh = 650.0\npoints = {speeds}")
    sizes = [item.stop - item.start for item in plan(tmp_path, text).chunks()]
    assert set(sizes[:-1] or sizes) == {min(of_chunk, radii) * speeds}
    assert sum(sizes) == radii * speeds


@pytest.mark.parametrize(
    ("chunk", "sizes"), [(5, [5, 5]), (9, [5, 5]), (4, [3, 3, 4]), (10, [10]), (25, [20])]
)
def test_chunks_of_a_size(tmp_path: Path, chunk: int, sizes: list[int]) -> None:
    """Ten speeds of a mechanism: divided evenly, none above the size; or whole mechanisms."""
    text = f"chunk = {chunk}\n" + GEOMETRY.replace("chunk = 4\n", "").replace(
        "values = [450.0, 650.0]", "low = 450.0\nhigh = 650.0\npoints = 10"
    )
    found = [item.stop - item.start for item in plan(tmp_path, text).chunks()]
    assert found[: len(sizes)] == sizes
    assert max(found) <= chunk
    assert sum(found) == 150


def test_chunks_that_are_chosen(tmp_path: Path) -> None:
    found = plan(tmp_path, GEOMETRY).chunks()
    assert chosen(found, None) == found
    for bounds, wanted in (((0, 0), found[:1]), ((2, 3), found[2:4]), ((7, 99), found[7:])):
        assert chosen(found, bounds) == wanted
    for wrong in ((-1, 2), (0.0, 2), (True, 2), ("0", 1), (1,), "01", 3):
        with pytest.raises(InputError, match=r"chunks = .* cannot be used"):
            chosen(found, wrong)  # type: ignore[arg-type]
    for bounds in ((8, 9), (3, 2)):
        with pytest.raises(InputError, match="there are 8 chunks, 0 to 7") as caught:
            chosen(found, bounds)
        assert caught.value.evidence == {"chunks": [*bounds]}


def test_targets_and_units(e62: Mechanism) -> None:
    """Angles of a preload in degrees, lengths in mm; what a path's last part ends with."""
    assert find_target("speed_rpm", e62) == Target(kind="speed", path="speed_rpm")
    path = "springs.steeve.preload_length_mm"
    assert find_target("preload", e62) == Target(kind="preload", path=path, spring=0, scale=1e-3)
    spring = replace(e62.springs[0], index=e62.stop("jaw").index, name="jaw")
    both = replace(e62, springs=(e62.springs[0], spring))
    assert find_target("springs.jaw.preload_deg", both) == Target(
        kind="preload", path="springs.jaw.preload_deg", spring=1, scale=math.pi / 180.0
    )
    assert find_target("springs.jaw.stiffness_N_m_per_rad", both) == Target(
        kind="stiffness", path="springs.jaw.stiffness_N_m_per_rad", spring=1
    )
    assert find_target("stops.steeve.restitution", e62).kind == "model"
    units = {
        "mass_kg": "kg", "stiffness_N_per_m": "N/m", "damping_N_m_s_per_rad": "N m s/rad",
        "crank_axis_mm[1]": "mm", "speed_rpm": "r/min", "ratio": "1", "lead_mm_per_turn": "mm/turn",
        "inertia_kg_m2": "kg m2", "angle_deg": "deg", "energy_J": "J", "m": "1",
    }  # fmt: skip
    assert {name: unit_of(name) for name in units} == units
    axis = Axis(name="x", target=Target(kind="speed", path="x"), low=4.0, high=9.0, scale="log",
                values=())  # fmt: skip
    assert axis.sampled(np.array([0.0, 0.5, 1.0])) == pytest.approx([4.0, 6.0, 9.0])
    assert replace(axis, scale="linear").sampled(np.array([0.0, 0.2, 1.0])).tolist() == [4, 5, 9]


def test_parameters_in_their_columns(tmp_path: Path) -> None:
    """Rows of a study in the units of its file; cases of a machine in SI units."""
    text = (
        "[parameters.preload]\nvalues = [9.0, 10.0]\n[parameters.stiffness]\nvalues = [7e3, 8e3]\n"
        "[parameters.speed_rpm]\nvalues = [400.0, 500.0]\n[parameters.restitution]\n"
        "values = [0.1, 0.2]\n"
    )
    found, machine = plan(tmp_path, text), load("e62")
    rows = np.array([[9.0, 7e3, 400.0, 0.1], [10.0, 8e3, 500.0, 0.2]])
    cases = _cases(found.job, machine, rows)
    assert cases.preload == pytest.approx(np.array([[9e-3], [10e-3]]))
    assert cases.stiffness.tolist() == [[7e3], [8e3]]
    assert cases.speed_rpm.tolist() == [400.0, 500.0]
    assert cases.restitution.tolist() == [0.1, 0.2]
    fixed = plan(tmp_path, "[case]\nspeed_rpm = 512.5\n[parameters.restitution]\nvalues = [0.1]\n")
    cases = _cases(fixed.job, machine, rows[:, 3:])
    assert cases.speed_rpm.tolist() == [512.5, 512.5]
    assert cases.preload.tolist() == [[machine.springs[0].preload]] * 2
    assert cases.stiffness.tolist() == [[machine.springs[0].stiffness]] * 2


def test_a_worker_without_the_compiler_is_another_one(monkeypatch: pytest.MonkeyPatch) -> None:
    """What is not installed has a version of its own, so that results of two kinds never mix."""
    here = versions()

    def lacking(package: str) -> str:
        if package == "numba":
            raise PackageNotFoundError(package)
        return here[package]

    monkeypatch.setattr("nipper_pin.study.sweep.job.version", lacking)
    assert versions() == here | {"numba": "none"}
