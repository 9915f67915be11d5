"""The judge of the campaign shares no code with what it judges: read off its sources.

Solutions, events and panels are what is judged, so their types are known to it. Bounds, forces and
states are found by its own code, whose equations are those of the text of a model; another engine
is run by files that judge nothing.
"""

from __future__ import annotations

import ast
from pathlib import Path

import pytest

import benchmarks.stress as stress

FOLDER = Path(stress.__file__).resolve().parent
CHECKOUT = FOLDER.parents[1]
# Those that run engines, hold what is run, or write it.
RUNNING = {"__init__", "campaign", "engines", "files", "judging", "small_machines", "space"}
RESULTS = {
    "": {"Collision", "Event", "EventError", "EventKind", "Outcome", "Segment", "Solution"},
    "motion.panel": {"Panel"},
}
DYNAMICS = {"system": {"System"}}
# What the engine computes accelerations, impulses and states with.
COMPUTING = {
    "closed_velocity", "constraint_set", "determined_accelerations",
    "forcing", "impulse_response", "interpolate", "interpolate_at", "prescribe", "refined",
    "respond",
}  # fmt: skip


def judging() -> list[Path]:
    """All files of the campaign that neither run nor draw: those that `invariants` comes to."""
    found, new = set(), {FOLDER / "checks/invariants.py", FOLDER / "checks/agreement.py"}
    while new:
        path = new.pop()
        found.add(path)
        files = {
            CHECKOUT.joinpath(*module.split(".")).with_suffix(".py") for module, _ in imports(path)
        }
        new |= {file for file in files if FOLDER in file.parents and file.exists()} - found
    return sorted(found)


def imports(path: Path) -> list[tuple[str, str]]:
    """Modules by their whole names, and the names imported, also within functions."""
    folders = path.resolve().relative_to(CHECKOUT).parts[:-1] if CHECKOUT in path.parents else ()
    found = []
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.ImportFrom):
            above = folders[: len(folders) + 1 - node.level] if node.level else ()
            module = ".".join((*above, *filter(None, [node.module])))
            found += [(module, item.name) for item in node.names]
        elif isinstance(node, ast.Import):
            found += [(item.name, "") for item in node.names]
    return found


def foreign(path: Path) -> list[tuple[str, str]]:
    """What a file imports of the engines beyond the types of results."""
    allowed = {"hybrid": RESULTS, "dynamics": DYNAMICS, "reduced": {}}
    found = []
    for module, name in imports(path):
        package, _, inside = module.partition(".")
        room, _, rest = inside.partition(".")
        if package != "nipper_pin":
            continue
        # The door of the package opens every room.
        if not room or (room in allowed and name not in allowed[room].get(rest, set())):
            found.append((module, name))
    return found


def test_files_that_judge_are_found() -> None:
    names = {path.stem for path in judging()}
    assert names >= {"agreement", "applied_forces", "elements", "equations", "flights", "impacts",
                     "invariants", "observations", "planar_tree", "rebounds"}  # fmt: skip
    assert not names & RUNNING


@pytest.mark.parametrize("path", judging(), ids=lambda path: path.stem)
def test_the_judge_imports_nothing_of_the_engines_but_results(path: Path) -> None:
    assert foreign(path) == []
    assert "pinocchio" not in {module for module, _ in imports(path)}
    used = [n for n in ast.walk(ast.parse(path.read_text())) if isinstance(n, ast.Attribute)]
    assert not {node.attr for node in used} & COMPUTING
    # The judge's own are asked of its own equations.
    of = {ast.unparse(node.value) for node in used if node.attr == "accelerations"}
    assert of <= {"equations"}


def test_a_bound_of_the_engine_would_be_found(tmp_path: Path) -> None:
    """Also where it is imported within a function."""
    planted = tmp_path / "planted.py"
    for line, module, name in (
        ("from nipper_pin.hybrid.motion.noise_floor import roughness",
         "nipper_pin.hybrid.motion.noise_floor", "roughness"),
        ("from nipper_pin import simulate", "nipper_pin", "simulate"),
        ("import nipper_pin.reduced", "nipper_pin.reduced", ""),
    ):  # fmt: skip
        planted.write_text(f"def f():\n    {line}\n")
        assert foreign(planted) == [(module, name)]
