"""Plans of sweeps as sets of numbers: every scenario once; and what stands in their records."""

from __future__ import annotations

import itertools
import json
import math
from dataclasses import replace
from importlib.metadata import PackageNotFoundError
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.stats import qmc
from snapshots import Words
from sweep_studies import CYCLE, FULL, GEOMETRY, TABLE, chunk_files, plan, stored, study, taken_up

from nipper_pin import InputError, Mechanism
from nipper_pin.study.sweep import Plan, read_plan, sweep
from nipper_pin.study.sweep.axes import find_target
from nipper_pin.study.sweep.job import read_job


def all_rows(found: Plan) -> np.ndarray:
    return np.concatenate([rows for _, rows in found.rows(found.chunks())])


# --- numbers -------------------------------------------------------------------------------------


def test_grid_is_the_product_of_its_values(tmp_path: Path) -> None:
    """Written out with itertools; numbers that change the mechanism vary slowest."""
    text = """
    [parameters]
    speed_rpm = { low = 400.0, high = 600.0, points = 3 }
    "links.top_nipper.mass_kg" = { low = 0.5, high = 2.0, points = 3, scale = "log" }
    restitution = { values = [0.3, 0.1] }
    """
    found = plan(tmp_path, text)
    speeds, masses, restitutions = (400.0, 500.0, 600.0), (0.5, 1.0, 2.0), (0.3, 0.1)
    wanted = [
        (speed, mass, e) for mass, speed, e in itertools.product(masses, speeds, restitutions)
    ]
    np.testing.assert_allclose(all_rows(found), wanted, rtol=1e-15)
    assert (found.scenarios, found.mechanisms) == (18, 3)


def test_samples_are_those_of_scipy(tmp_path: Path) -> None:
    """A Sobol sequence drawn in parts is the one drawn whole, scaled to the bounds.

    The parts are forced to be odd ones. A part that was skipped or drawn twice would shift all
    that follow, and no two points of a sequence are equal.
    """
    found = plan(tmp_path, "chunk = 37\n" + TABLE)
    assert len(found.chunks()) == 17
    unit = qmc.Sobol(4, rng=np.random.default_rng(7)).random(1024)[:600]
    rows = all_rows(found)
    np.testing.assert_allclose(rows[:, 0], 420.0 + 260.0 * unit[:, 0], rtol=1e-14)
    np.testing.assert_allclose(np.log(rows[:, 2] / 7e3) / np.log(11 / 7), unit[:, 2], atol=1e-14)
    for seed in ("0", "8"):
        other = all_rows(plan(tmp_path, TABLE.replace("seed = 7", f"seed = {seed}")))
        assert not np.isin(other, rows).any()
    # A resumed sweep asks for some parts only.
    for chunk, part in found.rows(found.chunks()[5::4]):
        assert (part == rows[chunk.start : chunk.stop]).all()


def test_latin_hypercube_has_one_sample_in_every_layer(tmp_path: Path) -> None:
    """That is what it is; independent uniform numbers do it once in 200!/200^200."""
    text = TABLE.replace("sobol", "latin_hypercube").replace("600", "200")
    rows = all_rows(plan(tmp_path, text))
    for column, low, high in ((0, 420.0, 680.0), (1, 0.05, 0.25), (3, 9.0, 13.0)):
        layer = np.floor(200.0 * (rows[:, column] - low) / (high - low)).astype(int)
        assert sorted(layer) == list(range(200))


def test_samples_cross_grids(tmp_path: Path) -> None:
    """Every sample meets every grid value once, whichever of the two changes the mechanism."""
    samples = '[samples]\nmethod = "sobol"\ncount = 5\n'
    moving = '[parameters."links.top_nipper.mass_kg"]\n'
    plain = "[parameters.speed_rpm]\n"
    bounds, mass = "low = {}\nhigh = {}\n", (1.0, 1.4)
    for drawn, grid, mechanisms in (
        (moving + bounds.format(*mass), plain + "values = [450.0, 550.0, 650.0]\n", 5),
        (plain + bounds.format(400, 700), moving + "values = [1.0, 1.2, 1.4]\n", 3),
    ):
        found = plan(tmp_path, f"chunk = 2\n{samples}{drawn}{grid}")
        rows = all_rows(found)
        assert (found.scenarios, found.mechanisms) == (15, mechanisms)
        assert len({tuple(row) for row in rows}) == 15
        assert [len(set(column)) for column in rows.T] == [5, 3]
        # One chunk that starts the samples again holds the same rows.
        at_once = plan(tmp_path, f"chunk = 15\n{samples}{drawn}{grid}")
        assert len(at_once.chunks()) == 1
        assert (all_rows(at_once) == rows).all()
        key = 0 if drawn.startswith(moving) else 1
        assert np.count_nonzero(np.diff(rows[:, key])) == mechanisms - 1


# --- chunks --------------------------------------------------------------------------------------


ONE_RATIO = GEOMETRY.replace("chunk = 4\n", "").replace("2.0, 2.2, 2.4", "2.0")


def many(radii: int, speeds: int) -> str:
    """Speeds of machines of their own."""
    text = ONE_RATIO.replace("points = 5", f"points = {radii}")
    return text.replace("values = [450.0, 650.0]", f"low = 450.0, high = 650.0, points = {speeds}")


@pytest.mark.parametrize(
    ("text", "number", "largest"),
    [
        # 64 chunks, as long as they have no fewer than 8192 and no more than 65 536 scenarios: none
        # so small that it changes the engine, and none of whose rows take gigabytes.
        *((TABLE.replace("600", str(count)), number, -(-count // number)) for count, number in (
            (600, 1), (8192, 1), (8193, 2), (524_288, 64), (4_194_304, 64), (4_194_305, 65),
            (10**9, 15_259))),
        # Two scenarios of 2.5 ms after 6 ms of a mechanism: 23 of them last a quarter of a second,
        # 182 two seconds; 64 chunks between these.
        (many(20, 2), 1, 40), (many(1000, 2), 44, 46), (many(3200, 2), 64, 100),
        (many(12_000, 2), 66, 364),
        # 100 scenarios of 20 us after 46 ms of a mechanism and its tables: 48 ms.
        (many(1000, 100), 63, 1600), (many(200, 100), 34, 600), (many(300, 31), 60, 155),
        # As they are asked for: divided evenly, none above the size; or whole mechanisms.
        *((f"chunk = {chunk}\n{many(5, 10)}", number, largest) for chunk, number, largest in (
            (9, 10, 5), (4, 15, 4), (25, 3, 20), (10**6, 1, 50))),
        (f"chunk = 7\n{TABLE}", 86, 7), (f"chunk = 1_000_000\n{TABLE}", 1, 600),
        # Smaller of turns; of the direct engine, 0.126 s for two, two machines at most.
        (CYCLE + TABLE.replace("600", "100_000"), 64, 1563),
        (CYCLE + GEOMETRY.replace("chunk = 4\n", ""), 8, 4),
    ],
)  # fmt: skip
def test_chunks(tmp_path: Path, text: str, number: int, largest: int) -> None:
    """They hold every scenario once; of samples they are alike, and else but for the last one."""
    found = plan(tmp_path, text)
    chunks = found.chunks()
    assert [item.number for item in chunks] == [*range(number)]
    assert [item.start for item in chunks] == [0, *(item.stop for item in chunks[:-1])]
    assert chunks[-1].stop == found.scenarios
    sizes = [item.stop - item.start for item in chunks]
    assert max(sizes) == largest
    assert largest - min(sizes if "[samples]" in text else sizes[:-1] or sizes) <= 1
    (second, *_) = chunks[1:] or chunks
    _, rows = next(found.rows([second]))
    assert len(rows) == second.stop - second.start


def test_chunks_that_are_chosen(tmp_path: Path) -> None:
    """A folder that holds these and no others has nothing left to compute."""
    speeds = "[parameters.speed_rpm]\nlow = 450.0\nhigh = 485.0\npoints = 8\n"
    found = plan(tmp_path, f"chunk = 1\n{speeds}")
    out = stored(tmp_path / "out", found)
    whole = [*chunk_files(out).items()]
    for bounds, few in ((None, whole), ((0, 0), whole[:1]), ((2, 3), whole[2:4]),
                        ((7, 99), whole[7:])):  # fmt: skip
        for name, content in whole:
            (out / "chunks" / name).unlink(missing_ok=True)
            if (name, content) in few:
                (out / "chunks" / name).write_bytes(content)
        report = sweep(found, out, workers=1, chunks=bounds)
        assert (report.chunks, report.computed) == (len(few), 0)
    for wrong in ((-1, 2), (0.0, 2), (True, 2), ("0", 1), (1,), "01", 3):
        with pytest.raises(InputError, match=r"chunks = .* cannot be used"):
            sweep(found, out, chunks=wrong)  # type: ignore[arg-type]
    for bounds in ((8, 9), (3, 2)):
        with pytest.raises(InputError, match="there are 8 chunks, 0 to 7") as caught:
            sweep(found, out, chunks=bounds)
        assert caught.value.evidence == {"chunks": [*bounds]}


# --- records -------------------------------------------------------------------------------------


def record_of(found: Plan, out: Path) -> dict[str, Any]:
    """The record of a plan in a folder without rows."""
    taken_up(out, found)
    record: dict[str, Any] = json.loads((out / "plan.json").read_text(encoding="utf-8"))
    return record


def held(found: Plan, record: dict[str, Any], out: Path) -> Plan:
    """A plan as it goes on in a folder that holds this record."""
    (out / "plan.json").write_text(json.dumps(record), encoding="utf-8")
    return taken_up(out, found)


def test_every_key_of_a_study(tmp_path: Path, words: Words) -> None:
    """In ``plan.json``, and what stands there where a study says nothing."""
    said = []
    one = "[parameters.restitution]\nvalues = [0.1]\n"
    turns = f'[case]\nwindow = "cycle"\n{one}'
    texts = {FULL: 1e-3, TABLE: 1e-10, one: 1e-10, turns: 1e-10}
    for text, tolerance in texts.items():
        found = plan(tmp_path, text)
        assert found.job.tolerance == tolerance
        record, job = record_of(found, tmp_path / f"{len(said)}"), found.job
        assert job.study == record.pop("study")
        assert job.study == (tmp_path / "study.toml").read_text(encoding="utf-8")
        assert (record.pop("hash"), record.pop("identity")) == (found.hash, job.identity)
        assert record.pop("versions") == dict(job.versions)
        assert record.pop("urdf") == job.urdf
        assert record.pop("description") == json.loads(json.dumps(job.document))
        record |= {"units": job.units, "drawn": job.drawn, "moving": [*job.moving],
                   "kinds": [axis.target.kind for axis in job.axes]}  # fmt: skip
        said.append(json.dumps(record, indent=1))
    words("\n".join(said) + "\n")


def test_plan_has_one_name(tmp_path: Path) -> None:
    """Equal studies have equal hashes, from any folder; every number that counts changes it."""
    (tmp_path / "other").mkdir()
    same = read_plan(study(tmp_path / "other", TABLE, "another"))
    first = plan(tmp_path, TABLE)
    assert first.hash == same.hash
    changes = [
        ("count = 600", "count = 601"), ("seed = 7", "seed = 8"), ("high = 13.0", "high = 13.5"),
        ('"log"', '"linear"'), ("[samples]", "[case]\ntolerance = 1e-9\n[samples]"),
        ("[samples]", '[set]\n"stops.steeve.restitution" = 0.21\n[samples]'),
        ("[samples]", 'quantities = ["duration_s"]\n[samples]'),
        ("[samples]", "chunk = 100\n[samples]"),
    ]  # fmt: skip
    hashes = {plan(tmp_path, TABLE.replace(*change, 1)).hash for change in changes}
    assert len(hashes | {first.hash}) == len(changes) + 1


def test_a_folder_of_another_sweep(tmp_path: Path) -> None:
    """The keys that count refuse it by their name."""
    out = tmp_path / "turns"
    turns = plan(tmp_path, f"{CYCLE}[parameters.restitution]\nvalues = [0.1]\n")
    whole = record_of(turns, out)
    for key in ("turns", "least_force_N"):
        with pytest.raises(InputError, match=f"they differ in: {key}\\)"):
            held(turns, {**whole, key: 7}, out)
    found, out = plan(tmp_path, FULL), tmp_path / "out"
    whole = record_of(found, out)
    for key, other in (("title", "other"), ("study", "other"), ("scenarios", 7), ("mechanisms", 7),
                       ("hash", "other")):  # fmt: skip
        assert held(found, {**whole, key: other}, out) == found
    others = {"model": "other", "axes": [], "quantities": ["other"], "description": {"other": 1}}
    for key in ("model", "chunk", "axes", "quantities", "speed_rpm", "drive", "rest_rate",
                "tolerance", "max_collisions", "versions", "urdf", "description"):  # fmt: skip
        with pytest.raises(InputError, match="holds the results of another sweep") as caught:
            held(found, {**whole, key: others.get(key, "other")}, out)
        assert caught.value.evidence == {"folder": str(out), "differences": [key]}
    with pytest.raises(InputError, match="they differ in: study"):
        held(found, {**whole, "identity": "other"}, out)


def test_samples_that_are_added_to_stored_ones(tmp_path: Path) -> None:
    """More points of the same sequence; fewer, another seed, or a hypercube are refused."""
    found, out = plan(tmp_path, TABLE), tmp_path / "out"
    whole = record_of(found, out)
    sobol = {"method": "sobol", "seed": 7, "count": 500, "earlier": [100, 200]}
    more = held(found, {**whole, "samples": sobol}, out)
    same = held(found, {**whole, "samples": {**sobol, "count": 600}}, out)
    assert more.samples is not None
    assert same.samples is not None
    assert (more.samples.earlier, same.samples.earlier) == ((100, 200, 500), (100, 200))
    # Added in parts, the points are those of a sweep that asks for all of them at once.
    np.testing.assert_array_equal(*(np.unique(all_rows(item), axis=0) for item in (found, more)))
    cube = plan(tmp_path, TABLE.replace("sobol", "latin_hypercube"))
    for asked, samples, words in (
        (found, {**sobol, "count": 601}, "holds 601 points, and samples.count = 600 asks for few"),
        (found, {**sobol, "seed": 8}, "they differ in: samples"),
        (found, {**sobol, "method": "latin_hypercube"}, "they differ in: samples"),
        (found, None, "they differ in: samples"),
        (cube, {**sobol, "method": "latin_hypercube", "count": 599, "earlier": []},
         "holds a Latin hypercube of 599 points"),
    ):  # fmt: skip
        (out / "plan.json").unlink()
        record = record_of(asked, out)
        with pytest.raises(InputError, match=words):
            held(asked, {**record, "samples": samples}, out)


def test_a_worker_rebuilds_the_job_from_its_text(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Plain data: JSON, without visuals, whose files a worker may lack; versions must agree."""
    job = plan(tmp_path, GEOMETRY).job
    turns = plan(tmp_path, f'{GEOMETRY}[case]\nwindow = "cycle"\nturns = 3\n').job
    assert read_job(turns.text()) == turns != read_job(job.text()) == job
    document = json.loads(job.text())
    assert "<visual" not in document["urdf"]
    assert "<collision" in document["urdf"]
    document["versions"]["pin"] = "0.0"
    with pytest.raises(InputError, match=r"pin .* instead of 0\.0"):
        read_job(json.dumps(document).encode())
    # What is not installed has a version of its own, so that results of two kinds never mix.
    here = dict(job.versions)

    def lacking(package: str) -> str:
        if package == "numba":
            raise PackageNotFoundError(package)
        return here[package]

    monkeypatch.setattr("nipper_pin.study.sweep.job.version", lacking)
    assert plan(tmp_path, GEOMETRY).job.versions == here | {"numba": "none"}


def test_what_a_parameter_changes(e62: Mechanism) -> None:
    """Of the E62 with a second spring, at its hinge; preloads are scaled to metres and radians.

    Restitutions that turns have are columns of them; of a transition only one stop's is.
    """
    hinge = replace(e62.springs[0], name="jaw", index=e62.stop("jaw").index)
    both, steeve = replace(e62, springs=(*e62.springs, hinge)), "stops.steeve.restitution"
    for name, turns, kind, path, place, scale in (
        ("speed_rpm", False, "speed", "speed_rpm", 0, 1.0),
        ("preload", False, "preload", "springs.steeve.preload_length_mm", 0, 1e-3),
        ("springs.jaw.preload_deg", False, "preload", "", 1, math.pi / 180.0),
        ("springs.jaw.stiffness_N_m_per_rad", False, "stiffness", "", 1, 1.0),
        ("restitution", False, "restitution", "stops.jaw.restitution", 0, 1.0),
        (steeve, False, "model", "", 0, 1.0), (steeve, True, "restitution", "", 0, 1.0),
        *((path, False, "model", "", 0, 1.0) for path in (
            "drives.pendulum.guide_offset_mm", "drives.pendulum.crank_axis_mm[1]",
            "urdf.link.top_nipper.inertial.mass.value", "links.top_nipper.gyration_mm",
            "points.rod_pin.z_mm")),
    ):  # fmt: skip
        target = find_target(name, both, turns=turns)
        said = (target.kind, target.path, target.spring, target.scale)
        assert said == (kind, path or name, place, scale)


@pytest.mark.parametrize(
    ("name", "scenarios"),
    [("sweep_spring", 100_000), ("sweep_turns", 100_000), ("sweep_eccentric", 2000),
     ("sweep_billion", 10**9)],
)  # fmt: skip
def test_studies_that_come_along_can_be_planned(name: str, scenarios: int) -> None:
    found = read_plan(str(Path(__file__).parents[3] / "scripts" / f"{name}.toml"))
    assert found.scenarios == scenarios
