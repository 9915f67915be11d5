"""Which test notices which error? Deliberate mistakes in a copy of the package, one at a time.

    python scripts/maintain/mutation/mutate_engine.py [NAME ...]

Each mutation replaces one text of the engine, found exactly once, in a copy; the tests run there
until the first fails. A mutation that no test notices is a test that is missing. The table in
docs/mutations.md is the output of this script; status 1 says that a mutation survived or that
its text is no longer in the engine.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from engine_errors import MUTATIONS, Mutation

ROOT = Path(__file__).resolve().parents[3]
# The fast ones first: most errors do not get far.
TESTS = (
    "tests/mechanism",
    "tests/dynamics",
    "tests/hybrid",
    "tests/verification/test_four_bar.py",
    "tests/verification/test_springs_and_dampers.py",
    "tests/verification/test_springs_in_other_forms.py",
    "tests/verification/test_bouncing_mass.py",
    "tests/verification/test_impact_identities.py",
    "tests/verification/test_reactions.py",
    "tests/verification/test_inertial_drive.py",
    "tests/verification/test_published.py",
    "tests/verification/test_e62_reference.py",
    "tests/fuzz/test_models.py",
)
_FAILED = re.compile(r"^(FAILED|ERROR) (\S+)", re.MULTILINE)


def copied(source: Path, home: Path) -> None:
    """Copy what the tests need; the models are only read, so a link will do."""
    for name in ("nipper_pin", "tests", "scripts", "docs"):
        leave = shutil.ignore_patterns("__pycache__", "*.nbi", "*.nbc")
        shutil.copytree(source / name, home / name, ignore=leave)
    for name in ("pyproject.toml", "README.md"):
        shutil.copy(source / name, home / name)
    (home / "models").symlink_to(ROOT / "models")


def first_failure(home: Path) -> str:
    """Run the tests in the copy; the first that fails, or an empty text."""
    environment = {**os.environ, "PYTHONPATH": str(home), "PYTHONDONTWRITEBYTECODE": "1"}
    try:
        done = subprocess.run(
            [sys.executable, "-m", "pytest", "-x", "-q", "-p", "no:cacheprovider", *TESTS],
            cwd=home, env=environment, capture_output=True, text=True, check=False, timeout=900.0,
        )  # fmt: skip
    except subprocess.TimeoutExpired:
        return "the tests do not end"
    found = _FAILED.search(done.stdout)
    if done.returncode == 0:
        return ""
    if not found:
        return f"pytest ended with status {done.returncode}"
    # pytest says ERROR where a fixture fails: the run that the test needs cannot be simulated.
    return f"`{found[2]}`" + (", whose runs cannot be simulated" if found[1] == "ERROR" else "")


def noticed(mutation: Mutation, original: Path) -> tuple[bool, str]:
    """Apply one mutation to a fresh copy and run the tests there.

    Args:
        mutation: The mutation.
        original: The package and its tests as they were when the script began.

    Returns:
        Whether a test noticed it, and which; or why it could not be tried.
    """
    with tempfile.TemporaryDirectory(prefix="mutant-") as folder:
        home = Path(folder)
        copied(original, home)
        file = home / "nipper_pin" / mutation.file
        text = file.read_text(encoding="utf-8")
        if text.count(mutation.right) != 1:
            return False, f"not applied: its text stands there {text.count(mutation.right)} times"
        file.write_text(text.replace(mutation.right, mutation.wrong), encoding="utf-8")
        failure = first_failure(home)
        return bool(failure), failure or "**no test**"


def main(names: list[str]) -> int:
    """Try the named mutations, or all, and print a table in Markdown."""
    known = {mutation.name for mutation in MUTATIONS}
    unknown = sorted(set(names) - known)
    if unknown:
        sys.stderr.write(f"no mutation {', '.join(unknown)}; known: {', '.join(sorted(known))}\n")
        return 2
    with tempfile.TemporaryDirectory(prefix="original-") as folder:
        original = Path(folder)
        copied(ROOT, original)
        failure = first_failure(original)
        if failure:
            sys.stderr.write(f"without any mutation, {failure} fails: mend that first\n")
            return 2
        print("| mutation | what it does | noticed by |\n| --- | --- | --- |", flush=True)
        survivors = 0
        for mutation in MUTATIONS:
            if not names or mutation.name in names:
                caught, by = noticed(mutation, original)
                survivors += not caught
                print(f"| {mutation.name} | {mutation.meaning} | {by} |", flush=True)
    return 1 if survivors else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
