"""Does the memory of the process grow over ten thousand runs?

Each run is a transition with another speed, its tables and checks asked for; every tenth one loads
the model again. The resident size is printed on the way.

    python scripts/maintain/measure/measure_memory.py [--runs 10000]
"""

from __future__ import annotations

import argparse
from pathlib import Path

from nipper_pin import Case, load, record, simulate

_PAGE = 4096


def resident_mb() -> float:
    """Resident size of this process [MB], as Linux counts it."""
    pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[1])
    return pages * _PAGE / 1e6


def main() -> None:
    """Run and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--runs", type=int, default=10_000, metavar="N")
    runs = parser.parse_args().runs
    mechanism = load("e62")
    print("runs   resident MB")
    for number in range(runs + 1):
        if number % max(runs // 10, 1) == 0:
            print(f"{number:6d} {resident_mb():9.1f}")
        if number % 10 == 0:
            mechanism = load("e62", {"stops.jaw.restitution": 0.1 + 0.3 * number / (runs + 1)})
        record(simulate(mechanism, Case(speed_rpm=400.0 + 300.0 * number / (runs + 1))))


if __name__ == "__main__":
    main()
