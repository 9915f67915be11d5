"""Random turns of the reduced engine, judged by the direct one within both stated errors.

    python scripts/maintain/confirm/judge_turns.py [--geometries 30] [--cases 100] [--seed 23]
        [--first 0] [--workers 1] [--folder FOLDER]

Geometries are the E62 with moved points and other masses and timing, the other combers likewise,
and machines of the gallery; cases have their own speed (0.4 to 4.4 times the rated one),
restitutions of all stops, spring rates and preloads, and one to three turns. A line for each
geometry, then the counts and the reasons of refusals. A case is left to round-off if a stated error
is a hundredth of the rate before, two events are closer than their errors, or the direct engine
contradicts itself at a finer tolerance. The status is 1 if a case is wrong. The folder keeps the
geometries that are done: the same command goes on where it was stopped.
"""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
from collections import Counter
from multiprocessing import get_context
from pathlib import Path
from typing import Any

from judged_turns.machines import geometry, setting
from judged_turns.verdicts import Verdict, judged


def main() -> int:
    """Judge the geometries of the command line."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--geometries", type=int, default=30)
    parser.add_argument("--cases", type=int, default=100)
    parser.add_argument("--seed", type=int, default=23)
    parser.add_argument("--first", type=int, default=0, help="number of the first geometry")
    parser.add_argument("--workers", type=int, default=1, help="processes")
    parser.add_argument("--folder", type=Path, default=Path("build/judged_turns"))
    given = parser.parse_args()
    given.folder.mkdir(parents=True, exist_ok=True)
    path = given.folder / f"seed_{given.seed}.jsonl"
    done = [json.loads(line) for line in path.read_text().splitlines()] if path.exists() else []
    known = {row["number"] for row in done if row["cases"] == given.cases}
    numbers = range(given.first, given.first + given.geometries)
    left = [(given.seed, number, given.cases) for number in numbers if number not in known]
    with get_context("spawn").Pool(given.workers, maxtasksperchild=1) as pool:
        for row in pool.imap_unordered(_geometry, left):
            with path.open("a") as file:
                file.write(json.dumps(row) + "\n")
            done.append(row)
    return _report([row for row in done if row["number"] in numbers])


def _geometry(given: tuple[int, int, int]) -> dict[str, Any]:
    """All cases of one geometry."""
    seed, number, cases = given
    with tempfile.TemporaryDirectory() as home:
        machine = geometry(seed, number, Path(home))
        base = machine.mechanism()
        rows = [(case, *judged(machine, base, setting(seed, number, case, machine)))
                for case in range(cases)]  # fmt: skip
    return {"number": number, "label": machine.label, "cases": cases, "rows": rows}


def _report(done: list[dict[str, Any]]) -> int:
    """Print a line for each geometry, counts and reasons; 1 if a case is wrong."""
    counts: Counter[str] = Counter()
    reasons: Counter[str] = Counter()
    for row in sorted(done, key=lambda row: row["number"]):
        own = Counter(verdict for _, verdict, _ in row["rows"])
        counts += own
        why = Counter(why[:90] for _, verdict, why in row["rows"] if verdict == Verdict.REFUSED)
        reasons += why
        told = ", ".join(f"{count} {verdict}" for verdict, count in sorted(own.items()))
        print(f"{row['number']:>3} {row['label']:<20} {told} {dict(why) or ''}")
        for case, verdict, why_so in row["rows"]:
            if verdict in (Verdict.WRONG, Verdict.DIRECT, Verdict.ROUND_OFF):
                print(f"    case {case} {verdict}: {why_so}")
    print(", ".join(f"{count} {verdict}" for verdict, count in sorted(counts.items())))
    for why_refused, count in reasons.most_common():
        print(f"  refused: {count} {why_refused}")
    return int(counts[Verdict.WRONG] > 0)


if __name__ == "__main__":
    sys.exit(main())
