"""Two runs on one clock, in one page and in one figure."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from page_words import film_of, said
from snapshots import Words
from three_js import Scene

import nipper_pin as nip
from nipper_pin import Case, Comparison, InputError, Mechanism, compare, load, simulate


@pytest.fixture(scope="module")
def turns(e62: Mechanism) -> Comparison:
    """Two speeds: both are shown with their first collision at the same time."""
    return compare(*(simulate(e62, Case(speed_rpm=rpm, window="cycle")) for rpm in (450.0, 520.0)))


@pytest.fixture(scope="module")
def transitions(e62: Mechanism) -> Comparison:
    """One speed and two preloads, of which the second takes longer."""
    other = load("e62", {"preload": 7.0})
    return compare(*(simulate(item, Case(speed_rpm=650.0)) for item in (e62, other)))


@pytest.fixture(scope="module")
def pages(
    turns: Comparison, transitions: Comparison, page_of: Callable[..., str]
) -> tuple[str, str]:
    """Of both."""
    return page_of(turns), page_of(transitions)


def times(film: dict[str, Any]) -> tuple[np.ndarray, np.ndarray]:
    """Of both machines in each frame [ms]."""
    (column,) = (item for item in film["columns"] if item["label"] == "time")
    return np.array(column["values"]), np.array(column["other"])


def lines(curve: dict[str, Any]) -> list[np.ndarray]:
    """Values of each line; NaN where its run has no motion."""
    return [np.array([math.nan if value is None else value for value in item["values"]])
            for item in (curve, *curve["more"])]  # fmt: skip


def first_touch(run: nip.Solution) -> float:
    return next(hit.t for hit in run.collisions if hit.stop == "jaw")


def test_both_are_struck_first_in_the_same_frame(pages: tuple[str, str], turns: Comparison) -> None:
    film = film_of(pages[0])
    one, other = (next(hit["at"] for hit in film["collisions"]
                       if hit["stop"] == "jaw" and hit["text"].startswith(side))
                  for side in "AB")  # fmt: skip
    assert one == pytest.approx(other, rel=1e-12)
    # A second of the film is the same time of both machines; of 130 ms six digits are shown.
    later = 1e3 * (first_touch(turns.a) - first_touch(turns.b))
    moved = np.subtract(*times(film))
    np.testing.assert_allclose(moved, later, rtol=0.0, atol=1.001e-3)
    assert f"B starts {later:.3f} ms later than A" in film["note"]
    assert "The run of B ends at" in film["note"]


def test_at_one_speed_both_start_together(pages: tuple[str, str], transitions: Comparison) -> None:
    film = film_of(pages[1])
    time, other = times(film)
    np.testing.assert_array_equal(time, other)
    assert "Both start together" in film["note"]
    ends = [1e3 * run.segments[-1].t_end for run in (transitions.a, transitions.b)]
    assert ends[0] < ends[1]
    # The shorter run stands still in its last state, and its curves end.
    gap, second = lines(film["curves"][0])
    outside = np.isnan(gap)
    assert time[outside].min() > ends[0] >= time[~outside].max()
    assert not np.isnan(second).any()
    for column in film["columns"]:
        if column["label"] in ("jaw angle", "jaw gap at the contact", "steeve stroke"):
            assert np.ptp(np.array(column["values"])[outside]) == 0.0


def test_curves_of_one_name_share_their_axes(pages: tuple[str, str], turns: Comparison) -> None:
    """The values are those of each run at its own time, and the axes show the higher rebound."""
    film = film_of(pages[0])
    colours = [film["compare"][side]["colour"] for side in "ab"]
    assert colours[0] != colours[1]
    for curve in film["curves"]:
        assert [curve["colour"], *(item["colour"] for item in curve["more"])] == colours
    stop = turns.a.mechanism.stop("jaw")
    for run, values, time in zip(
        (turns.a, turns.b), lines(film["curves"][0]), times(film), strict=True
    ):
        inside = ~np.isnan(values)
        motion = run.trajectory.evaluate(1e-3 * time[inside])
        gap = 1e3 * stop.lever * stop.gaps(motion.q)
        # Six digits of the value, and half a last digit of the time at the largest rate.
        fastest = 1e3 * stop.lever * np.abs(motion.v[:, stop.index]).max()
        np.testing.assert_allclose(values[inside], gap, rtol=6e-6, atol=5.01e-7 * fastest)
    highest = max(
        hit.rebound_amplitude for run in (turns.a, turns.b) for hit in run.collisions
        if hit.stop == "jaw"
    )  # fmt: skip
    # Frames need not meet the top of a rebound.
    assert film["curves"][0]["most"] == pytest.approx(1.15 * 1e3 * stop.lever * highest, rel=1e-3)


def test_words_of_both_pages(pages: tuple[str, str], words: Words) -> None:
    """Curves and numbers of both, collisions of either in the order of time, the table below."""
    words("\n".join(map(said, pages)))
    hits = [hit["at"] for hit in film_of(pages[0])["collisions"]]
    assert hits == sorted(hits)


def test_both_machines_stand_in_the_scene(pages: tuple[str, str]) -> None:
    """The second one in its tint, and seen through; the first one's colour tells the phase."""
    scene = Scene(pages[0])
    tint = int(film_of(pages[0])["compare"]["b"]["colour"][1:], 16)
    roots = [path.split("/")[1] for path in scene.objects]
    assert roots.count("nipper") == roots.count("other") > 10
    for path, item in scene.objects.items():
        second = path.startswith("/other/")
        for material in item["materials"]:
            assert (material["color"] == tint) is second
            assert (material["opacity"] < 1.0) is second
    tints = [path for path in scene.tracks if path.endswith("<object>")]
    assert tints
    assert all(path.startswith("/nipper/") for path in tints)
    assert {"/nipper/top_nipper", "/other/top_nipper"} <= set(scene.tracks)


@pytest.mark.slow
def test_machines_of_other_parts_have_lanes_of_their_own(
    turns: Comparison, page_of: Callable[..., str]
) -> None:
    pendulum = simulate(load("hanging_pendulum"), Case(speed_rpm=220.0, window="cycle"))
    film = film_of(page_of(compare(turns.a, pendulum)))
    lines = {curve["label"][0]: len(curve["more"]) for curve in film["curves"]}
    assert lines == {"jaw gap": 1, "clamping": 1, "steeve stroke": 0, "rod stroke": 0}
    colours = {curve["label"][0]: curve["colour"] for curve in film["curves"]}
    own = (film["compare"][side]["colour"] for side in "ab")
    assert (colours["steeve stroke"], colours["rod stroke"]) == tuple(own)
    alone = {item["label"]: item["values"] is None for item in film["columns"]}
    assert alone["rod stroke"]
    assert not alone["steeve stroke"]


def test_the_view_of_python_writes_a_comparison(transitions: Comparison, tmp_path: Path) -> None:
    written = nip.view(transitions, tmp_path / "both.html")
    assert written == tmp_path / "both.html"
    assert film_of(written.read_text(encoding="utf-8"))["compare"]["a"]["name"].startswith("e62")
    with pytest.raises(InputError, match=r"written as NAME\.html$"):
        nip.view(transitions, tmp_path / "both.gif")
