"""A film of the bouncing jaw for a report: one GIF, in side view, slowed down around each impact.

Run: python scripts/film_a_run.py [FILE.gif]
     FILE.html writes a page instead, in which the machine is turned and the film is stopped.
"""

from __future__ import annotations

import sys
from pathlib import Path

import nipper_pin as nip


def main(file: str | Path = "rebounds.gif") -> None:
    """Simulate a transition and write its film.

    Args:
        file: The file, ``NAME.gif`` or ``NAME.html``.
    """
    solution = nip.simulate(nip.load("e62"), nip.Case(speed_rpm=650.0))
    # Rebounds are thousandths of a radian: the gap is drawn ten times as large, and playback is a
    # thousand times slower around impacts. Forces and motion stay as simulated.
    written = nip.view(solution, file, slow=1000.0)
    print(f"{written}: {Path(file).stat().st_size / 1e3:.0f} kB")
    # What the film shows, as numbers.
    lost = sum(hit.energy_lost for hit in solution.collisions)
    for hit in solution.collisions:
        share = 100.0 * hit.energy_lost / lost
        print(f"impact {hit.number} at {1e3 * hit.t:.5f} ms takes {share:.4f} % of the energy")


if __name__ == "__main__":
    main(*sys.argv[1:2])
