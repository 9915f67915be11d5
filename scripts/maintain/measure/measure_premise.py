"""Random transitions: is a premise that is called true always true?

    python scripts/maintain/measure/measure_premise.py --cases 1000 --seed 1

For each case both engines say whether the machine arrives at the touch as a transition assumes, and
two whole turns are simulated. A transition that differs from that of the second turn by more than
their stated errors must not be called true; exit status 1 if one is.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence

from benchmarks.premises import Judged, draw, judged

_NAMES = {True: "true", False: "false", None: "null"}


def main() -> int:
    """Measure, and print one table."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--cases", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    found: list[Judged] = []
    tried = 0
    for mechanism, drawn in draw(options.cases, options.seed):
        found += judged(mechanism, drawn)
        tried += len(drawn)
    print(f"{tried} cases, seed {options.seed}")
    print(
        f"{'engine':8} {'called':6} {'cases':>6} {'differ':>7} {'agree':>6} {'worst agreeing':>15}"
    )
    for engine in ("direct", "reduced"):
        for holds, name in _NAMES.items():
            some = [item for item in found if item.engine == engine and item.holds is holds]
            print(_row(engine, name, some))
    wrong = [item for item in found if item.wrong]
    for item in wrong:
        print(f"wrongly called true by {item.engine}, {item.apart:.3g} times stated: {item.drawn}")
    return 1 if wrong else 0


def _row(engine: str, name: str, some: Sequence[Judged]) -> str:
    agree = [item.apart for item in some if item.apart <= 1.0]
    worst = f"{max(agree):.2g}" if agree else "-"
    differ = len(some) - len(agree)
    return f"{engine:8} {name:6} {len(some):6d} {differ:7d} {len(agree):6d} {worst:>15}"


if __name__ == "__main__":
    sys.exit(main())
