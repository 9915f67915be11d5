"""Tolerances stand in one module, each with a unit and a reason."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest

PACKAGE = Path(__file__).parents[1] / "nipper_pin"
ROOMS = ("mechanism", "dynamics", "hybrid", "reduced")


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
    modules = [each for room in ROOMS for each in (PACKAGE / room).rglob("*.py")]
    assert len(modules) > 50
    found = {str(each): constants(each.read_text(encoding="utf-8")) for each in modules}
    assert {name: lines for name, lines in found.items() if lines} == {}


def test_each_tolerance_has_a_unit_and_a_reason() -> None:
    body = ast.parse((PACKAGE / "tolerances.py").read_text(encoding="utf-8")).body
    places = [i for i, node in enumerate(body) if isinstance(node, ast.Assign)]
    assert len(places) > 40
    for place in places:
        text = body[place + 1]
        assert isinstance(text, ast.Expr)
        assert isinstance(text.value, ast.Constant)
        assert str(text.value.value).startswith("[")
