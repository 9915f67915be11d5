"""Numbers that are typed with a unit of their own."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from nipper_pin import Mechanism, changed
from nipper_pin.cli import main
from nipper_pin.mechanism import number_of
from nipper_pin.mechanism.edit.overrides import by_path
from nipper_pin.written_units import number_in, unit_of_key


@pytest.mark.parametrize(
    ("text", "key", "number"),
    [
        ("9N/mm", "stiffness_N_per_m", 9000.0), ("9.5e3", "stiffness_N_per_m", 9500.0),
        (" 2 kN/m ", "stiffness_N_per_m", 2000.0), ("0.925cm", "preload_length_mm", 9.25),
        ("9.25mm", "preload_length_mm", 9.25), ("1in", "x_mm", 25.4),
        ("0.5rad", "preload_deg", math.degrees(0.5)), ("1r", "at_deg", 360.0),
        ("50 N mm/deg", "stiffness_N_m_per_rad", 0.05 * math.degrees(1.0)),
        ("50Nmm/deg", "stiffness_N_m_per_rad", 0.05 * math.degrees(1.0)),
        ("3e4 kg*mm^2", "reflected_inertia_kg_m2", 0.03), ("300 g", "mass_kg", 0.3),
        ("650rpm", "rated_speed_rpm", 650.0), ("60 deg/s", "speed_rpm", 10.0),
        ("9810 mm/s2", "gravity_m_s2", 9.81), ("20 g/cm", "density_kg_m", 2.0),
        ("4 N s2/m2", "c_N_s2_per_m2", 4.0), ("3 N ms/mm", "damping_N_s_per_m", 3.0),
        ("50Hz", "shaft_frequency_hz", 50.0), ("7 cm/r", "lead_mm_per_turn", 70.0),
        ("0.2", "restitution", 0.2),
    ],
)  # fmt: skip
def test_a_unit_is_taken_into_that_of_the_key(text: str, key: str, number: float) -> None:
    assert number_in(text, unit_of_key(key)) == pytest.approx(number, rel=4e-16)


def test_of_one_unit_no_digit_is_lost() -> None:
    for key in ("preload_length_mm", "preload_deg", "stiffness_N_m_per_rad", "rated_speed_rpm"):
        unit = unit_of_key(key)
        assert number_in(f"0.1234567890123456 {unit}", unit) == 0.1234567890123456


@pytest.mark.parametrize(
    ("path", "value", "read", "own", "number"),
    [
        ("springs.steeve.stiffness_N_per_mm", 9, 9.0, "springs.steeve.stiffness_N_per_m", 9000.0),
        (
            "springs.steeve.stiffness_N_per_mm",
            "8 kN/m",
            8.0,
            "springs.steeve.stiffness_N_per_m",
            8000.0,
        ),
        ("springs.steeve.preload_length_cm", "0.9", 0.9, "springs.steeve.preload_length_mm", 9.0),
    ],
)
def test_a_path_may_end_in_another_unit(
    e62: Mechanism, path: str, value: object, read: float, own: str, number: float
) -> None:
    """It is the number of the key that the table has, given and read; it counts once."""
    machine = changed(e62, {path: value})
    assert number_of(machine, own) == pytest.approx(number, rel=4e-16)
    assert number_of(machine, path) == pytest.approx(read, rel=4e-16)


def test_so_may_that_of_a_number_that_is_not_written(e62: Mechanism) -> None:
    found = by_path({"stops.jaw.at_rad": -0.01}, e62.description, "e62.toml")
    assert found == {"stops.jaw.at_deg": pytest.approx(math.degrees(-0.01), rel=4e-16)}


def test_commands_take_them(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    said = []
    for words in (
        ["--speed", "650", "--stiffness", "9500", "--set", "preload=9.25"],
        ["--speed", "650rpm", "--stiffness", "9.5N/mm", "--set", "preload=0.925cm"],
    ):
        assert main(["simulate", "e62", *words, "--json", "-"]) == 0
        said.append(capsys.readouterr().out)
    assert said[0].partition('"work"')[0] == said[1].partition('"work"')[0]
