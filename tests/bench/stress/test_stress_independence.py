"""The judge of the campaign shares no code with what it judges: read off its sources.

Solutions, events and panels are what is judged, so their types are known to it. Bounds, forces and
states are found by its own code, whose equations are those of the text of a model; another engine
is run by files that judge nothing.
"""

from __future__ import annotations

import ast
import re
from importlib.util import resolve_name
from pathlib import Path

import pytest

import benchmarks.stress as stress

HOME = Path(stress.__file__).parent
# Of the files that judge one runs the other engine; all they may import of the campaign are such.
OTHER_ENGINE = HOME / "checks" / "engines.py"
JUDGES = re.compile(r"benchmarks\.(tolerances|stress\.(checks|mechanics|observations)\b.*)")
JUDGING = [*HOME.glob("checks/*.py"), *HOME.glob("mechanics/*.py"), HOME / "observations.py"]
# The door of the package opens every room.
ENGINES = re.compile(r"nipper_pin(\.(hybrid|dynamics|reduced)\b.*)?|pinocchio\b.*")
RESULTS = {
    "nipper_pin.hybrid": {
        "Collision", "Event", "EventError", "EventKind", "Outcome", "Segment", "Solution",
    },
    "nipper_pin.hybrid.motion.panel": {"Panel"},
}  # fmt: skip
# What the engine computes accelerations, impulses and states with.
COMPUTING = {
    "closed_velocity", "constraint_set", "determined_accelerations",
    "forcing", "impulse_response", "interpolate", "interpolate_at", "prescribe", "refined",
    "respond",
}  # fmt: skip


def foreign(text: str, package: str) -> list[tuple[str, str]]:
    """What is imported of engines beyond the types of results, or of what judges nothing."""
    found: list[tuple[str, str]] = []
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.ImportFrom):
            module = resolve_name("." * node.level + (node.module or ""), package)
            found += [(module, item.name) for item in node.names]
        elif isinstance(node, ast.Import):
            found += [(item.name, "") for item in node.names]
    return [
        (module, name)
        for module, name in found
        if (ENGINES.fullmatch(module) and name not in RESULTS.get(module, ()))
        or (module.startswith("benchmarks") and not JUDGES.fullmatch(module))
        or module.endswith(".engines")
    ]


@pytest.mark.parametrize("path", sorted({*JUDGING} - {OTHER_ENGINE}), ids=lambda path: path.stem)
def test_the_judge_imports_nothing_of_the_engines_but_results(path: Path) -> None:
    text = path.read_text(encoding="utf-8")
    assert foreign(text, f"benchmarks.stress.{path.parent.name}".removesuffix(".stress")) == []
    used = [node for node in ast.walk(ast.parse(text)) if isinstance(node, ast.Attribute)]
    assert not {node.attr for node in used} & COMPUTING
    # The judge's own are asked of its own equations.
    of = {ast.unparse(node.value) for node in used if node.attr == "accelerations"}
    assert of <= {"equations"}


@pytest.mark.parametrize(
    ("line", "module", "name"),
    [
        ("from nipper_pin.hybrid.motion.noise_floor import roughness",
         "nipper_pin.hybrid.motion.noise_floor", "roughness"),
        ("from nipper_pin import simulate", "nipper_pin", "simulate"),
        ("import nipper_pin.reduced", "nipper_pin.reduced", ""),
        ("import pinocchio as pin", "pinocchio", ""),
        ("from ..judging import judge", "benchmarks.stress.judging", "judge"),
        ("from .engines import engines_agree", "benchmarks.stress.checks.engines", "engines_agree"),
    ],
)  # fmt: skip
def test_a_bound_of_the_engine_would_be_found(line: str, module: str, name: str) -> None:
    """Also where it is imported within a function."""
    assert foreign(f"def f():\n    {line}\n", "benchmarks.stress.checks") == [(module, name)]
