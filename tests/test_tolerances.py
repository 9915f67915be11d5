"""Tolerances stand in one place, each with a unit and a reason."""

from __future__ import annotations

import ast
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PACKAGE = ROOT / "nipper_pin"
MODULES = sorted((PACKAGE / "tolerances").glob("[a-z]*.py"))
JUDGES = ROOT / "benchmarks/tolerances.py"
ROOMS = [PACKAGE / room for room in ("mechanism", "dynamics", "hybrid", "reduced", "study")]
SETTINGS = {
    "study/steps.py": "_KINDS",  # steps of differences, each for a unit of the document
    "benchmarks/paper/counts.py": "LOWEST, HIGHEST",  # range of thresholds
    "benchmarks/paper/fixed_step.py": "STEPS_S",  # steps of the schemes that are compared
    "benchmarks/run_time/reduced_work.py": "_TOLERANCES",
    "benchmarks/run_time/turns.py": "_TOLERANCES",
    "benchmarks/run_time/work_precision.py": "TOLERANCES, QUICK_TOLERANCES",
    "study/sweep/plan.py": "_TRANSITIONS, _TURNS",  # run times
}
"""Small numbers that are no tolerances, by module."""


def small(value: ast.expr) -> bool:
    """Whether an expression holds a positive float below 1e-3 or the spacing of doubles."""
    for node in ast.walk(value):
        if isinstance(node, ast.Constant) and type(node.value) is float and 0 < node.value < 1e-3:
            return True
        name = getattr(node, "attr", getattr(node, "id", ""))
        if name.strip("_").lower() in {"eps", "epsilon"}:
            return True
    return False


def constants(source: str) -> list[str]:
    found = []
    for node in ast.parse(source).body:
        if isinstance(node, ast.Assign | ast.AnnAssign) and node.value and small(node.value):
            found.append(ast.unparse(node))
    return found


@pytest.mark.parametrize(
    "line", ["A = 1e-9", "A, B = 12, 1e-4", "A: float = 8.0 * _EPS", "A = 2 * np.finfo(float).eps"]
)
def test_a_tolerance_is_recognised(line: str) -> None:
    assert constants(line)
    assert not constants("A = 0.5\nB = 12\nC = 1e9")


def test_no_other_module_of_these_rooms_defines_a_tolerance() -> None:
    modules = [each for room in (*ROOMS, JUDGES.parent) for each in room.rglob("*.py")]
    modules.remove(JUDGES)
    assert len(modules) > 50
    found = {
        each.relative_to(ROOT).as_posix().removeprefix("nipper_pin/"): constants(
            each.read_text(encoding="utf-8")
        )
        for each in modules
    }
    names = {name: ", ".join(line.partition(" = ")[0] for line in found[name]) for name in found}
    assert {name: text for name, text in names.items() if text} == SETTINGS


def test_no_comparison_of_a_solver_or_study_holds_a_small_number() -> None:
    found = []
    for module in [each for room in ROOMS for each in room.rglob("*.py")]:
        for node in ast.walk(ast.parse(module.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Compare) and any(
                type(getattr(part, "value", None)) is float and 0 < part.value < 1e-3  # type: ignore[attr-defined]
                for part in ast.walk(node)
            ):
                found.append(f"{module.name}: {ast.unparse(node)}")
    assert found == []


@pytest.mark.parametrize("module", [*MODULES, JUDGES], ids=lambda path: path.stem)
def test_each_tolerance_has_a_unit_and_a_derivation(module: Path) -> None:
    """A text below each: its unit in brackets, what it decides, and where it comes from."""
    body = ast.parse(module.read_text(encoding="utf-8")).body
    places = [place for place, node in enumerate(body) if isinstance(node, ast.Assign)]
    assert len(places) > 15
    for place in places:
        name, text = ast.unparse(body[place]), ast.literal_eval(ast.unparse(body[place + 1]))
        found = re.fullmatch(r"\[[^]]+\] (.+?)\. (?=[A-Z`])(.+)", " ".join(text.split()))
        assert found, name
        decides, derivation = found.groups()
        assert len(decides.split()) > 3, name
        assert len(derivation.split()) > 1, name


def test_judges_share_no_tolerance_with_what_they_judge() -> None:
    """Neither by their module of tolerances nor by reading another one."""
    shared = {}
    for file in JUDGES.parent.rglob("*.py"):
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ImportFrom):
                module, names = node.module or "", {item.name for item in node.names}
                inner = "tolerances" in f"{module}.{'.'.join(names)}".split(".")
                if inner and not node.level:
                    shared[file.name] = module
    assert shared == {}
