"""The calmest nipper inside limits: least first rebound for a given clamping force.

optimise_rebound.toml frees the preload of the spring, the gear ratio and the angle of the
eccentric, and sets limits of clamping force, timing, stop force, jaw opening and stroke. This is a
short search of two descents; `nipper-pin optimise` does six, checks them by a global search and
adds the front of rebound against clamping force (docs/optimisation.md).

Run: python scripts/optimise_a_design.py [PROBLEM.toml]
"""

from __future__ import annotations

import math
import sys
from pathlib import Path

import nipper_pin as nip

PROBLEM = Path(__file__).with_name("optimise_rebound.toml")


def main(problem: str | Path = PROBLEM) -> dict[str, float]:
    """Search, print the design beside the model's own, and simulate it.

    Args:
        problem: The problem file.

    Returns:
        The numbers found, by path: what ``nip.load`` takes as its second argument.
    """
    optimum = nip.optimise(problem, starts=2, check=False, points=2)
    numbers = dict(optimum.best.numbers)
    for path, value in numbers.items():
        print(f"{path} = {value:.6g}")
    designs = {"the model as it is": optimum.before, "the design found": optimum.best}
    for name, design in designs.items():
        if design is not None:
            rebound = math.degrees(design.values["rebound_amplitude_1"])
            force = design.values["clamping_force_N"]
            print(f"{name}: first rebound {rebound:.6f} deg, clamping force {force:.4f} N")
    # Every design was held against simulated whole turns; a contradiction would be said here.
    print(optimum.contradiction or "simulated turns confirm the design")
    return numbers


# The workers import this file again: without the line below each would start a search itself.
if __name__ == "__main__":
    main(*sys.argv[1:2])
