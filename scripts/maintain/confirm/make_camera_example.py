"""A machine is filmed that does not exist: the measurements of the example of an identification.

The E62 model with other numbers (TRUTH) closes its jaw in front of a simulated camera. Means over
several closings are written with the random errors that such a camera has, drawn from a seed:
`nipper-pin identify scripts/identify_camera.toml` has to find TRUTH again, within what the errors
allow. A test does it.

Run: python scripts/maintain/confirm/make_camera_example.py [FILE]
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

import nipper_pin as nip

TRUTH = {
    "stops.jaw.restitution": 0.235,
    "springs.steeve.preload_length_mm": 9.4,
    "cylinder.angle_at_touch_deg": 168.0,
}
SPEEDS_RPM = (350.0, 450.0, 550.0)
# At 20,000 pictures a second both ends of a rebound are rounded to 50 us: sigma 50 us / sqrt(12)
# each. The gap between the lips, 90 mm from the hinge, is read to 5 um in one picture.
CLOSINGS = 12
TIME_SIGMA_S = 50e-6 * np.sqrt(2.0 / 12.0) / np.sqrt(CLOSINGS)
ANGLE_SIGMA_RAD = 5e-6 / 0.0895 / np.sqrt(CLOSINGS)
SEED = 1


def measurements(seed: int) -> list[tuple[float, str, float, float]]:
    """Return what the camera saw: speed [r/min], quantity, value and sigma [rad or s].

    Args:
        seed: Seed of the random errors.
    """
    machine = nip.load("e62", TRUTH)
    errors = np.random.default_rng(seed)
    rows = []
    for speed in SPEEDS_RPM:
        first, second = nip.simulate(machine, nip.Case(speed_rpm=speed)).collisions[:2]
        seen = (
            ("rebound_amplitude_1", first.rebound_amplitude, ANGLE_SIGMA_RAD),
            ("rebound_time_s_1", first.rebound_time, TIME_SIGMA_S),
            ("rebound_amplitude_2", second.rebound_amplitude, ANGLE_SIGMA_RAD),
            ("rebound_time_s_2", second.rebound_time, TIME_SIGMA_S),
        )
        for quantity, exact, sigma in seen:
            if exact is None:
                message = "the jaw does not rebound twice; change TRUTH"
                raise nip.SimulationError(message)
            rows.append((speed, quantity, exact + sigma * errors.standard_normal(), sigma))
    return rows


def main(file: str | Path) -> None:
    """Write the measurements as CSV.

    Args:
        file: The file.
    """
    lines = ["speed_rpm,quantity,value,sigma"]
    for speed, quantity, value, sigma in measurements(SEED):
        # Digits beyond a tenth of a sigma say nothing.
        lines.append(f"{speed:g},{quantity},{value:.7f},{sigma:.1e}")
    Path(file).write_text("\n".join(lines) + "\n", encoding="utf-8")
    print(f"{file}: {len(lines) - 1} measurements")


if __name__ == "__main__":
    main(
        sys.argv[1]
        if len(sys.argv) > 1
        else Path(__file__).parents[2] / "identify_camera_measured.csv"
    )
