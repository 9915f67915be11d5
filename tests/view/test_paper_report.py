"""Figures, tables and page of the published study, as far as no browser is needed."""

from __future__ import annotations

import csv
import io
import json
import re
from dataclasses import replace
from html import escape
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest
from matplotlib.contour import ContourSet
from scipy.interpolate import RegularGridInterpolator

from nipper_pin.errors import InputError
from nipper_pin.mechanism import Mechanism, load
from nipper_pin.study.identify.record import read_identification
from nipper_pin.study.paper import PaperStudy, paper_study
from nipper_pin.study.paper.designer import HowFast, designer
from nipper_pin.study.paper.designs import RESTITUTIONS
from nipper_pin.study.sensitivity import sensitivities
from nipper_pin.view.paper.files import write_paper
from nipper_pin.view.paper.front_page import front_page
from nipper_pin.view.paper.kinematic_figures import kinematic_plates
from nipper_pin.view.paper.published_figures import published_plates
from nipper_pin.view.paper.question_figures import question_plates
from nipper_pin.view.paper.report import Material, material, report_html, study_plates
from nipper_pin.view.paper.supplements import Supplements
from nipper_pin.view.paper.tables import percent

# The studies of the paper take a quarter of a minute.
pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def study(e62: Mechanism) -> PaperStudy:
    return paper_study(e62)


@pytest.fixture(scope="module")
def content(study: PaperStudy) -> Material:
    return material(study, Supplements(), study_plates(study))


@pytest.fixture(scope="module")
def page(study: PaperStudy, content: Material) -> str:
    return report_html(study, Supplements(), content)


class Tags(HTMLParser):
    """Start tags with their attributes, and whether every element was closed."""

    VOID = ("meta", "link", "br", "img", "hr", "input")

    def __init__(self) -> None:
        super().__init__()
        self.found: list[tuple[str, dict[str, str | None]]] = []
        self.open: list[str] = []

    def handle_starttag(self, tag, attrs):
        self.found.append((tag, dict(attrs)))
        if tag not in self.VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag, attrs):
        self.found.append((tag, dict(attrs)))

    def handle_endtag(self, tag):
        assert self.open.pop() == tag


@pytest.mark.slow
def test_the_page_is_well_formed_and_points_nowhere_else(page):
    """Whatever a browser would fetch: sources, style sheets, imports, fonts."""
    tags = Tags()
    tags.feed(page)
    assert tags.open == []
    names = {tag for tag, _ in tags.found}
    assert not names & {"script", "img", "iframe", "object", "embed", "image"}
    for tag, attributes in tags.found:
        assert "src" not in attributes
        for key in ("href", "xlink:href"):
            target = attributes.get(key)
            assert target is None or target.startswith(("#", "data:")), (tag, target)
    assert "@import" not in page
    assert not re.search(r"url\((?!#)", page)


def test_every_figure_and_table_is_on_the_page_once_with_its_number(page, content):
    """The paper's own keep the paper's numbers; all others count from A1 on, in their order."""
    for items, prefix, word, own in (
        (content.plates, "", "Figure", ["11", "12", "13", "14"]),
        (content.tables, "table-", "Table", ["3", "4", "5"]),
    ):
        for item in items:
            assert page.count(f' id="{prefix}{item.name}"') == 1
        numbers = re.findall(rf"<b>{word} (A?\d+)\. ", page)
        others = [number for number in numbers if number.startswith("A")]
        assert [number for number in numbers if number not in others] == own
        assert others == [f"A{i}" for i in range(1, len(items) - len(own) + 1)]
    for number in ("11", "12", "13", "14"):
        assert re.search(rf'<figure id="figure_{number}">.*?<b>Figure {number}\. ', page, re.S)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["hanging_pendulum", "e62_offset_guide"])
def test_the_page_of_another_comber(name):
    """It has the same figures and tables where they apply, and speaks of no other machine."""
    study = paper_study(load(name))
    content = material(study, Supplements(), study_plates(study))
    page = report_html(study, Supplements(), content)
    test_the_page_is_well_formed_and_points_nowhere_else(page)
    test_every_figure_and_table_is_on_the_page_once_with_its_number(page, content)
    test_no_value_is_missing_or_unwritten(page)
    text = re.sub(r"<svg.*?</svg>|<head>.*?</head>", "", page, flags=re.DOTALL)
    assert not re.search(r"of the paper|published ratio|figure_none|deviation", text)
    stop = study.phase_one.stop
    assert ("steeve" in text) == (stop == "steeve")
    assert f"The {stop}" in text
    sections = [int(number) for number in re.findall(r"<h2[^>]*>(\d+) ", text)]
    assert sections == list(range(1, len(sections) + 1))
    assert len(content.plates) >= 10


def test_no_value_is_missing_or_unwritten(page):
    """Half-filled templates show names of objects, NaN or None."""
    text = re.sub(r"<svg.*?</svg>", "", page, flags=re.DOTALL)
    for wrong in ("nan", "None", "Undefined", "{{", "}}", "{%", "np.float64", "inf "):
        assert not re.search(rf"(?<![a-z]){re.escape(wrong)}(?![a-z])", text), wrong


def test_no_two_figures_share_an_identifier(content):
    seen: set[str] = set()
    for plate in content.plates:
        names = set(re.findall(r'\bid="([^"]+)"', plate.inline_svg))
        assert names
        assert not names & seen
        seen |= names
        used = set(re.findall(r'(?:href="#|url\(#)([^")]+)', plate.inline_svg))
        assert used <= names


@pytest.mark.slow
def test_figures_are_the_same_bytes_for_the_same_numbers(study, content):
    drawn = {plate.name: plate.svg for plate in content.plates}
    for other in published_plates(study):
        assert drawn[other.name] == other.svg


def test_every_panel_holds_lines_and_units(content):
    for plate in content.plates:
        panels = [axes for axes in plate.figure.axes if axes.get_label() != "<colorbar>"]
        assert panels
        for axes in panels:
            drawn = [line for line in axes.lines if len(line.get_xdata()) > 1]
            assert drawn or axes.collections, plate.name
            label = axes.get_ylabel()
            shared = axes.get_shared_y_axes().get_siblings(axes)
            labels = [label, *(item.get_ylabel() for item in shared)]
            assert any("[" in text or text in ("collisions", "relative error") for text in labels)


@pytest.mark.slow
def test_figure_11_holds_the_motion(study):
    figure = published_plates(study)[0].figure
    data = study.studies.speed
    for axes, amplitude, time in zip(figure.axes, data.amplitudes, data.times, strict=True):
        t, angle = (np.asarray(item, dtype=float) for item in axes.lines[0].get_data())
        first = t <= 1e3 * time[0]
        assert np.radians(1e-3 * angle[first].max()) == pytest.approx(amplitude[0], rel=1e-3)
        assert np.radians(1e-3 * angle[~first].max()) == pytest.approx(amplitude[1], rel=1e-3)


@pytest.mark.slow
def test_figures_12_to_14_hold_the_studies(study):
    _, impulses, restitution, stiffness = published_plates(study)
    speed = study.studies.speed
    for i, line in enumerate(impulses.figure.axes[0].lines):
        assert np.asarray(line.get_ydata())[:5] == pytest.approx(speed.table.impulse[i, :5])
    e, t = restitution.figure.axes[0].lines[0].get_data()
    assert list(e) == list(study.published.restitutions)
    assert list(t) == list(1e3 * study.studies.restitution.durations)
    k, t = stiffness.figure.axes[0].lines[0].get_data()
    assert list(k) == [7.0, 8.0, 9.0, 10.0, 11.0]
    assert list(t) == list(1e3 * study.studies.stiffness.durations)


def test_no_line_is_drawn_through_a_jump(study):
    """At the change of phase rates jump; the curves are cut there."""
    plate = kinematic_plates(study)[2]
    for axes in plate.figure.axes[2:]:
        values = np.asarray(axes.lines[0].get_ydata(), dtype=float)
        assert np.isnan(values).sum() == 2


@pytest.mark.slow
def test_contours_of_the_map_run_through_their_times(study):
    """Along a line of 5 ms the map, interpolated, is 5 ms: to the square of its mesh, 1e-3 ms."""
    axes = question_plates(study)[-1].figure.axes[0]
    lines = next(
        item for item in axes.collections if isinstance(item, ContourSet) and not item.filled
    )
    path = lines.get_paths()[list(lines.levels).index(5.0)]
    read = RegularGridInterpolator(
        (RESTITUTIONS, study.designs.speeds_rpm), 1e3 * study.designs.durations[0]
    )
    assert len(path.vertices) > 50
    # An end of the line may lie beside the map by round-off.
    speeds = study.designs.speeds_rpm
    speed = np.clip(path.vertices[:, 0], speeds[0], speeds[-1])
    assert np.abs(speed - path.vertices[:, 0]).max() < 1e-9
    inside = np.column_stack([path.vertices[:, 1], speed])
    assert read(inside) == pytest.approx(5.0, abs=1e-3)


def test_tables_as_csv_read_back_to_the_last_bit(study, content):
    """What people see is rounded; what programs read is not."""
    for table in content.tables:
        rows = list(csv.reader(io.StringIO(table.csv_text())))
        assert rows[0] == [column.key for column in table.columns]
        assert len(rows) == len(table.rows) + 1
        assert all(len(row) == len(rows[0]) for row in [*rows, *table.shown])
    table_4 = next(item for item in content.tables if item.name == "table_4")
    rows = list(csv.DictReader(io.StringIO(table_4.csv_text())))
    read = [float(row["duration_s"]) for row in rows]
    assert read == study.studies.restitution.durations.tolist()


def test_percentages_have_a_sign_but_no_minus_zero():
    assert [percent(x) for x in (0.0123, -0.5, -1e-6, 0.0)] == [
        "+1.2 %", "-50.0 %", "+0.0 %", "+0.0 %",
    ]  # fmt: skip


def test_names_of_a_model_cannot_write_into_the_page(study, content):
    """A title is text of a file that somebody else wrote."""
    mechanism = replace(study.mechanism, title="<script>alert(1)</script>")
    page = report_html(replace(study, mechanism=mechanism), Supplements(), content)
    assert "<script>" not in page
    assert "&lt;script&gt;" in page


IDENTIFIED = {
    "title": "numbers of a machine",
    "model": "e62",
    "caution": "Fitted, not validated.",
    "seed": 7,
    "within_4_percent": 1,
    "singular_values": [12.0, 0.3],
    "identifiable_directions": 1,
    "profiles": [
        {"path": "springs.steeve.preload_length_mm", "sigma": 0.5, "values": [7.75, 8.25, 8.75],
         "cost": [0.6, 0.0, 0.45], "quadratic": [0.5, 0.0, 0.5]}
    ],
    "goodness": {"verdict": "agrees", "sentence": "The data agree with the fit."},
    "targets": [
        {
            "name": "a", "wanted": 2.0, "sigma": 0.25, "found": 2.2, "relative_deviation": 0.1,
            "residual_sigmas": 0.8, "outlier": False,
        }
    ],
    "parameters": [
        {
            "path": "springs.steeve.preload_length_mm", "low": 6.0, "high": 22.0, "before": 11.0,
            "identified": 8.25, "standard_deviation": 0.5, "standard_deviation_scaled": None,
            "range_left": 0.43, "determined": True,
        }
    ],
}  # fmt: skip


def test_transitions_that_no_turn_has_are_named(study, content, page):
    """The summary says so, with the values; where every turn has its transition it is silent."""
    assert "No turn has the transition" not in page
    assert [row["premise_holds"] for row in study.studies.speed.record()] == [True, True, True]
    speed = study.studies.speed
    told = np.array([True, True, False], dtype=object)
    late = replace(speed, table=replace(speed.table, premise_holds=told))
    assert late.without_turn == (650.0,)
    doctored = replace(study, studies=replace(study.studies, speed=late))
    found = report_html(doctored, Supplements(), content)
    assert "<b>No turn has the transition</b> computed for speed 650:" in found


@pytest.mark.slow
def test_results_of_other_studies_are_shown_after_it(study, e62, tmp_path):
    """Sections, figure, tables and files of both; and none of them without results."""
    chosen = ("speed_rpm", "stops.jaw.restitution", "springs.steeve.preload_length_mm")
    found = sensitivities(e62, 650.0, chosen)
    (tmp_path / "identified.json").write_text(json.dumps(IDENTIFIED), encoding="utf-8")
    document = read_identification(tmp_path / "identified.json")
    known = designer(e62, found, HowFast(None, "it was not asked"))
    assert [lever.path for lever in known.levers] == [chosen[2], chosen[1]]
    added = Supplements(found, document, known)
    report, *others = write_paper(study, tmp_path / "out", lambda: added)
    page = report.read_text(encoding="utf-8")
    assert re.search(
        r"<h2[^>]*>7 Sensitivities</h2>.*<h2[^>]*>8 Identification</h2>.*<h2[^>]*>9 Method</h2>.*"
        r"<h2[^>]*>10 Accuracy",
        page,
        re.S,
    )
    assert "Fitted, not validated." in page
    assert "The data agree with the fit." in page
    assert "<td>8.250</td>" in page
    names = {path.name for path in others}
    assert names >= {"sensitivities.svg", "sensitivities.csv", "identified_numbers.csv"}
    assert names >= {"identification.svg", "identification.pdf"}
    rows = list(csv.DictReader(io.StringIO((tmp_path / "out/sensitivities.csv").read_text())))
    # 1 % more of the restitution: amplitude by e^2, so by nearly 2 % and never by more.
    change = {row["path"]: float(row["rebound_amplitude_1_percent"]) for row in rows}
    assert 1.5 < change["stops.jaw.restitution"] < 2.0
    record = json.loads((tmp_path / "out" / "study.json").read_text(encoding="utf-8"))
    assert len(record["sensitivities"]["percent_per_unit"]) == 3
    first = page[page.index('<section id="designer">') : page.index("<nav>")]
    said = front_page(study, known)
    for text in (*said.bounces, said.why, *said.fast):
        assert escape(text, quote=False) in first.replace("&#39;", "'").replace("\u00a0", " "), text
    for line in said.levers:
        for text in (line.words, line.value, line.typed, line.amplitude, line.duration):
            assert text in first
    assert "never the maker" in first
    assert '<figure id="designs">' in first
    assert [item["path"] for item in record["designer"]["levers"]] == [
        lever.path for lever in known.levers
    ]


def test_without_other_results_there_is_no_section_for_them(page):
    assert re.search(r"<h2[^>]*>7 Method</h2>.*<h2[^>]*>8 Accuracy", page, re.S)
    assert "Sensitivities</h2>" not in page
    assert "Identification</h2>" not in page


@pytest.mark.parametrize(
    "text", ["", "[]", "{}", '{"parameters": 1}', json.dumps({**IDENTIFIED, "targets": [3]})]
)
def test_files_that_are_no_identification_are_refused(text, tmp_path):
    (tmp_path / "file.json").write_text(text, encoding="utf-8")
    with pytest.raises(InputError, match="identify --json"):
        read_identification(tmp_path / "file.json")


@pytest.mark.slow
def test_a_folder_that_is_a_file_is_refused(study, tmp_path: Path):
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="not a folder"):
        write_paper(study, tmp_path / "file")
