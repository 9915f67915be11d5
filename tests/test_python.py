"""The library as scripts and notebooks use it: one door, short texts, pickles, data frames."""

from __future__ import annotations

import csv
import math
import pickle
import subprocess
import sys
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
import small_machines
from page_words import film_of
from PIL import Image
from snapshots import Words, blocks

import nipper_pin as nip
from nipper_pin import frames
from nipper_pin.study.sweep import SweepReport
from nipper_pin.view import local as server
from nipper_pin.view import scene
from nipper_pin.view.run import tables
from nipper_pin.view.scene.page import scene_page

SWEEP = 'format = 1\nchunk = 2\nquantities = ["duration_s"]\n[case]\nspeed_rpm = 650.0\n'
SWEEP += "[parameters.restitution]\nvalues = [0.1, 0.2, 0.3]\n"


@pytest.fixture
def solution(e62: nip.Mechanism) -> nip.Solution:
    return nip.simulate(e62, nip.Case(speed_rpm=650.0))


def test_texts_of_a_line_and_of_a_notebook(words: Words) -> None:
    """Of machines, runs, tables and comparisons; long ones are cut, and no text becomes a tag."""
    text, names = "", {"nip": nip, **vars(small_machines)}
    for item in blocks(__file__, "test_texts_of_a_line_and_of_a_notebook"):
        shown = eval(item.name, names)
        page = ElementTree.fromstring(f"<page>{shown._repr_html_()}</page>")
        assert "script" not in {part.tag for part in page.iter()}
        assert page.find("p/b") is not None
        heads, first = page.findall("table/thead/tr/th"), page.findall("table/tbody/tr[1]/td")
        assert len(heads) == len(first)
        rows = [
            " | ".join("".join(cell.itertext()) for cell in row) or (row.text or "")
            for row in page.iter()
            if row.tag in ("p", "tr")
        ]
        text += f"{item.name}\n" + "".join(f"    {line}\n" for line in (repr(shown), *rows))
    words(text)


def test_a_used_solution_pickles_and_is_the_same(solution: nip.Solution) -> None:
    """Everything that is kept was asked for before; what comes back computes the same bits."""

    def numbers(run: nip.Solution) -> tuple[object, ...]:
        times = np.linspace(*run.trajectory.span, 7)
        return (
            nip.record(run),
            run.energy,
            run.errors,
            run.phases,
            run.trajectory.reactions(times).contacts["jaw"].tolist(),
            [run.trajectory.impulses(event).contacts for event in run.events],
        )

    before = numbers(solution)
    again = pickle.loads(pickle.dumps(solution))
    assert "system" not in vars(again)
    assert numbers(again) == before


def test_collisions_as_a_frame(solution: nip.Solution) -> None:
    """Of pyarrow, which is installed with the tests: names, units and numbers of the document."""
    pytest.importorskip("pyarrow")
    frame = solution.to_frame("pyarrow")
    hits = nip.record(solution)["collisions"]
    assert frame.column_names == list(hits[0])
    assert frame.to_pylist() == [
        {key: value if value is not None else pytest.approx(np.nan, nan_ok=True)
         for key, value in hit.items()}
        for hit in hits
    ]  # fmt: skip
    assert str(frame.schema.field("time_s").type) == "double"


IN_MM = (
    ("_rad_s", "_deg_s", 180.0 / np.pi), ("_rad", "_deg", 180.0 / np.pi), ("_N_m_s", "_N_m_s", 1.0),
    ("_N_m", "_N_m", 1.0), ("_m_s", "_mm_s", 1000.0), ("_m", "_mm", 1000.0),
)  # fmt: skip
GAPS = {"approach_rate": "/s", "separation_rate": "/s", "rebound_amplitude": ""}


@pytest.fixture(scope="module")
def turn() -> nip.Solution:
    return nip.simulate(nip.load("e62"), speed_rpm=650.0, window="cycle")


@pytest.mark.parametrize("table", ["collisions", "phases", "links", "motion"])
def test_tables_of_a_run_in_mm_and_degrees(table: str, turn: nip.Solution) -> None:
    """Frames and CSV files, of hinges and slides: SI numbers by factors that their names tell."""
    run = turn
    plain, other = (run.to_frame(table, "pandas", units=units) for units in ("SI", "mm"))
    names = {}
    for name in plain:
        if name in GAPS:
            units = [f"{unit}{GAPS[name]}" for unit in ("mm", "deg")]
            names[f"{name}_{'_or_'.join(units)}".replace("/", "_")] = name, 0.0
        else:
            end, new, factor = next((e for e in IN_MM if name.endswith(e[0])), ("", "", 1.0))
            names[name.removesuffix(end) + new] = name, factor
    assert list(other) == list(names)
    for name, (own, factor) in names.items():
        if plain[own].dtype.kind != "f":
            assert list(other[name]) == list(plain[own])
            continue
        factors = np.where(plain["stop"] == "jaw", 180.0 / np.pi, 1000.0) if own in GAPS else factor
        np.testing.assert_allclose(other[name], factors * plain[own], rtol=1e-15)
    file = {"links": "link_velocities"}.get(table, table)
    text = dict(tables(run, "mm"))[f"{file}.csv"]
    assert next(csv.reader(text.splitlines())) == list(names)


def test_the_case_of_a_run_by_its_fields() -> None:
    """The rated speed if none is given."""
    mechanism = nip.load("e62")
    rated = nip.simulate(mechanism)
    assert rated.case == nip.Case(speed_rpm=mechanism.cylinder.rated_speed_rpm)
    faster = nip.simulate(mechanism, speed_rpm=650.0, window="cycle", cycles=2)
    assert faster.case == nip.Case(speed_rpm=650.0, window="cycle", cycles=2)


def test_coordinates_by_the_names_of_joints(solution: nip.Solution) -> None:
    motion = solution.trajectory.evaluate([0.001, 0.002])
    for place, joint in enumerate(solution.mechanism.joints):
        np.testing.assert_array_equal(motion.joints[joint.name], motion.q[:, place])
        np.testing.assert_array_equal(motion.rates[joint.name], motion.v[:, place])


def test_the_library_that_is_there_makes_the_frame(
    solution: nip.Solution, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The first of those that are installed, or the one that is asked for; or what to install."""
    times = [item["time_s"] for item in nip.record(solution)["collisions"]]
    for installed, asked, library in (
        ({"pandas", "polars", "pyarrow"}, None, "pandas"), ({"polars", "pyarrow"}, None, "polars"),
        ({"pandas", "polars"}, "polars", "polars"),
    ):  # fmt: skip
        pytest.importorskip(library)
        monkeypatch.setattr(frames, "find_spec", lambda name: name in installed or None)  # noqa: B023
        frame = solution.to_frame(asked)
        assert type(frame).__module__.startswith(library)
        assert list(frame["time_s"]) == times
    monkeypatch.setattr(frames, "find_spec", lambda _: None)
    for asked, said in ((None, "pip install pandas"),
                        ("polars", "polars is not installed: pip install polars")):  # fmt: skip
        with pytest.raises(nip.InputError, match=said):
            solution.to_frame(asked)


def test_sweep_computes_and_its_rows_are_read(tmp_path: Path) -> None:
    pytest.importorskip("pyarrow")
    study = tmp_path / "study.toml"
    study.write_text(SWEEP, encoding="utf-8")
    seen: list[tuple[int, int, int]] = []
    report = nip.sweep(
        study, tmp_path / "out", workers=1, progress=lambda *counts: seen.append(counts)
    )
    assert isinstance(report, SweepReport)
    assert (report.scenarios, report.workers, seen[-1]) == (3, 1, (3, 0, 3))
    stored = nip.read_sweep(report.folder)
    assert repr(stored).endswith(": 3 scenarios over restitution>")
    rows = stored.to_frame("pyarrow")
    table = nip.transition_table(nip.load(), speed_rpm=650.0, restitution=[0.1, 0.2, 0.3])
    # Few cases take the direct engine here, a chunk the reduced one: each to 1e-10.
    assert rows["duration_s"].to_pylist() == pytest.approx(table.duration.tolist(), rel=2e-10)


@pytest.fixture(scope="module")
def table() -> nip.TransitionTable:
    """Four cases, the last of which comes to no rest."""
    return nip.transition_table(
        nip.load(), speed_rpm=[450.0, 550.0, 650.0, 650.0], restitution=[0.1, 0.2, 0.2, 0.9],
        stiffness_N_per_m=11e3, engine="reduced",
    )  # fmt: skip


def test_a_table_of_transitions_as_a_frame(table: nip.TransitionTable) -> None:
    """Units of the columns are those of their names: each row is simulated again by its own."""
    pytest.importorskip("pyarrow")
    frame = table.to_frame("pyarrow", collisions=3)
    rows = frame.to_pylist()
    assert len(rows) == 4
    assert not {"approach_rate_4", "impulse_N_m_s_1"} & set(rows[0])
    assert np.isnan(rows[3]["duration_s"])
    spring = "springs.steeve."
    for row in rows[:3]:
        values = {key: row[key] for key in row if key.startswith(spring)}
        assert set(values) == {f"{spring}stiffness_N_per_m", f"{spring}preload_length_mm"}
        machine = nip.load("e62", {**values, "restitution": row["restitution"]})
        run = nip.record(nip.simulate(machine, nip.Case(speed_rpm=row["speed_rpm"])))
        # The table is solved to 1e-10; the last of three bounces is seen through the others.
        close = {"rel": 1e-8}
        assert row["duration_s"] == pytest.approx(run["transition"]["duration_s"], **close)
        for place, hit in enumerate(run["collisions"][:3], start=1):
            for name in ("time_s", "approach_rate", "impulse_N_s", "rebound_amplitude",
                         "rebound_time_s", "energy_lost_J"):  # fmt: skip
                assert row[f"{name}_{place}"] == pytest.approx(hit[name], **close)


def test_view_writes_what_the_name_says(solution: nip.Solution, tmp_path: Path) -> None:
    look = {"slow": 100.0, "exaggerate": 7.0}
    page = nip.view(solution, tmp_path / "a.html", **look)
    film = nip.view(solution, str(tmp_path / "a.gif"), slow=100.0)
    assert (page, film) == (tmp_path / "a.html", tmp_path / "a.gif")
    with_look = scene.film(solution, scene.Look(**look))
    assert film_of(page.read_text(encoding="utf-8")) == film_of(scene_page(with_look))
    with Image.open(film) as pictures:
        length = scene.film(solution, scene.Look(slow=100.0)).pace.playback[-1]
        assert (pictures.format, pictures.n_frames) == ("GIF", math.ceil(10.0 * length))
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.gif", "a.html"]


def test_view_serves_where_it_is_told(
    solution: nip.Solution, monkeypatch: pytest.MonkeyPatch
) -> None:
    served: list[tuple[float, int, bool]] = []

    def serve(page: str, port: int, *, browser: bool) -> None:
        columns = {item["label"]: item["values"] for item in film_of(page)["columns"]}
        served.append((max(columns["slow motion 1 :"]), port, browser))

    monkeypatch.setattr(server, "serve", serve)
    assert nip.view(solution, port=0, browser=False, slow=100.0) is None
    assert nip.view(solution) is None
    assert served == [(100.0, 0, False), (pytest.approx(1000.0), 7000, True)]


def test_the_room_of_views_and_the_call_are_one() -> None:
    """In either order of asking, in a fresh process, and without loading what is not asked for."""
    program = (
        "import sys, inspect, nipper_pin as nip\n"
        "first = nip.view\n"
        "assert not {'numpy', 'rich', 'pinocchio'} & set(sys.modules)\n"
        "import nipper_pin.view.run.table\n"
        "assert nip.view is first and callable(nip.view)\n"
        "assert nip.view.run.table.print_solution\n"
        "assert list(inspect.signature(nip.view).parameters)[:2] == ['solution', 'file']\n"
    )
    subprocess.run([sys.executable, "-c", program], check=True)
