"""Your own machine in twenty lines: a loose box on a table that shakes up and down.

The machine is a drawing: points in mm, bodies, joints, a drive and a stop. The table moves as a
sine of the shaft's angle. Where it falls faster than the box can follow, the box lifts off, flies
and bounces (the shaking table of textbooks on vibration).

Run: python scripts/build_a_machine.py [FOLDER]
"""

import sys

import nipper_pin as nip
from nipper_pin.mechanism.drawing import (
    Body,
    Drawing,
    Drive,
    Slide,
    Stop,
    drawn_mechanism,
    write_drawing,
)

SHAKER = Drawing(
    "shaker",
    "loose box on a shaking table",
    {"T": (0.0, 0.0), "B": (0.0, 30.0)},
    (
        Body("table", "T", mass_kg=5.0),
        Body("box", "B", mass_kg=0.5),
        # Height of the table over the frame, and gap of the box over the table.
        Slide("height", "frame", "table", at="T", along=(0.0, 1.0)),
        Slide("gap", "table", "box", at="B", along=(0.0, 1.0)),
        Drive("height", "fourier", {"sine_mm": [4.0]}),
        Stop("gap", restitution=0.3),
    ),
    touch_deg=0.0, start_deg=-90.0, speed_rpm=600.0, closed=("gap",),
)  # fmt: skip


def main(folder: str | None = None) -> nip.Solution:
    """Simulate two turns and print where the box flies.

    Args:
        folder: Where to write the model for the command, as a folder that does not exist yet.
    """
    if folder is not None:
        print(f"written for the command: {write_drawing(SHAKER, folder)}")
    case = nip.Case(speed_rpm=600.0, window=nip.Window.CYCLE, cycles=2)
    solution = nip.simulate(drawn_mechanism(SHAKER), case)
    for phase in solution.phases:
        lies = "lies on the table" if "gap" in phase.closed else "flies"
        print(f"{1e3 * phase.t_start:9.5f} to {1e3 * phase.t_end:9.5f} ms: the box {lies}")
    for hit in solution.collisions:
        print(f"{1e3 * hit.t:9.5f} ms: it lands with {-hit.approach_rate:.6f} m/s")
    return solution


if __name__ == "__main__":
    main(*sys.argv[1:2])
