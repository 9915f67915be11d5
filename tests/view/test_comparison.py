"""Two runs on one clock, in one page and in one figure."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from page_words import film_of, said
from snapshots import Words
from three_js import Scene

import nipper_pin as nip
from nipper_pin import Case, Comparison, InputError, Mechanism, compare, load, simulate
from nipper_pin.study.compare import Row
from nipper_pin.view.compare.page import comparison_page
from nipper_pin.view.compare.pair import COLOUR_A, COLOUR_B, Pair, clock_text, lanes, pair
from nipper_pin.view.compare.words import difference_text
from nipper_pin.view.scene import Look


@pytest.fixture(scope="module")
def turns(e62: Mechanism) -> Comparison:
    """Two speeds: both are shown with their first collision at the same time."""
    return compare(*(simulate(e62, Case(speed_rpm=rpm, window="cycle")) for rpm in (450.0, 520.0)))


@pytest.fixture(scope="module")
def both(turns: Comparison) -> Pair:
    return pair(turns, Look())


@pytest.fixture(scope="module")
def transitions(e62: Mechanism) -> Comparison:
    """One speed and two preloads, of which the second takes longer."""
    other = load("e62", {"preload": 7.0})
    return compare(*(simulate(item, Case(speed_rpm=650.0)) for item in (e62, other)))


def first_touch(run: nip.Solution) -> float:
    return next(hit.t for hit in run.collisions if hit.stop == "jaw")


def test_both_are_struck_first_in_the_same_frame(both: Pair, turns: Comparison) -> None:
    frames = [
        int(np.argmin(np.abs(film.pace.machine - first_touch(run))))
        for film, run in ((both.a, turns.a), (both.b, turns.b))
    ]
    assert frames[0] == frames[1]
    np.testing.assert_array_equal(both.a.pace.playback, both.b.pace.playback)
    # A second of the film is the same time of both machines.
    moved = both.b.pace.machine - both.a.pace.machine
    assert np.ptp(moved) <= 1e-15
    assert moved[0] == pytest.approx(first_touch(turns.b) - first_touch(turns.a), abs=1e-15)
    later = 1e3 * (first_touch(turns.a) - first_touch(turns.b))
    assert f"B starts {later:.3f} ms later than A" in clock_text(both)
    assert "The run of B ends at" in clock_text(both)


def test_at_one_speed_both_start_together(transitions: Comparison) -> None:
    found = pair(transitions, Look())
    assert found.later == 0.0
    np.testing.assert_array_equal(found.a.pace.machine, found.b.pace.machine)
    assert "Both start together" in clock_text(found)
    ends = [run.segments[-1].t_end for run in (transitions.a, transitions.b)]
    assert ends[0] < ends[1]
    # The shorter run stands still in its last state, and its curves end.
    outside = ~found.inside[0]
    assert found.a.pace.machine[outside].min() > ends[0]
    assert np.ptp(found.a.q[outside], axis=0).max() == 0.0
    assert found.inside[1].all()
    gap = lanes(found)[0].lines[0][1]
    np.testing.assert_array_equal(np.isnan(gap), outside)


def test_curves_of_one_name_share_their_axes(both: Pair, turns: Comparison) -> None:
    """The values are those of each run at its own time, and the axes show the higher rebound."""
    found = lanes(both)
    assert [lane.first.label[0] for lane in found] == ["jaw gap", "clamping", "steeve stroke"]
    stop = turns.a.mechanism.stop("jaw")
    for film, line, inside, colour in zip(
        (both.a, both.b), found[0].lines, both.inside, (COLOUR_A, COLOUR_B), strict=True
    ):
        assert line[0] == colour
        t = film.pace.machine[inside][::50]
        gap = 1e3 * stop.lever * stop.gaps(film.solution.trajectory.evaluate(t).q)
        np.testing.assert_allclose(line[1][inside][::50], gap, rtol=1e-12, atol=1e-12)
    highest = max(
        hit.rebound_amplitude for run in (turns.a, turns.b) for hit in run.collisions
        if hit.stop == "jaw"
    )  # fmt: skip
    # Frames need not meet the top of a rebound.
    assert found[0].most == pytest.approx(1.15 * 1e3 * stop.lever * highest, rel=1e-3)


def test_words_of_both_pages(turns: Comparison, transitions: Comparison, words: Words) -> None:
    """Curves and numbers of both, collisions of either in the order of time, the table below."""
    pages = [comparison_page(found, Look()) for found in (turns, transitions)]
    words("\n".join(said(page) for page in pages))
    film = film_of(pages[0])
    for curve, lane in zip(film["curves"], lanes(pair(turns, Look())), strict=True):
        (second,) = curve["more"]
        assert (curve["colour"], second["colour"]) == (COLOUR_A, COLOUR_B)
        for values, (_, wanted) in zip(
            (curve["values"], second["values"]), lane.lines, strict=True
        ):
            shown = np.array([math.nan if value is None else value for value in values])
            np.testing.assert_allclose(shown, wanted, rtol=6e-6, atol=1e-9)
    hits = [hit["at"] for hit in film["collisions"]]
    assert hits == sorted(hits)


def test_both_machines_stand_in_the_scene(turns: Comparison) -> None:
    """The second one in its tint, and seen through; the first one's colour tells the phase."""
    scene = Scene(comparison_page(turns, Look()))
    roots = [path.split("/")[1] for path in scene.objects]
    assert roots.count("nipper") == roots.count("other") > 10
    for path, item in scene.objects.items():
        second = path.startswith("/other/")
        for material in item["materials"]:
            assert (material["color"] == int(COLOUR_B[1:], 16)) is second
            assert (material["opacity"] < 1.0) is second
    tints = [path for path in scene.tracks if path.endswith("<object>")]
    assert tints
    assert all(path.startswith("/nipper/") for path in tints)
    assert {"/nipper/top_nipper", "/other/top_nipper"} <= set(scene.tracks)


@pytest.mark.slow
def test_machines_of_other_parts_have_lanes_of_their_own(turns: Comparison) -> None:
    pendulum = simulate(load("hanging_pendulum"), Case(speed_rpm=220.0, window="cycle"))
    film = film_of(comparison_page(compare(turns.a, pendulum), Look()))
    lines = {curve["label"][0]: len(curve["more"]) for curve in film["curves"]}
    assert lines == {"jaw gap": 1, "clamping": 1, "steeve stroke": 0, "rod stroke": 0}
    colours = {curve["label"][0]: curve["colour"] for curve in film["curves"]}
    assert (colours["steeve stroke"], colours["rod stroke"]) == (COLOUR_A, COLOUR_B)
    alone = {item["label"]: item["values"] is None for item in film["columns"]}
    assert alone["rod stroke"]
    assert not alone["steeve stroke"]


def test_the_view_of_python_writes_a_comparison(transitions: Comparison, tmp_path: Path) -> None:
    written = nip.view(transitions, tmp_path / "both.html")
    assert written == tmp_path / "both.html"
    assert film_of(written.read_text(encoding="utf-8"))["compare"]["a"]["name"].startswith("e62")
    with pytest.raises(InputError, match=r"written as NAME\.html$"):
        nip.view(transitions, tmp_path / "both.gif")


@pytest.mark.parametrize(
    ("row", "text"),
    [
        (Row("duration_s", "s", 2.0, 2.2), "+10.0 %"),
        (Row("duration_s", "s", 2.0, 1.99), "-0.50 %"),
        (Row("duration_s", "s", 2.0, 2.0000001), "< 0.01 %"),
        (Row("duration_s", "s", 2.0, 2.0), "0"),
        (Row("duration_s", "s", 1.0, 31.0), "+3000 %"),
        (Row("duration_s", "s", None, 2.0), "-"),
        (Row("energy_lost_turn_J", "J", 0.0, 0.002), "+2.000 mJ"),
        (Row("closing_index", "", 34.0, 34.25), "+0.250"),
        (Row("closing_index", "", 34.0, 34.0 + 1e-9), "< 0.001"),
        (Row("collisions_jaw", "", 6.0, 4.0), "-2"),
    ],
)
def test_a_difference_in_words(row: Row, text: str) -> None:
    assert difference_text(row) == text
