"""Numbers of one machine from its filmed rebounds: restitution, preload and timing.

identify_camera_measured.csv holds heights and times of rebounds at three speeds, each with its
standard deviation; identify_camera.toml says which numbers of the model are unknown, and between
which bounds they lie. docs/identification.md tells how to film your own machine.

Run: python scripts/identify_a_machine.py [PROBLEM.toml]
"""

from __future__ import annotations

import sys
from pathlib import Path

import nipper_pin as nip

PROBLEM = Path(__file__).with_name("identify_camera.toml")


def main(problem: str | Path = PROBLEM) -> dict[str, float]:
    """Fit the model to the measurements and print what they determine.

    Args:
        problem: The problem file.

    Returns:
        The numbers found, by path: what ``nip.load`` takes as its second argument.
    """
    fit = nip.identify(problem, starts=2)
    print(fit.goodness.sentence())
    fit.check()  # raises an error if the measurements contradict the fit
    for number in fit.objective.problem.parameters:
        deviation = fit.known.deviations[number.path] * (number.high - number.low)
        print(f"{number.path}: {fit.values[number.path]:.6g} +- {deviation:.2g}")
    # The fitted machine is a model like any other: how does it bounce at a speed not filmed?
    machine = nip.load("e62", fit.values)
    hit = nip.simulate(machine, nip.Case(speed_rpm=400.0)).collisions[0]
    print(f"first rebound at 400 r/min, not measured: {1e3 * (hit.rebound_time or 0.0):.4f} ms")
    return fit.values


# The workers import this file again: without the line below each would start a fit itself.
if __name__ == "__main__":
    main(*sys.argv[1:2])
