"""Tests ask for what a redesign keeps: public names, what docs name, fronts of rooms."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from importlib import import_module
from inspect import ismodule
from pathlib import Path

import nipper_pin

ROOT = Path(__file__).resolve().parents[1]
TESTS = sorted((ROOT / "tests").rglob("*.py"))
# What stays inside, because it is judged part by part: each against closed forms of its own.
INSIDE = {
    "dynamics": "one impact, one system of equations, one shaft",
    "hybrid.contact": "which stops stay closed; limits of bounce series",
    "hybrid.error_estimate": "linear maps of flights, impacts and sequences",
    "hybrid.event_location": "roots of functions that are known",
    "hybrid.motion": "panels, series and defects of motions that are known",
    "hybrid.run": "starts, phases and series of one run",
    "reduced.kernels": "compiled flights and series of equations that are known",
    "reduced.tables": "Chebyshev series of functions that are known",
    "tolerances": "numbers that limits of tests are derived from",
}
MOST_OTHERS = 300


def imports(path: Path) -> Iterator[tuple[str, str]]:
    """Module and name of all that a file imports from rooms of the package."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("nipper_pin."):
            for alias in node.names:
                yield str(node.module).removeprefix("nipper_pin."), alias.name


def is_front(module: str, name: str) -> bool:
    """A module at the top, or an `__init__` that has the name and does not hide it."""
    found = import_module(f"nipper_pin.{module}")
    offered = getattr(found, "__all__", vars(found))
    return "." not in module or (
        hasattr(found, "__path__") and name in offered and not ismodule(getattr(found, name))
    )


def inside(module: str) -> str | None:
    """The part of the list that a module belongs to."""
    return next((part for part in INSIDE if f"{module}.".startswith(f"{part}.")), None)


def test_inner_names_are_few() -> None:
    pages = [*ROOT.glob("docs/*.md"), ROOT / "README.md"]
    text = " ".join(page.read_text(encoding="utf-8") for page in pages)
    named = set(re.findall(r"(?<=\bnipper_pin\.)[\w.]*\w", text))
    others, parts = set(), set()
    for path in TESTS:
        for module, name in imports(path):
            if is_front(module, name) or name in nipper_pin.__all__:
                continue
            if {module, f"{module}.{name}"} & named:
                continue
            if (part := inside(module)) is not None:
                parts.add(part)
            else:
                others.add((path.relative_to(ROOT).as_posix(), f"{module}.{name}"))
    assert parts == set(INSIDE)
    assert len(others) <= MOST_OTHERS, sorted(others)
