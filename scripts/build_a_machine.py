"""Your own machine in twenty lines: a loose box on a table that shakes up and down.

The machine is a drawing: points in mm, bodies, joints, a drive and a stop. The table moves as a
sine of the shaft's angle. Where it falls faster than the box can follow, the box lifts off, flies
and bounces (the shaking table of textbooks on vibration).

Run: python scripts/build_a_machine.py [FOLDER]
"""

import sys
import tomllib

import nipper_pin as nip

# As in a file, for which nip.Drawing.load("shaker.toml") or nip.load("shaker.toml") stands.
SHAKER = nip.Drawing(
    tomllib.loads("""
        title = "loose box on a shaking table"
        speed_rpm = 600.0
        start_deg = -90.0
        closed = ["gap"]
        joints = [
            # Height of the table over the frame, and gap of the box over the table.
            { slide = "height", parent = "frame", child = "table", at = "T", along = [0, 1] },
            { slide = "gap", parent = "table", child = "box", at = "B", along = [0, 1] },
        ]
        points = { T = [0.0, 0.0], B = [0.0, 30.0] }
        [bodies]
        table = { points = "T", mass_kg = 5.0 }
        box = { points = "B", mass_kg = 0.5 }
        [drives]
        height = { joint = "height", law = "fourier", sine_mm = [4.0] }
        [stops]
        gap = { joint = "gap", restitution = 0.3 }
    """),
    "shaker",
)


def main(folder: str | None = None) -> nip.Solution:
    """Simulate two turns and print where the box flies.

    Args:
        folder: Where to write the model for the command, as a folder that does not exist yet.
    """
    if folder is not None:
        print(f"written for the command: {SHAKER.save(folder)}")
    case = nip.Case(speed_rpm=600.0, window=nip.Window.CYCLE, cycles=2)
    solution = nip.simulate(SHAKER.mechanism(), case)
    for phase in solution.phases:
        lies = "lies on the table" if "gap" in phase.closed else "flies"
        print(f"{1e3 * phase.t_start:9.5f} to {1e3 * phase.t_end:9.5f} ms: the box {lies}")
    for hit in solution.collisions:
        print(f"{1e3 * hit.t:9.5f} ms: it lands with {-hit.approach_rate:.6f} m/s")
    return solution


if __name__ == "__main__":
    main(*sys.argv[1:2])
