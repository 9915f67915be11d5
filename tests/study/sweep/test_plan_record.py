"""Every number of a sweep's plan and of its record, by hand."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from importlib.metadata import PackageNotFoundError
from pathlib import Path

import numpy as np
import pytest
from snapshots import Words
from sweep_studies import FULL, GEOMETRY, TABLE, plan

from nipper_pin import InputError
from nipper_pin.mechanism import Mechanism
from nipper_pin.study.sweep.axes import Axis, Target, find_target
from nipper_pin.study.sweep.job import versions
from nipper_pin.study.sweep.plan import chosen
from nipper_pin.study.sweep.results.record import continued, plan_record
from nipper_pin.study.sweep.units import unit_of


def test_every_key_of_a_study(tmp_path: Path, words: Words) -> None:
    """In ``plan.json``, and what stands there where a study says nothing."""
    said = []
    texts = {FULL: 1e-3, TABLE: 1e-10, "[parameters.restitution]\nvalues = [0.1]\n": 1e-10}
    for text, tolerance in texts.items():
        found = plan(tmp_path, text)
        assert found.job.tolerance == tolerance
        record, job = plan_record(found), found.job
        assert job.study == record.pop("study")
        assert job.study == (tmp_path / "study.toml").read_text(encoding="utf-8")
        assert (record.pop("hash"), record.pop("identity")) == (found.hash, job.identity)
        assert record.pop("versions") == versions()
        assert (record.pop("urdf"), record.pop("description")) == (job.urdf, dict(job.document))
        record |= {"units": job.units, "drawn": job.drawn, "moving": [*job.moving],
                   "kinds": [axis.target.kind for axis in job.axes]}  # fmt: skip
        said.append(json.dumps(record, indent=1))
    words("\n".join(said) + "\n")


def test_a_folder_of_another_sweep(tmp_path: Path) -> None:
    """The keys that count refuse it by their name."""
    found = plan(tmp_path, FULL)
    stored = json.loads(json.dumps(plan_record(found)))
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


def test_a_worker_without_the_compiler_is_another_one(monkeypatch: pytest.MonkeyPatch) -> None:
    """What is not installed has a version of its own, so that results of two kinds never mix."""
    here = versions()

    def lacking(package: str) -> str:
        if package == "numba":
            raise PackageNotFoundError(package)
        return here[package]

    monkeypatch.setattr("nipper_pin.study.sweep.job.version", lacking)
    assert versions() == here | {"numba": "none"}
