"""What `check` finds: timing, conditioning, clearances; overlaps put there on purpose."""

from __future__ import annotations

from pathlib import Path

import pytest

from nipper_pin import Case, Mechanism, Window, load, simulate
from nipper_pin.study.check import check_model
from nipper_pin.study.interference import clearances

MODELS = Path(__file__).parents[2] / "models"


def test_timing_of_the_class(e62: Mechanism) -> None:
    """Closing at index 34 and opening between 7 and 9.5, as this class of machine is set."""
    report = check_model(e62, 450.0)
    assert report.closing_index == pytest.approx(34.0, abs=0.3)
    assert report.opening_index is not None
    assert 7.0 < report.opening_index < 9.5
    assert report.releases == ()
    assert report.interferences == ()


def test_steeve_release_is_reported(e62: Mechanism) -> None:
    """The stop force is zero where the steeve lets go, and the report says so."""
    report = check_model(e62, 650.0)
    ((stop, index),) = report.releases
    assert stop == "steeve"
    smallest = report.stop_force["steeve"]
    # The force is located to round-off of some 100 N.
    assert abs(smallest.value) < 1e-9
    assert smallest.index == pytest.approx(index, abs=1e-9)


def test_an_overlap_is_found_with_its_index(tmp_path: Path) -> None:
    """A needle longer by half a millimetre than the clearance of the lip strikes it."""
    folder = tmp_path / "longer"
    folder.mkdir()
    text = (MODELS / "e62" / "e62.urdf").read_text()
    assert 'radius="0.0625" length="0.2"' in text
    text = text.replace('radius="0.0625" length="0.2"', 'radius="0.063" length="0.2"')
    (folder / "longer.urdf").write_text(text)
    (folder / "longer.toml").write_text((MODELS / "e62" / "e62.toml").read_text())
    report = check_model(load(folder), 450.0)
    worst = report.interferences[0]
    assert {worst.link_a, worst.link_b} == {"frame", "bottom_nipper"}
    assert {worst.shape_a, worst.shape_b} == {"cylinder_drum", "bottom_lip"}
    # The clearance of the model at hand, less what the drum has grown by.
    clear = check_model(load("e62"), 450.0).clearances
    (before,) = (
        item.distance_m
        for item in clear
        if {item.shape_a, item.shape_b} == {"cylinder_drum", "bottom_lip"}
    )
    assert worst.distance_m == pytest.approx(before - 0.0005, abs=2e-6)
    assert worst.index == pytest.approx(39.7, abs=0.3)


def test_lips_meet_and_do_not_overlap(e62: Mechanism) -> None:
    """The lips touch in phase 2 to the tolerance of the distance computation."""
    solution = simulate(e62, Case(speed_rpm=450.0, window=Window.CYCLE))
    (lips,) = (item for item in clearances(solution) if item.may_touch)
    assert {lips.shape_a, lips.shape_b} == {"bottom_lip", "top_lip"}
    assert abs(lips.distance_m) < 1e-6
    assert not lips.interferes
