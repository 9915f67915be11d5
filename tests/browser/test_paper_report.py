"""The report of the published study as a reader sees it: opened in Chromium."""

from __future__ import annotations

import io
import re
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from printed import printed

from nipper_pin.mechanism import Mechanism
from nipper_pin.study.paper import PaperStudy, paper_study
from nipper_pin.study.paper.designer import designer, how_fast
from nipper_pin.study.sensitivity import sensitivities
from nipper_pin.view.paper.files import write_paper
from nipper_pin.view.paper.supplements import Supplements

# A browser takes seconds to start and to draw.
pytestmark = pytest.mark.slow

FIGURES = [
    "designs", "mechanism", "figure_11", "figure_12", "figure_13", "figure_14", "guide", "links",
    "both_stops", "thresholds", "drives", "stop_force", "fixed_step", "shares", "sensitivities",
    "identification",
]  # fmt: skip
COLOUR_BARS = {"stop_force-axes_3", "designs-axes_4"}
# Frames, ticks and their labels alone are fewer than these.
FEWEST_PATHS = 60


@pytest.fixture(scope="module")
def study(e62: Mechanism) -> PaperStudy:
    return paper_study(e62)


@pytest.fixture(scope="module")
def files(study: PaperStudy, tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    # A few numbers of the fifty: the page has the same parts.
    paths = ("speed_rpm", "stops.jaw.restitution", "springs.steeve.preload_length_mm")
    document = {
        "title": "one number", "model": "e62", "caution": "Fitted, not validated.", "seed": 7,
        "goodness": {"verdict": "agrees", "sentence": "The data agree with the fit."},
        "within_4_percent": 1, "singular_values": [12.0, 0.3], "identifiable_directions": 1,
        "targets": [{"name": "a", "wanted": 2.0, "found": 2.2, "relative_deviation": 0.1,
                     "sigma": 0.25, "residual_sigmas": 0.8, "outlier": False}],
        "parameters": [{"path": paths[2], "low": 6.0, "high": 22.0, "before": 11.0,
                        "identified": 8.25, "standard_deviation": 0.5,
                        "standard_deviation_scaled": 0.6, "range_left": 0.43,
                        "determined": True}],
        "profiles": [{"path": paths[2], "sigma": 0.5, "values": [7.75, 8.25, 8.75],
                      "cost": [0.6, 0.0, 0.45], "quadratic": [0.5, 0.0, 0.5]}],
    }  # fmt: skip
    found = sensitivities(study.mechanism, 650.0, paths)
    known = designer(study.mechanism, found, how_fast(study.mechanism))
    added = Supplements(found, document, known)
    return write_paper(study, tmp_path_factory.mktemp("paper") / "new" / "folder", lambda: added)


@pytest.fixture
def report(files: list[Path], open_page):
    with open_page(files[0]) as opened:
        yield opened


def pixels(png: bytes) -> np.ndarray:
    return np.asarray(Image.open(io.BytesIO(png)).convert("RGB")).astype(float)


def test_the_page_complains_of_nothing_and_asks_for_nothing(report, files):
    """A font, script or picture from elsewhere would be a second request; a bad one an error."""
    report.page.mouse.wheel(0, 20_000)
    report.page.wait_for_load_state("networkidle")
    assert report.requests == [files[0].resolve().as_uri()]
    assert report.complaints == []


def test_every_figure_is_there_and_shows_something(report):
    """An empty or collapsed figure has no size, few paths, or pixels of one colour."""
    drawn = report.page.locator("figure:not(.table)")
    assert [drawn.nth(i).get_attribute("id") for i in range(drawn.count())] == FIGURES
    for name in FIGURES:
        svg = report.page.locator(f"figure#{name} > svg")
        assert svg.count() == 1, name
        box = svg.bounding_box()
        assert box is not None, name
        assert box["width"] > 600.0, name
        assert box["height"] > 200.0, name
        shapes = svg.evaluate(
            "svg => [...svg.querySelectorAll('path, use')].filter(item => {"
            " const box = item.getBoundingClientRect();"
            " return box.width + box.height > 1; }).length"
        )
        assert shapes > FEWEST_PATHS, name
        picture = pixels(svg.screenshot())
        assert picture.std() > 5.0, name
        # Ink is spread over the figure, not a frame or a title alone: most of a grid of squares
        # holds some.
        rows = [np.array_split(row, 8, axis=1) for row in np.array_split(picture, 6, axis=0)]
        inked = [square.std() > 1.0 for row in rows for square in row]
        assert np.mean(inked) > 0.6, name


def test_every_panel_holds_a_curve_or_marks(report):
    """What is drawn from data is clipped to its panel; grid lines, shading and frames are left out.

    Each panel has a clipped path with both a width and a height on the screen, or three marks.
    """
    panels = report.page.evaluate(
        "[...document.querySelectorAll('figure:not(.table) g[id]')]"
        ".filter(item => /-axes_[0-9]+$/.test(item.id)).map(axes => {"
        " const free = item => !item.closest('[id*=patch_]') && !item.closest('[id*=axis_]');"
        " const clipped = [...axes.querySelectorAll('path[clip-path], [clip-path] path')]"
        "   .filter(free).map(item => item.getBoundingClientRect())"
        "   .filter(box => box.width > 10 && box.height > 3).length;"
        " const marks = [...axes.querySelectorAll('[clip-path] use')].filter(free).length;"
        " return [axes.id, clipped, marks]; })"
    )
    # Insets are panels too. Two colour bars are panels of their own, filled with an image or cells;
    # bars are patches.
    curves = [item for item in panels if item[1] > 0 or item[2] >= 3]
    assert len(panels) == 45
    others = {item[0] for item in panels} - {item[0] for item in curves}
    assert {name for name in others if not name.startswith("sensitivities-")} <= COLOUR_BARS


def test_no_two_elements_share_an_identifier(report):
    """Clip paths and glyphs are named; a figure that took another's would be cut or misspelt."""
    names = report.page.evaluate("[...document.querySelectorAll('[id]')].map(item => item.id)")
    assert len(names) > 100
    assert len(set(names)) == len(names)
    missing = report.page.evaluate(
        "[...document.querySelectorAll('use')].map(item => item.getAttribute('xlink:href'))"
        ".filter(name => !document.getElementById(name.slice(1)))"
    )
    assert missing == []


def test_the_ratios_are_in_the_table_that_is_seen(report, study):
    text = report.page.locator("#table-ratios").inner_text()
    for item in study.ratios:
        assert f"{item.published:g}" in text
    assert report.page.locator("#table-ratios tbody tr").count() == len(study.ratios)
    first = study.ratios[0]
    assert f"{100 * first.relative_deviation:+.1f} %" in text


def test_what_is_read_first_says_whose_numbers_these_are(report):
    """Without scrolling."""
    note = report.page.locator(".note").first
    assert "never the maker's data" in note.inner_text()
    assert note.bounding_box()["y"] < 600.0


def test_nothing_is_wider_than_the_page(report):
    """A page that scrolls sideways hides what is at the right."""
    assert report.page.evaluate(
        "document.documentElement.scrollWidth <= document.documentElement.clientWidth"
    )
    wide = report.page.evaluate(
        "[...document.querySelectorAll('figure.table')].filter(item =>"
        " item.scrollWidth > item.clientWidth + 1).map(item => item.id)"
    )
    assert wide == []


def test_every_figure_and_table_has_its_files(files, study):
    names = {path.name for path in files}
    assert names >= {f"{name}.{kind}" for name in FIGURES for kind in ("svg", "pdf")}
    assert names >= {f"table_{number}.csv" for number in (3, 4, 5)}
    for path in files:
        assert path.stat().st_size > 0
        if path.suffix == ".pdf":
            assert path.read_bytes().startswith(b"%PDF-")
    assert files[0].name == "report.html"
    assert files[0].stat().st_size < 5_000_000
    rows = files[0].with_name("table_3.csv").read_text(encoding="utf-8").splitlines()
    assert rows[0].startswith("speed_rpm,rebound_amplitude_1")
    assert float(rows[1].split(",")[1]) == study.studies.speed.amplitudes[0, 0]


def test_every_figure_says_whose_numbers_these_are(files):
    """Also on its own, as a file: the line is text in the PDF's picture and glyphs in the SVG."""
    for name in FIGURES:
        svg = files[0].with_name(f"{name}.svg").read_text(encoding="utf-8")
        assert re.search(r"<!-- estimate of the E62 class .* not the maker's data -->", svg), name


def test_it_prints_on_a4_without_orphans(report):
    """The designer's page is the first sheet, and nothing stands apart from what it belongs to."""
    sheet = printed(report.page)
    assert sheet.size_mm == pytest.approx((210.0, 297.0), abs=0.3)
    pages = sheet.pages
    # The first sheet holds the designer's section and nothing else.
    assert (pages["designer"], pages["end-designer"]) == (0, 0)
    inside = [part.name for part in sheet.parts if pages[part.name] == 0]
    after = [part for part in sheet.parts if pages[part.name] > 0]
    assert after[0].kind == "nav"
    assert pages[after[0].name] == 1
    assert inside == [part.name for part in sheet.parts[: len(inside)]]
    assert {"designs", "end-designs"} <= {name for name, place in pages.items() if place == 0}
    # A heading is followed on its sheet by what it is the heading of.
    headings = [part for part in sheet.parts if part.kind in ("h2", "h3")]
    assert len(headings) > 15
    for part in headings:
        assert pages[part.following] == pages[part.name], part.name
    # Figures, short tables and rows are on one sheet, captions with them.
    for part in sheet.parts:
        if part.kind == "tr" or (part.kind == "figure" and "long" not in part.classes):
            assert pages[f"end-{part.name}"] == pages[part.name], part.name
    assert sheet.count < 30


def test_nothing_is_wider_than_a_printed_page(report):
    """At the width that A4 leaves between its margins."""
    report.page.emulate_media(media="print")
    width = round((210.0 - 2.0 * 16.0) / 25.4 * 96.0)
    report.page.set_viewport_size({"width": width, "height": 1000})
    wide = report.page.evaluate(
        "width => [...document.querySelectorAll('main *:not(svg *)')].filter(item =>"
        " item.getBoundingClientRect().right > width + 0.5 ||"
        " item.scrollWidth > item.clientWidth + 1 && item.clientWidth > 0)"
        ".map(item => item.localName + '#' + item.id + ' ' + item.textContent.slice(0, 60))",
        width,
    )
    assert wide == []


def test_the_first_page_speaks_of_levers_and_speed(report):
    """What a designer looks for is on it: sentences, the levers that were asked for and the map."""
    first = report.page.locator("#designer")
    assert first.locator("table.levers tbody tr").count() == 2
    text = first.inner_text()
    assert "What bounces." in text
    assert "How fast it can run." in text
    assert "never the maker's data" in text
    for target in report.page.locator("nav a").all():
        name = target.get_attribute("href")
        assert name is not None
        assert report.page.locator(name).count() == 1
