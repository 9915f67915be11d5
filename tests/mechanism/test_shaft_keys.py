"""Numbers of a shaft are optional, and demanded by name where the shaft gives way."""

from __future__ import annotations

import pytest

from nipper_pin import Case, ModelError, simulate
from tests.small_machines import hinge, link, machine, slide

PARTS = [link("wheel"), hinge("wheel", "frame", "wheel")]
CRANK = {"joint": "wheel", "law": "constant_speed", "ratio": 1.0}


def _turn(drive: str, **keys: float) -> object:
    mechanism = machine(PARTS, 1, drives={"crank": {**CRANK, **keys}})
    return simulate(mechanism, Case(speed_rpm=60.0, window="cycle", drive=drive))


def test_a_held_drive_needs_none() -> None:
    _turn("held")


def test_an_inertial_drive_says_which_are_missing() -> None:
    with pytest.raises(ModelError) as caught:
        _turn("inertial", shaft_frequency_hz=10.0)
    assert "small.toml: drives.crank.reflected_inertia_kg_m2" in caught.value.message
    assert caught.value.message.endswith("missing: drives.crank.shaft_damping_ratio")
    _turn("inertial", shaft_frequency_hz=10.0, shaft_damping_ratio=0.0, reflected_inertia_kg_m2=1.0)


def test_a_slide_has_a_mass_in_place_of_an_inertia() -> None:
    parts = [link("ram"), slide("ram", "frame", "ram")]
    screw = {"joint": "ram", "law": "screw", "lead_mm_per_turn": 10.0}
    (drive,) = machine(parts, 1, drives={"screw": screw}).drives
    assert drive.missing == ("reflected_mass_kg", "shaft_frequency_hz", "shaft_damping_ratio")


def test_a_drive_without_a_law_is_told_the_laws() -> None:
    with pytest.raises(
        ModelError, match=r"drives.crank.law.*one of .*constant_speed.*screw, table"
    ):
        machine(PARTS, 1, drives={"crank": {"joint": "wheel", "ratio": 1.0}})


def test_stops_without_a_transition_stop_are_named() -> None:
    stops = {
        name: {"joint": "wheel", "restitution": 0.5, "side": name} for name in ("lower", "upper")
    }
    stops["upper"]["at_deg"] = 10.0  # type: ignore[assignment]
    told = r"transition_stop is missing: .* stops lower, upper; write .* = \"lower\" or \"upper\" "
    with pytest.raises(ModelError, match=told):
        machine(PARTS, 1, stops=stops, transition_stop="")
