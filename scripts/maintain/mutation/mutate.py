"""How many random errors does no test notice?

    cd scripts/maintain/mutation
    python mutate.py record --map map.jsonl
    python mutate.py run --map map.jsonl --out results.jsonl --count 300 --seed 1

`record` runs the tests once and notes which statements run in each; `run` makes random errors in
a copy of the package, one at a time, and runs the tests that execute the changed statement until
one fails. Both go on where they stopped. Survivors with a reason stand in
mutation_survivors.toml. Status 1: there are survivors without one.
"""

from __future__ import annotations

import argparse
import compileall
import json
import math
import os
import shutil
import sys
import tempfile
import tomllib
from pathlib import Path

from random_errors.choice import ROOMS, Choice, drawn, recorded
from random_errors.processes import collected, copied, load_libraries, run_tests
from random_errors.recording import ByTest, instrument
from random_errors.sites import Mutation, compiles

ROOT = Path(__file__).resolve().parents[3]
REASONS = Path(__file__).with_name("mutation_survivors.toml")
# Other rooms' tests come last: they are long and seldom needed.
ORDER = (
    "tests/view", "tests/test_", "tests/mechanism", "tests/study", "tests/bench", "tests/reduced",
    "tests",
)  # fmt: skip
# They need a browser, or build the package.
SKIPPED = ("tests/browser", "tests/test_packaging.py")


def record(options: argparse.Namespace) -> int:
    """Run the tests file by file and note what runs in each test."""
    load_libraries()
    with tempfile.TemporaryDirectory(prefix="recorded-") as folder:
        home = Path(folder)
        copied(options.root, home)
        keys = instrument(home / "nipper_pin")
        if not options.map.exists():
            options.map.write_text(json.dumps(keys) + "\n", encoding="utf-8")
        with options.map.open(encoding="utf-8") as stream:
            if json.loads(next(stream)) != keys:
                sys.stderr.write(f"{options.map} is of another version: name a new file\n")
                return 2
            done = {json.loads(line).get("file") for line in stream}
        for file in _test_files(home, options.tests):
            if file not in done:
                plugin = ByTest(keys, home / "ran.bin", options.map)
                run = run_tests(home, [file], {}, (plugin,))
                with options.map.open("a", encoding="utf-8") as stream:
                    stream.write(json.dumps({"file": file}) + "\n")
                print(f"{file}: {run.tests} tests, {run.seconds:.0f} s {run.why}", flush=True)
    return 0


def _test_files(home: Path, wanted: list[str]) -> list[str]:
    files = [path.relative_to(home).as_posix() for path in (home / "tests").rglob("test_*.py")]
    files = [name for name in files if not name.startswith(SKIPPED)]
    if wanted:
        return sorted(name for name in files if name.startswith(tuple(wanted)))
    place = {name: [name.startswith(start) for start in ORDER].index(True) for name in files}
    return sorted(files, key=lambda name: (place[name], name))


class Trials:
    """Tries mutations in one copy of the checkout."""

    def __init__(self, root: Path, home: Path, maps: list[Path], budget: float) -> None:
        """Make the copy."""
        self._home = home
        self._package = home / "nipper_pin"
        self._budget = budget
        copied(root, home)
        compileall.compile_dir(self._package, quiet=2)
        compileall.compile_dir(home / "tests", quiet=2)
        self._choice = Choice(self._package, recorded(maps), collected(home))
        self._passing: dict[str, bool] = {}

    def draw(self, rooms: list[str], seed: int) -> list[Mutation]:
        """The mutations in the order in which they are tried."""
        return drawn(self._package, rooms, seed)

    def try_one(self, mutation: Mutation) -> dict[str, object] | None:
        """Apply it and run its tests; None where it leaves no other Python."""
        path = self._package / mutation.file
        kept = self._home / "kept.py"
        if not compiles(mutation, path.read_bytes()):
            return None
        tests, left_out = self._choice.tests(mutation, self._budget)
        result = {**mutation.record(), "tests": len(tests), "left_out": left_out}
        if not tests:
            return {**result, "caught": False, "by": "", "why": "no test executes it"}
        shutil.copy2(path, kept)
        machine_code = self._without_machine_code(mutation.file)
        try:
            path.write_bytes(mutation.applied(kept.read_bytes()))
            run = run_tests(self._home, tests, self._choice.limits(tests))
        finally:
            shutil.copy2(kept, path)
            self._with_machine_code(machine_code)
        caught = bool(run.failed) and (run.why != "fails" or self._passes(run.failed))
        why = run.why if caught else "all its tests pass"
        print(f"  {run.seconds:.0f} s, {run.tests} of {len(tests)} tests", flush=True)
        return {**result, "caught": caught, "by": run.failed, "why": why}

    def _passes(self, test: str) -> bool:
        """Whether a test that noticed a mutation passes without it."""
        if test not in self._passing:
            self._passing[test] = not run_tests(self._home, [test], {}).failed
        return self._passing[test]

    def _without_machine_code(self, file: str) -> dict[Path, bytes]:
        """Set machine code aside that is made from the file; it includes functions of others."""
        if not file.startswith("reduced/"):
            return {}
        found = [path for path in self._package.rglob("*.nb[ic]")]
        code = {path: path.read_bytes() for path in found}
        for path in found:
            path.unlink()
        return code

    def _with_machine_code(self, code: dict[Path, bytes]) -> None:
        if code:
            for path in self._package.rglob("*.nb[ic]"):
                path.unlink()
            for path, content in code.items():
                path.write_bytes(content)


def run(options: argparse.Namespace) -> int:
    """Try mutations until there are as many results as asked for."""
    load_libraries()
    done = _results(options.out)
    with tempfile.TemporaryDirectory(prefix="mutants-") as folder:
        home = Path(folder)
        trials = Trials(options.root, home, options.map, options.budget)
        mutations = trials.draw(options.rooms.split(","), options.seed)
        if options.survivors_of is not None:
            earlier = _results(options.survivors_of).values()
            again = {_lasting(item) for item in earlier if not item["caught"]}
            mutations = [item for item in mutations if _lasting(item.record()) in again]
        for mutation in mutations:
            if len(done) >= options.count:
                break
            if mutation.identity in done:
                continue
            result = trials.try_one(mutation)
            if result is None:
                continue
            done[mutation.identity] = result
            with options.out.open("a", encoding="utf-8") as stream:
                stream.write(json.dumps({**result, "identity": mutation.identity}) + "\n")
            print(_line(result), flush=True)
    return report(list(done.values()))


def _results(file: Path) -> dict[str, dict[str, object]]:
    if not file.exists():
        return {}
    lines = [json.loads(line) for line in file.read_text(encoding="utf-8").splitlines()]
    return {item["identity"]: item for item in lines}


def _lasting(item: dict[str, object]) -> tuple[object, ...]:
    """What a mutation keeps when its file changes elsewhere."""
    return tuple(item[name] for name in ("file", "scope", "key", "kind", "before", "after"))


def _line(result: dict[str, object]) -> str:
    word = "noticed " if result["caught"] else "SURVIVED"
    change = f"{result['before']!s:.60} -> {result['after']!s:.60}"
    place = f"{result['file']}:{result['line']} {result['kind']}"
    return f"{word} {place}: {change} ({result['by'] or result['why']})"


def report(results: list[dict[str, object]]) -> int:
    """Print the score with its interval, room by room, and the survivors."""
    reasons = tomllib.loads(REASONS.read_text(encoding="utf-8")) if REASONS.exists() else {}
    known = {
        (item["file"], item["before"], item["after"]): item["reason"]
        for item in reasons.get("survivor", ())
    }
    print("\n| room | mutations | noticed |\n| --- | --- | --- |")
    for room in sorted({str(item["file"]).split("/")[0] for item in results}):
        of_room = [item for item in results if str(item["file"]).startswith(f"{room}/")]
        print(f"| {room} | {len(of_room)} | {sum(bool(item['caught']) for item in of_room)} |")
    caught = sum(bool(item["caught"]) for item in results)
    low, high = interval(caught, len(results))
    print(f"\n{caught} of {len(results)} noticed: {100 * caught / max(len(results), 1):.1f} %,")
    print(f"between {100 * low:.1f} % and {100 * high:.1f} % with 95 % confidence")
    unexplained = 0
    for item in sorted(results, key=lambda item: (str(item["file"]), int(str(item["line"])))):
        if not item["caught"]:
            reason = known.get((item["file"], item["before"], item["after"]), "")
            unexplained += not reason
            print(_line(item) + (f"\n    {reason}" if reason else ""))
    return 1 if unexplained else 0


def interval(successes: int, trials: int) -> tuple[float, float]:
    """Wilson's interval of a share with 95 % confidence."""
    if not trials:
        return 0.0, 1.0
    z, share = 1.959964, successes / trials
    middle = (share + z * z / (2 * trials)) / (1 + z * z / trials)
    half = math.sqrt(share * (1 - share) / trials + z * z / (4 * trials**2)) * z
    half /= 1 + z * z / trials
    return middle - half, middle + half


def main() -> int:
    """Read the command line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    commands = parser.add_subparsers(dest="command", required=True)
    for name, task in (("record", record), ("run", run)):
        command = commands.add_parser(name)
        command.set_defaults(task=task)
        command.add_argument("--root", type=Path, default=ROOT, help="checkout to look at")
        if name == "record":
            command.add_argument("--map", type=Path, required=True)
            command.add_argument("tests", nargs="*", help="beginnings of files of tests")
        else:
            command.add_argument("--map", type=Path, required=True, action="append")
            command.add_argument("--out", type=Path, required=True, help="JSON lines")
            command.add_argument("--count", type=int, default=120)
            command.add_argument("--seed", type=int, default=1)
            command.add_argument("--rooms", default=",".join(ROOMS))
            command.add_argument(
                "--survivors-of", type=Path, metavar="FILE", help="those of earlier results alone"
            )
            command.add_argument(
                "--budget", type=float, default=60.0, help="seconds of tests for one mutation"
            )
    options = parser.parse_args()
    os.environ.setdefault("TMPDIR", tempfile.gettempdir())
    return int(options.task(options))


if __name__ == "__main__":
    sys.exit(main())
