"""First page of the report: what bounces, levers and speeds, in words.

Numbers of made-up machines come from closed forms here; those of the E62 from runs of changed
models, which the page's own code does not make: a lever that is weaker than another, a changed
model that differs, or a limit in the wrong place would be seen.
"""

from __future__ import annotations

import math
import re
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from nipper_pin import Case, Mechanism, load, simulate, turn_table
from nipper_pin.study.paper.designer import Designer, HowFast, designer, how_fast
from nipper_pin.study.paper.levers import Bounce, Lever
from nipper_pin.study.paper.phase_one import phase_one
from nipper_pin.study.sensitivity import every_path, sensitivities
from nipper_pin.study.speed_limit import SpeedRange, Verdict
from nipper_pin.view.paper.front_page import FrontPage, change_words, front_page

BEFORE = Bounce(-20.0, (4e-3, 2e-4), (6e-3, 9e-4), 8e-3, 120.0)
AFTER = Bounce(-18.0, (3e-3, 1e-4), (5e-3, 7e-4), 6e-3, 126.0)


def study_of(mechanism: Mechanism, threshold: float = math.inf) -> Any:
    """The parts of a study that the first page needs."""
    stop = SimpleNamespace(stop="steeve", preload=0.011, threshold_rpm=lambda _: threshold)
    return SimpleNamespace(mechanism=mechanism, phase_one=stop)


EVERYWHERE = (SpeedRange(400.0, 900.0, Verdict.YES),)


def up_to(limit: float) -> tuple[SpeedRange, ...]:
    return SpeedRange(400.0, limit, Verdict.YES), SpeedRange(limit, 900.0, Verdict.NO)


def limit(**others: Any) -> Any:
    """Turns at three made-up speeds."""
    given: dict[str, Any] = {
        "speed_rpm": np.array([400.0, 650.0, 900.0]), "margin": np.array([12.0, 10.25, np.nan]),
        "settled": EVERYWHERE, "single": EVERYWHERE, "lost": "", **others,
    }  # fmt: skip
    return SimpleNamespace(**given)


def page_of(e62: Mechanism, fast: HowFast, threshold: float = math.inf) -> FrontPage:
    lever = Lever("springs.steeve.preload_length_mm", "mm", 11.0, 12.0, BEFORE, AFTER)
    return front_page(study_of(e62, threshold), Designer(650.0, BEFORE, (lever,), fast))


def test_made_up_bounce_in_words(e62: Mechanism) -> None:
    """Each number in the unit that people read, and the lever's old and new ones."""
    page = page_of(e62, HowFast(None, "it has no table"))
    contact = e62.stop("jaw").contact
    assert contact is not None
    first, second, third = page.bounces[0], page.bounces[1], page.why
    numbers = [float(text) for text in re.findall(r"\d+\.?\d*", first)]
    arm = 1e3 * contact.lever_m
    wanted = [650.0, 20.0 * arm, math.degrees(4.0), 4.0 * arm, 6.0, math.degrees(0.2), 0.9]
    assert numbers == pytest.approx(wanted, rel=1e-3)
    assert re.findall(r"mm/s|mdeg|µm|ms\b", first) == ["mm/s", "mdeg", "µm", "ms", "mdeg", "ms"]
    numbers = [float(text) for text in re.findall(r"\d+\.?\d*", second)]
    assert numbers == pytest.approx([8.0, 8e-3 * 650.0 / 60.0 * 40.0, 40.0, 120.0], rel=2e-3)
    assert "20 %" in third
    assert "restitution 0.2" in third
    (line,) = page.levers
    assert line.words == "preload length of spring steeve 1 mm more"
    assert line.value == "11 → 12 mm"
    assert line.typed == "--set springs.steeve.preload_length_mm=12"
    assert (line.amplitude_change, line.duration_change, line.clamping_change) == (
        "-25.0 %", "-25.0 %", "+5.0 %",
    )  # fmt: skip
    assert [float(x) for x in line.amplitude.split(" → ")] == pytest.approx(
        [math.degrees(4.0), math.degrees(3.0)], rel=1e-3
    )
    assert [float(x) for x in line.duration.split(" → ")] == [8.0, 6.0]
    assert page.fast == (
        "That is not known, since its turns cannot be tabulated: it has no table.",
    )


def test_speeds_in_words(e62: Mechanism) -> None:
    """What is known of the range, with and without limits."""
    free = " ".join(page_of(e62, HowFast(limit())).fast)
    assert "The jaw is at rest before it opens again at every speed." in free
    assert "At 650 r/min it holds for 10.2 index units" in free
    assert "like the one before at every speed" in free
    assert "leaves its stop" not in free
    lost = "At one speed it is lost."
    bound = HowFast(limit(settled=up_to(734.4), single=up_to(800.6), lost=lost))
    told = " ".join(page_of(e62, bound, threshold=640.7).fast)
    assert "at rest before it opens again from 400 to 734.4 r/min" in told
    assert "still bounces when it opens from 734.4 to 900 r/min" in told
    assert "like the one before from 400 to 800.6 r/min" in told
    assert "At one speed it is lost." in told
    assert "the steeve leaves its stop from 641 r/min on" in told


@pytest.mark.parametrize(
    ("path", "unit", "old", "new", "words"),
    [
        ("points.rocker_pin.x_mm", "mm", 3.0, 2.0, "rocker pin 1 mm backward"),
        ("points.rocker_pin.z_mm", "mm", 3.0, 4.0, "rocker pin 1 mm upward"),
        ("points.jaw.x_mm", "mm", 3.0, 4.0, "pin jaw 1 mm forward"),
        ("points.nipper_pivot.radius_mm", "mm", 5.0, 4.0,
         "nipper pivot 1 mm nearer to its shaft"),
        ("points.a_pin.angle_deg", "deg", 5.0, 4.0, "a pin 1 degree clockwise about its shaft"),
        ("stops.jaw.restitution", "%", 0.2, 0.198, "restitution of stop jaw 1 % less"),
        ("links.top.mass_kg", "0.1 g", 0.0, 1e-4, "mass of top 0.1 g more"),
    ],
)  # fmt: skip
def test_changes_in_words(path: str, unit: str, old: float, new: float, words: str) -> None:
    assert change_words(Lever(path, unit, old, new, BEFORE, AFTER)) == words


CHANGEABLE = ("springs.", "points.", "drives.", "stops.jaw.")
SHAFTS = ("tension_shaft", "pendulum_shaft", "cylinder_axis")


def amplitude(path: str, value: float) -> tuple[float, float]:
    """First rebound and time to rest of the E62 with one number changed, at 650 r/min."""
    run = simulate(load("e62", {path: value}), Case(speed_rpm=650.0))
    first = run.collisions[0].rebound_amplitude
    assert first is not None
    return first, run.transitions[0].duration


def calmer(path: str, value: float, here: float) -> tuple[float, float]:
    """The lower first rebound of the two machines one unit away, and the number that gives it."""
    one = 1.0 if path.endswith(("_mm", "_deg")) else 0.01 * value
    return min((amplitude(path, value + sense * one)[0] / here, value + sense * one)
               for sense in (-1.0, 1.0))  # fmt: skip


@pytest.mark.slow
def test_levers_are_the_strongest_of_changed_models(e62: Mechanism) -> None:
    """All numbers of the nipper that can be set, each changed both ways by one unit and run."""
    chosen = [
        path for path in every_path(e62)
        if path.startswith(CHANGEABLE) and path.split(".")[1] not in SHAFTS
    ]  # fmt: skip
    found = sensitivities(e62, 650.0, ["speed_rpm", "points.tension_shaft.x_mm", *chosen])
    values = {row.path: row.value for row in found.rows}
    run = simulate(e62, Case(speed_rpm=650.0))
    here = run.collisions[0].rebound_amplitude
    assert here is not None
    tried = {path: calmer(path, values[path], here) for path in chosen}
    order = sorted(tried, key=lambda path: tried[path])
    parts = list(dict.fromkeys(path.rpartition(".")[0] for path in order))[:3]
    known = designer(e62, found, HowFast(None, "not asked"))
    assert [lever.path.rpartition(".")[0] for lever in known.levers] == parts
    page = front_page(study_of(e62), known)
    for lever, line in zip(known.levers, page.levers, strict=True):
        # The number is typed as a person would.
        path, _, typed = line.typed.removeprefix("--set ").partition("=")
        assert float(typed) == pytest.approx(tried[path][1], rel=1e-5)
        first, duration = amplitude(path, float(typed))
        for text, old, new, factor in (
            (line.amplitude, here, first, 1e3 * 180.0 / math.pi),
            (line.duration, run.transitions[0].duration, duration, 1e3),
        ):
            shown = [float(x) for x in text.split(" → ")]
            assert shown == pytest.approx([factor * old, factor * new], rel=6e-4)
        assert float(line.amplitude_change[:-2]) == pytest.approx(
            100.0 * (first / here - 1.0), abs=0.06
        )
        assert lever.after.duration_s == pytest.approx(duration, rel=1e-9)


@pytest.mark.slow
def test_speeds_are_those_of_single_turns(e62: Mechanism) -> None:
    """On both sides of the limit, and between rest and opening, by the direct engine."""
    study = study_of(e62)
    study.phase_one = phase_one(e62, (450.0,))
    fast = how_fast(e62)
    assert fast.limit is not None
    text = " ".join(front_page(study, Designer(650.0, BEFORE, (), fast)).fast)
    (told,) = re.findall(r"opens again from \S+ to (\S+) r/min", text)
    settles = float(told.replace(",", ""))
    table = turn_table(e62, speed_rpm=[0.998 * settles, 1.002 * settles], engine="direct")
    assert np.isfinite(table.rest_index).tolist() == [True, False]
    (margin,) = re.findall(r"it holds for ([\d.]+) index units", text)
    run = simulate(e62, Case(speed_rpm=650.0, window="cycle", cycles=3))
    index = [e62.cylinder.index_from_angle(float(run.shaft.angle(event.t)))
             for event in run.events if _of_jaw(event)]  # fmt: skip
    assert float(margin) == pytest.approx((index[-1] - index[-2]) % 40.0, abs=0.06)


def _of_jaw(event: Any) -> bool:
    """Rest of the jaw, and its opening."""
    rests = event.kind.value == "rest" and "jaw" in event.stops
    return rests or ("jaw" in event.closed_before and "jaw" not in event.closed_after)


def test_a_machine_without_whole_turns_says_so(e62: Mechanism) -> None:
    """One sentence with the engine's reason, in place of speeds that are not known."""
    fast = how_fast(replace(e62, drives=e62.drives[:1]))
    assert fast.limit is None
    (text,) = front_page(study_of(e62), Designer(650.0, BEFORE, (), fast)).fast
    assert text == (
        "That is not known, since its turns cannot be tabulated: the reduced engine needs one "
        "degree of freedom in flight, and 2 are left."
    )
