"""Stated errors of the quantities of turns, against a solution in 80-bit arithmetic."""

from __future__ import annotations

import math
import sys
from pathlib import Path

import numpy as np
import pytest

from nipper_pin import load
from nipper_pin.reduced.turns import turn_quantities

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "reference"))

from held_turn import HeldTurn, quantities

pytestmark = pytest.mark.skipif(
    np.finfo(np.longdouble).eps > 1e-18, reason="numpy.longdouble has no 80 bits on this machine"
)
# Speed, restitutions of jaw and steeve, stiffness, preload, share of the range of the force.
TURNS = [
    ("733.3", "0.37", "0.11", "8123.5", "9.7", 0.4),
    ("1085.0", "0.08", "0.52", "10650.0", "13.1", 0.9),
    ("318.9", "0.61", "0.23", "6021.0", "6.4", 0.0),
]


@pytest.mark.parametrize(("speed", "jaw", "steeve", "k", "preload", "share"), TURNS)
def test_quantities_within_their_stated_errors(
    speed: str, jaw: str, steeve: str, k: str, preload: str, share: float
) -> None:
    """At a coarse, a usual and a fine tolerance; none is stated wastefully wide at all of them."""
    true = quantities(
        HeldTurn({"speed_rpm": speed, "jaw_restitution": jaw, "stop_restitution": steeve,
                  "stiffness_N_per_m": k, "preload_length_mm": preload}), share,
    )  # fmt: skip
    mechanism = load("e62", {
        "stops.jaw.restitution": float(jaw), "stops.steeve.restitution": float(steeve),
        "springs.steeve.stiffness_N_per_m": float(k),
        "springs.steeve.preload_length_mm": float(preload),
    })  # fmt: skip
    lever = math.hypot(0.0818, 0.0364)
    rate = np.longdouble(speed) * 8 * np.arctan(np.longdouble(1)) / 60
    ratios: dict[str, list[float]] = {}
    for tolerance in (1e-4, 1e-8, 1e-12):
        found = turn_quantities(mechanism, speed_rpm=float(speed), tolerance=tolerance,
                                least_force=true["level"])  # fmt: skip
        values = [
            ("closed", found.closed_at, found.closed_error, true["closed_at"], rate),
            ("rests", found.rests_at, found.rests_error, true["rests_at"], rate),
            ("lost", found.lost_at, found.lost_error, true["lost_at"], rate),
            ("opened", found.opened_at, found.opened_error, true["opened_at"], rate),
            ("clamped", found.clamped, found.clamped_error, true["clamped"], rate),
            ("least", found.least_force, found.least_force_error, true["least_force"], 1),
            ("most", found.most_force, found.most_force_error, true["most_force"], 1),
            ("gap", found.largest_gap, found.gap_error, true["largest_gap"], 1),
            ("energy", found.energy_lost, found.energy_lost_error, true["energy_lost"], 1),
        ]
        for place, (stop, by) in enumerate((("jaw", 1.0 / lever), ("steeve", 1.0))):
            for key in ("impulse_sum", "largest_impulse"):
                value, error = (getattr(found, f"{key}{end}")[:, place] for end in ("", "_error"))
                values.append((f"{key} {stop}", value, error, true[f"{key}_{stop}"], by))
        for what, value, error, wanted, scale in values:
            if wanted is None:
                assert math.isnan(value[0]), what
                continue
            ratio = abs(value[0] - wanted * scale) / error[0]
            assert ratio <= 1.0, (what, tolerance)
            ratios.setdefault(what, []).append(float(ratio))
    assert all(max(row) > 1e-5 for row in ratios.values()), ratios
