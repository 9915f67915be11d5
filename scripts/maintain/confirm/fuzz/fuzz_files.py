"""Coverage-guided fuzzing of everything that the package reads from other people.

    python scripts/maintain/confirm/fuzz/fuzz_files.py all --inputs 100000
    python scripts/maintain/confirm/fuzz/fuzz_files.py urdf toml --inputs 5000 --out /tmp/found

Needs atheris (extra `fuzz`). Every target of tests/fuzz/targets.py runs in a process of its own,
with at most 1 GB of memory and 10 s an input; inputs are shared out by what each costs. The table
says how many inputs there were, what they reached, what was worst, and how many failed. Inputs
that failed are left in --out, and belong into the corpus when their failure is mended.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[3]
MEMORY_MB, TIME_S, LENGTH = 1024, 10, 65_536
SHARES = {
    "urdf": 10, "toml": 6, "csv": 8, "measured": 18, "case": 5, "npz": 4, "parquet": 14,
    "plan": 6, "study": 2, "live": 27,
}  # fmt: skip
"""Parts of the inputs that each target gets [%]; a study takes forty times as long as a message."""
_STATE = re.compile(r"cov: (\d+) ft: (\d+) corp: (\d+)")
Row = dict[str, object]


def main() -> int:
    """Run the targets one after the other; 1 if anything failed."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("targets", nargs="+", choices=[*SHARES, "all"], metavar="TARGET",
                        help=f"all, or some of {', '.join(SHARES)}")  # fmt: skip
    parser.add_argument("--inputs", type=int, default=100_000, help="inputs in all")
    parser.add_argument("--corpus", type=Path, default=ROOT / "tests" / "fuzz" / "corpus")
    parser.add_argument("--seed", type=int, default=1, help="of the fuzzer")
    parser.add_argument("--out", type=Path, help="folder of what is found (default: a new one)")
    options = parser.parse_args()
    names = list(SHARES) if "all" in options.targets else options.targets
    out = options.out or Path(tempfile.mkdtemp(prefix="fuzz_"))
    whole = sum(SHARES[name] for name in names)
    rows = []
    for name in names:
        count = -(-options.inputs * SHARES[name] // whole)
        rows.append(fuzzed(name, count, options.corpus / name, out / name, options.seed))
        print(json.dumps(rows[-1]), flush=True)
    print(f"\n{table(rows)}\n\nfailures and inputs that were found are in {out}")
    return int(any(row["failures"] for row in rows))


def fuzzed(name: str, count: int, corpus: Path, folder: Path, seed: int) -> Row:
    """Fuzz one target in a process of its own.

    Args:
        name: Name of the target.
        count: Inputs.
        corpus: Folder of the inputs to start from.
        folder: Folder for failures, and for inputs that reach something new.
        seed: Of the fuzzer.

    Returns:
        What came of it.
    """
    found = folder / "found"
    found.mkdir(parents=True, exist_ok=True)
    limits = [f"-rss_limit_mb={MEMORY_MB}", f"-timeout={TIME_S}", f"-max_len={LENGTH}"]
    command = [
        sys.executable, str(HERE / "worker.py"), name, str(folder), str(found), str(corpus),
        *limits, f"-runs={count}", f"-seed={seed}", f"-artifact_prefix={folder}/failure_",
        "-print_final_stats=1", "-len_control=0", "-mutate_depth=1",
    ]  # fmt: skip
    began = time.monotonic()
    with (folder / "log.txt").open("w", encoding="utf-8") as log:
        done = subprocess.run(command, stdout=log, stderr=log, env=os.environ, check=False)
    text = (folder / "log.txt").read_text(encoding="utf-8", errors="replace")
    states = _STATE.findall(text) or [("0", "0", "0")]
    record: dict[str, Any] = {"inputs": 0, "failures": {}}
    if (folder / "record.json").is_file():
        record = json.loads((folder / "record.json").read_text(encoding="utf-8"))
    failures = record.pop("failures")
    # Too slow, too large, or an end without a word: the fuzzer itself stops there.
    ended = {"process": done.returncode} if done.returncode else {}
    return {
        "target": name,
        **record,
        "edges": int(states[-1][0]),
        "features": int(states[-1][1]),
        "corpus": int(states[-1][2]),
        "wall_s": round(time.monotonic() - began),
        "failures": {**failures, **ended},
    }


def table(rows: list[Row]) -> str:
    """The rows below one another, and their sum.

    Args:
        rows: What came of the targets.
    """
    keys = [key for key in rows[0] if key != "failures"]
    lines = [[*keys, "failures"]]
    lines += [[*(str(row[key]) for key in keys), str(len(dict(row["failures"])))] for row in rows]  # type: ignore[call-overload]
    total = sum(int(str(row["inputs"])) for row in rows)
    lines.append(["all", str(total)])
    widths = [max(len(line[place]) for line in lines[:-1]) for place in range(len(lines[0]))]
    return "\n".join(
        "  ".join(word.rjust(width) for word, width in zip(line, widths, strict=False))
        for line in lines
    )


if __name__ == "__main__":
    sys.exit(main())
