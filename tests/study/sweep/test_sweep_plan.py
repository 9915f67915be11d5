"""Plans of sweeps as sets of numbers: every scenario once."""

from __future__ import annotations

import itertools
import json
from pathlib import Path

import numpy as np
import pytest
from scipy.stats import qmc
from sweep_studies import GEOMETRY, TABLE, plan, study

from nipper_pin import InputError
from nipper_pin.cli import main
from nipper_pin.study.sweep import Plan, read_plan, run_sweep
from nipper_pin.study.sweep.job import read_job
from nipper_pin.study.transitions import REDUCED_PAYS_FROM


def all_rows(found: Plan) -> np.ndarray:
    return np.concatenate([rows for _, rows in found.rows(found.chunks())])


def test_grid_is_the_product_of_its_values(tmp_path: Path) -> None:
    """Written out with itertools; numbers that change the mechanism vary slowest."""
    text = """
    [parameters.speed_rpm]
    low = 400.0
    high = 600.0
    points = 3
    [parameters."links.top_nipper.mass_kg"]
    low = 0.5
    high = 2.0
    points = 3
    scale = "log"
    [parameters.restitution]
    values = [0.3, 0.1]
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
    # A resumed sweep asks for some parts only.
    some = found.chunks()[5::4]
    for chunk, part in found.rows(some):
        assert (part == rows[chunk.start : chunk.stop]).all()


def test_latin_hypercube_has_one_sample_in_every_layer(tmp_path: Path) -> None:
    """That is what it is; independent uniform numbers do it once in 200!/200^200."""
    text = TABLE.replace("sobol", "latin_hypercube").replace("600", "200")
    rows = all_rows(plan(tmp_path, text))
    for column, low, high in ((0, 420.0, 680.0), (1, 0.05, 0.25), (3, 9.0, 13.0)):
        layer = np.floor(200.0 * (rows[:, column] - low) / (high - low)).astype(int)
        assert sorted(layer) == list(range(200))


@pytest.mark.parametrize("method", ["sobol", "latin_hypercube"])
def test_a_seed_names_its_points(tmp_path: Path, method: str) -> None:
    """The same seed gives the same points in a plan of its own, and two seeds share none."""
    text = TABLE.replace("sobol", method).replace("600", "64")
    first = all_rows(plan(tmp_path, text))
    assert (all_rows(plan(tmp_path, text)) == first).all()
    for seed in ("0", "8", "70"):
        other = all_rows(plan(tmp_path, text.replace("seed = 7", f"seed = {seed}")))
        assert not np.isin(other, first).any()
    # Without a seed it is 1, whenever it is run.
    plain = all_rows(plan(tmp_path, text.replace("seed = 7\n", "")))
    assert (plain == all_rows(plan(tmp_path, text.replace("seed = 7", "seed = 1")))).all()


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


@pytest.mark.parametrize("chunk", [None, 1, 7, 100, 10**6])
@pytest.mark.parametrize("text", [TABLE, GEOMETRY.replace("chunk = 4\n", "")])
def test_chunks_hold_every_scenario_once(tmp_path: Path, text: str, chunk: int | None) -> None:
    head = "" if chunk is None else f"chunk = {chunk}\n"
    found = plan(tmp_path, head + text)
    chunks = found.chunks()
    edges = [chunks[0].start, *(item.stop for item in chunks)]
    assert edges[0] == 0
    assert edges[-1] == found.scenarios
    assert all(item.start < item.stop for item in chunks)
    assert [item.start for item in chunks] == edges[:-1]
    assert [item.number for item in chunks] == list(range(len(chunks)))


def test_a_study_of_a_thousand_million_scenarios_is_planned_without_making_them(
    tmp_path: Path,
) -> None:
    """The rows would take 32 GB; no chunk leaves a part so small that it changes the engine."""
    found = plan(tmp_path, TABLE.replace("600", "1_000_000_000"))
    chunks = found.chunks()
    sizes = {item.stop - item.start for item in chunks}
    assert sum(item.stop - item.start for item in chunks) == 10**9
    assert max(sizes) <= 65_536
    assert min(sizes) > REDUCED_PAYS_FROM
    _, rows = next(found.rows(chunks[1000:]))
    assert rows.shape == (chunks[1000].stop - chunks[1000].start, 4)


def test_plan_has_one_name(tmp_path: Path) -> None:
    """Equal studies have equal hashes, from any folder; every number that counts changes it."""
    (tmp_path / "other").mkdir()
    same = read_plan(study(tmp_path / "other", TABLE, "another"))
    first = plan(tmp_path, TABLE)
    assert first.hash == same.hash
    changes = [
        ("count = 600", "count = 601"),
        ("seed = 7", "seed = 8"),
        ("high = 13.0", "high = 13.5"),
        ('"log"', '"linear"'),
        ("[samples]", "[case]\ntolerance = 1e-9\n[samples]"),
        ("[samples]", '[set]\n"stops.steeve.restitution" = 0.21\n[samples]'),
        ("[samples]", 'quantities = ["duration_s"]\n[samples]'),
        ("[samples]", "chunk = 100\n[samples]"),
    ]
    hashes = {plan(tmp_path, TABLE.replace(*change, 1)).hash for change in changes}
    assert len(hashes | {first.hash}) == len(changes) + 1


def test_a_worker_rebuilds_the_job_from_its_text(tmp_path: Path) -> None:
    """Plain data: JSON, without visuals, whose files a worker may lack; versions must agree."""
    job = plan(tmp_path, GEOMETRY).job
    assert read_job(job.text()) == job
    document = json.loads(job.text())
    assert "<visual" not in document["urdf"]
    assert "<collision" in document["urdf"]
    document["versions"]["pin"] = "0.0"
    with pytest.raises(InputError, match=r"pin .* instead of 0\.0"):
        read_job(json.dumps(document).encode())


@pytest.mark.parametrize(
    ("path", "own"),
    [
        ("drives.pendulum.guide_offset_mm", 0.0),
        ("drives.pendulum.crank_axis_mm[1]", 0.0),
        ("urdf.link.top_nipper.inertial.mass.value", None),
        ("links.top_nipper.gyration_mm", None),
        ("points.rod_pin.z_mm", None),
    ],
)
def test_every_number_of_a_model_can_vary(tmp_path: Path, path: str, own: float | None) -> None:
    """All kinds of paths are found, and each makes mechanisms of its own."""
    values = [1.0 if own is None else own, 1.5]
    found = plan(tmp_path, f"[parameters.'{path}']\nvalues = {values}\n")
    assert found.mechanisms == 2
    assert found.axes[0].target.path == path


def test_workers_that_cannot_be_used(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Refused before anything is written, or timed."""
    found = plan(tmp_path, TABLE)
    with pytest.raises(InputError, match="workers = 0 cannot be used: a whole") as caught:
        run_sweep(found, tmp_path / "out", workers=0)
    assert caught.value.evidence["key"] == "workers"
    with pytest.raises(InputError, match="and --scheduler has its own") as caught:
        run_sweep(found, tmp_path / "out", workers=1, scheduler="tcp://a")
    assert caught.value.evidence == {"workers": 1, "scheduler": "tcp://a"}
    words = ["sweep", str(tmp_path / "study.toml"), "--dry-run", "--workers", "0"]
    assert main(words) == 2
    assert "workers = 0 cannot be used" in capsys.readouterr().err
    assert [item.name for item in tmp_path.iterdir()] == ["study.toml"]


STUDIES = {"sweep_spring": 100_000, "sweep_turns": 100_000, "sweep_eccentric": 2000,
           "sweep_billion": 10**9}  # fmt: skip


@pytest.mark.parametrize("name", STUDIES)
def test_studies_that_come_along_can_be_planned(name: str) -> None:
    found = read_plan(str(Path(__file__).parents[3] / "scripts" / f"{name}.toml"))
    assert found.scenarios == STUDIES[name]
