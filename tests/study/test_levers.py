"""Levers: the strongest numbers of the nipper, changed by one unit, and in words.

Those of the E62 come from runs of changed models here, which the levers' own code does not make: a
lever that is weaker than another, or a changed model that differs, would be seen.
"""

from __future__ import annotations

import re

import pytest

from nipper_pin import Case, Mechanism, load, simulate
from nipper_pin.study.identify import working_cycle
from nipper_pin.study.levers import Bounce, Lever, levers
from nipper_pin.study.sensitivity import every_path, sensitivities

BEFORE = Bounce(4e-3, 8e-3, 120.0)
AFTER = Bounce(3e-3, 6e-3, 126.0)


def test_a_lever_in_words() -> None:
    """What is changed, from which value to which in the unit people read, and what comes of it."""
    lever = Lever("springs.steeve.preload_length_mm", "mm", 11.0, 12.0, BEFORE, AFTER)
    assert str(lever) == (
        "preload length of spring steeve 1 mm more (11 to 12 mm): first rebound -25.0 %, time to "
        "rest -25.0 %, clamping force +5.0 %"
    )
    bare = Lever("stops.jaw.restitution", "%", 0.2, 0.198, BEFORE, BEFORE)
    assert str(bare).startswith("restitution of stop jaw 1 % less (0.2 to 0.198): first rebound +0")


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
    assert Lever(path, unit, old, new, BEFORE, AFTER).words == words


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
    known = levers(e62, found)
    assert [lever.path.rpartition(".")[0] for lever in known] == parts
    for lever in known:
        assert lever.new == pytest.approx(tried[lever.path][1], rel=1e-5)
        first, duration = amplitude(lever.path, lever.new)
        assert lever.amplitude_change == pytest.approx(first / here - 1.0, abs=1e-9)
        assert lever.before.duration_s == pytest.approx(run.transitions[0].duration, rel=1e-9)
        assert lever.after.duration_s == pytest.approx(duration, rel=1e-9)
        told = re.findall(r"[-+][\d.]+(?= %)", str(lever))
        assert float(told[0]) == pytest.approx(100.0 * lever.amplitude_change, abs=0.06)
        clamping = working_cycle(load("e62", {lever.path: lever.new}), 650.0).clamping_force
        assert lever.after.clamping_force_N == pytest.approx(clamping, rel=1e-9)
