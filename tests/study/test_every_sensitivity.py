"""Every number of a sensitivity, from rows and laws that are made up."""

from __future__ import annotations

import math

import numpy as np
import pytest

from nipper_pin.errors import SimulationError
from nipper_pin.mechanism import Mechanism
from nipper_pin.study import sensitivity
from nipper_pin.study.identify.problem.geometry import Sources
from nipper_pin.study.sensitivity import Sensitivities, Sensitivity


def row(path: str, unit: str, *per: float, off: float = 0.0) -> Sensitivity:
    values = np.array(per)
    control = values - np.array([0.0, off, 0.0])
    return Sensitivity(path=path, value=3.0, unit=unit, per=values, control=control)


def made_up(*rows: Sensitivity, holds: bool | None = True) -> Sensitivities:
    return Sensitivities(
        model="mine", stop="peg", speed_rpm=612.5, premise_holds=holds, amplitude_rad=2.346e-3,
        transition_time_s=6.789e-3, clamping_force_N=147.26, rows=rows,
    )  # fmt: skip


def test_doubt() -> None:
    """From a thousandth of the largest effect on, or of 0.1 % where all effects are smaller."""
    for per, off, doubtful in (
        ((5.0, 1.0, 1.0), 0.0049, False), ((5.0, 1.0, 1.0), 0.0051, True),
        ((0.01, 0.0, 0.0), 0.99e-4, False), ((0.01, 0.0, 0.0), 1.01e-4, True),
        ((5.0, 1.0, math.nan), 0.0, True),
    ):  # fmt: skip
        one = row("x", "%", *per, off=off)
        assert one.doubtful is doubtful
        assert row("x", "%", *(-value for value in per), off=-off).doubtful is doubtful
        if not math.isnan(per[2]):
            assert one.disagreement == pytest.approx(off)


def test_order_of_sensitivities() -> None:
    """By the size of what a quantity does, whatever its sign."""
    found = made_up(row("a", "mm", 1.0, -5.0, 2.0), row("b", "mm", -4.0, 3.0, 0.5),
                    row("c", "mm", 2.0, 0.25, -3.0))  # fmt: skip
    order = {"rebound_amplitude_1": "bca", "duration_s": "abc", "clamping_force_N": "cab"}
    assert {
        name: "".join(item.path for item in found.ranked(name)) for name in sensitivity.QUANTITIES
    } == order


def test_record_of_sensitivities() -> None:
    one = row("points.jaw.z_mm", "mm", 0.5, 5.0, -0.02, off=0.75)
    assert made_up(one, holds=None).record() == {
        "model": "mine", "speed_rpm": 612.5, "premise_holds": None,
        "rebound_amplitude_1": 2.346e-3, "duration_s": 6.789e-3, "mean_clamping_force_N": 147.26,
        "percent_per_unit": [
            {
                "path": "points.jaw.z_mm", "value": 3.0, "unit": "mm",
                "rebound_amplitude_1": 0.5, "duration_s": 5.0, "clamping_force_N": -0.02,
                "disagreement_of_two_ways": pytest.approx(0.75), "doubtful": True,
            }
        ],
    }  # fmt: skip


def test_rows_of_laws(monkeypatch: pytest.MonkeyPatch, e62: Mechanism) -> None:
    """Quantities that are powers of a number: their exponents are the percentages.

    Richardson's extrapolation of powers up to the third is exact but for round-off, 1e-10; the
    control is off by h^2 / 6 of the third derivative, with h = 1e-3 of the value: (n-1)(n-2) / 6.
    """
    asked: list[tuple[float, bool]] = []

    def law(mechanism: Mechanism, speed: float, *, true: bool, **_: object) -> np.ndarray:
        asked.append((speed, true))
        k = mechanism.springs[0].stiffness / 9000.0
        return np.array([3.0 * k**3, 0.5 * speed**2 / k, 100.0 * speed])

    monkeypatch.setattr(sensitivity, "_direct", law)
    monkeypatch.setattr(sensitivity, "_other", law)
    done: list[tuple[int, int]] = []
    paths = ("springs.steeve.stiffness_N_per_m", "speed_rpm")
    found = sensitivity.sensitivities(
        e62, 500.0, paths, progress=lambda *counts: done.append(counts)
    )
    assert done == [(1, 2), (2, 2)]
    assert {true for _, true in asked} == {False}
    assert (found.model, found.speed_rpm, found.premise_holds) == ("e62", 500.0, True)
    assert found.amplitude_rad == pytest.approx(3.0)
    assert found.transition_time_s == pytest.approx(0.5 * 500.0**2)
    assert found.clamping_force_N == pytest.approx(5e4)
    stiffness, speed = found.rows
    assert (stiffness.path, stiffness.value, stiffness.unit) == (paths[0], 9000.0, "%")
    assert (speed.path, speed.value, speed.unit) == ("speed_rpm", 500.0, "%")
    assert stiffness.per == pytest.approx([3.0, -1.0, 0.0], abs=1e-8)
    assert stiffness.control == pytest.approx([3.0 + 1e-6, -1.0 - 1e-6, 0.0], abs=1e-8)
    assert speed.per == pytest.approx([0.0, 2.0, 1.0], abs=1e-8)
    monkeypatch.setattr(sensitivity, "_direct", lambda *_, **__: np.array([1.0, 0.0, 2.0]))
    with pytest.raises(SimulationError, match=r"500 r/min: duration_s is zero") as caught:
        sensitivity.sensitivities(e62, 500.0, paths)
    assert caught.value.evidence["quantities"] == ["duration_s"]


def test_the_numbers_that_are_asked_for(e62: Mechanism) -> None:
    """All of the document but those that nothing sees, and the dimensions of pins and links."""
    paths = sensitivity.every_path(e62)
    assert paths[0] == "speed_rpm"
    document = Sources.of(e62).document
    tables = [path for path in paths[1:] if not path.startswith(("points.", "links."))]
    order = ["cylinder", "drives", "springs", "dampers", "stops"]
    places = [order.index(path.split(".")[0]) for path in tables]
    assert places == sorted(places)
    assert {"cylinder.angle_at_touch_deg", "drives.tension.ratio", "stops.jaw.restitution"} <= {
        *tables
    }
    for path in tables:
        value: object = document
        for step in path.split("."):
            value = value[step]  # type: ignore[index]
        assert isinstance(value, int | float)
    for unseen in ("rated_speed_rpm", "reference_index", "reflected_inertia_kg_m2"):
        assert not any(path.endswith(unseen) for path in paths)
    assert {path for path in paths if path.startswith("points.eccentric_pin.")} == {
        "points.eccentric_pin.radius_mm", "points.eccentric_pin.angle_deg",
    }  # fmt: skip
    assert {path for path in paths if path.startswith("points.jaw.")} == {
        "points.jaw.x_mm", "points.jaw.z_mm",
    }  # fmt: skip
    ofone = [path for path in paths if path.startswith("links.top_nipper.")]
    assert ofone == [
        f"links.top_nipper.{key}" for key in ("mass_kg", "gyration_mm", "com_x_mm", "com_z_mm")
    ]
