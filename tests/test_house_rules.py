"""Rules of CONTRIBUTING.md that ruff does not know: comments, tolerances, what tests import."""

from __future__ import annotations

import ast
import io
import re
import tokenize
from collections.abc import Iterator
from functools import cache
from graphlib import TopologicalSorter
from importlib import import_module
from importlib.util import find_spec
from inspect import ismodule
from pathlib import Path

import pytest

import nipper_pin

ROOT = Path(__file__).resolve().parents[1]
PACKAGE, JUDGES = ROOT / "nipper_pin", ROOT / "benchmarks"
COMMENT, FILE = 2, 500


@cache
def text_of(path: Path) -> str:
    return path.read_text(encoding="utf-8")


@cache
def tree_of(path: Path) -> ast.Module:
    return ast.parse(text_of(path))


def modules(*rooms: str) -> list[Path]:
    return [path for room in rooms for path in sorted((ROOT / room).rglob("*.py"))]


def with_small(paths: list[Path]) -> list[Path]:
    """Those that write a number below 0.1, or the spacing of doubles."""
    return [path for path in paths if re.search(r"e-\d|0\.0|eps", text_of(path), re.IGNORECASE)]


# Sizes.


def long_comments(text: str) -> Iterator[int]:
    """First line of each block of comments that is too long."""
    if not re.search(r"(^[ \t]*#.*\n){3}", text, re.MULTILINE):
        return
    tokens = [
        token
        for token in tokenize.generate_tokens(io.StringIO(text).readline)
        if token.type == tokenize.COMMENT and token.line.lstrip()[0] == "#"
    ]
    for first, last in zip(tokens, tokens[COMMENT:], strict=False):
        if last.start[0] - first.start[0] == COMMENT:
            yield first.start[0]


def test_comments_have_at_most_two_lines() -> None:
    planted = 'x = """\n# a\n# b\n# c\n"""\n# a\n# b\n\nx = 1  # a\n# b\n# c\nif x:\n    # d\n'
    assert [*long_comments(planted)] == []
    assert [*long_comments(f"{planted}    # e\n    # f\n    x = 2\n")] == [13]
    everywhere = modules("nipper_pin", "benchmarks", "scripts", "tests")
    assert [(path, line) for path in everywhere for line in long_comments(text_of(path))] == []


def test_files_are_short() -> None:
    package = modules("nipper_pin", "benchmarks")
    assert [path for path in package if text_of(path).count("\n") > FILE] == []


# Modules go one way.


def imported(path: Path) -> Iterator[str]:
    """What a file imports from beside it, in functions and for annotations too."""
    package = path.relative_to(ROOT).parts[:-1]
    for node in ast.walk(tree_of(path)):
        if isinstance(node, ast.ImportFrom) and node.level:
            found = ".".join([*package[: len(package) - node.level + 1], node.module or ""])
            yield from (found, *(f"{found.rstrip('.')}.{item.name}" for item in node.names))


def test_no_circle_of_imports() -> None:
    names = {
        ".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__"): path
        for path in modules("nipper_pin")
    }
    graph = {name: names.keys() & {*imported(path)} - {name} for name, path in names.items()}
    TopologicalSorter(graph).prepare()


# Tolerances stand in one place, each with a unit and a reason.

ROOMS = [f"nipper_pin/{room}" for room in ("mechanism", "dynamics", "hybrid", "reduced", "study")]
OF_JUDGES = JUDGES / "tolerances.py"
SETTINGS = {
    "study/levers.py": "_KINDS",  # steps, each for a unit of the document
    "benchmarks/paper/counts.py": "LOWEST, HIGHEST",  # range of thresholds
    "benchmarks/paper/fixed_step.py": "STEPS_S",  # steps of the schemes that are compared
    "benchmarks/run_time/reduced_work.py": "_TOLERANCES",
    "benchmarks/run_time/turns.py": "_TOLERANCES",
    "benchmarks/run_time/work_precision.py": "TOLERANCES, QUICK_TOLERANCES",
    "study/sweep/plan.py": "_TRANSITIONS, _TURNS",  # run times
}
"""Small numbers that are no tolerances, by module."""


def is_small(node: ast.AST) -> bool:
    """A positive float below 1e-3, or the spacing of doubles."""
    if isinstance(node, ast.Constant):
        return type(node.value) is float and 0 < node.value < 1e-3
    name = getattr(node, "attr", getattr(node, "id", ""))
    return name.strip("_").lower() in {"eps", "epsilon"}


def constants(tree: ast.Module) -> str:
    """Names of a module that are given small numbers."""
    found = [
        ast.unparse(node).partition(" = ")[0]
        for node in tree.body
        if isinstance(node, ast.Assign | ast.AnnAssign) and node.value
        if any(map(is_small, ast.walk(node.value)))
    ]
    return ", ".join(found)


def test_no_other_module_of_these_rooms_holds_a_tolerance() -> None:
    """Neither as a constant nor in a comparison of a solver or study."""
    planted = "A = 1e-9\nB, C = 12, 1e-4\nD: float = 8.0 * _EPS\nE = 2 * np.finfo(float).eps\nF = 2"
    assert constants(ast.parse(planted)) == "A, B, C, D: float, E"
    found = {
        path.relative_to(ROOT).as_posix().removeprefix("nipper_pin/"): constants(tree_of(path))
        for path in with_small(modules(*ROOMS, "benchmarks"))
        if path != OF_JUDGES
    }
    assert {name: text for name, text in found.items() if text} == SETTINGS
    compared = [
        ast.unparse(node)
        for path in with_small(modules(*ROOMS))
        for node in ast.walk(tree_of(path))
        if isinstance(node, ast.Compare)
        if any(isinstance(part, ast.Constant) and is_small(part) for part in ast.walk(node))
    ]
    assert compared == []


@pytest.mark.parametrize(
    "module", [*(PACKAGE / "tolerances").glob("[a-z]*.py"), OF_JUDGES], ids=lambda path: path.stem
)
def test_each_tolerance_has_a_unit_and_a_derivation(module: Path) -> None:
    """A text below each: its unit in brackets, what it decides, and where it comes from."""
    body = tree_of(module).body
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
    assert [
        path
        for path in modules("benchmarks")
        if "tolerances" in text_of(path)
        for node in ast.walk(tree_of(path))
        if isinstance(node, ast.ImportFrom) and not node.level
        if "tolerances" in {*str(node.module).split("."), *(item.name for item in node.names)}
    ] == []


# Tests ask for what a redesign keeps: public names, what docs name, fronts of rooms.

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
"""What stays inside, because it is judged part by part, each against closed forms of its own."""
MOST_OTHERS = 300


def is_front(module: str, name: str) -> bool:
    """A module at the top, or an `__init__` that has the name and does not hide it."""
    if find_spec(f"nipper_pin.{module}") is None:
        return False
    found = import_module(f"nipper_pin.{module}")
    offered = getattr(found, "__all__", vars(found))
    return "." not in module or (
        hasattr(found, "__path__") and name in offered and not ismodule(getattr(found, name))
    )


def test_inner_names_are_few() -> None:
    pages = [*ROOT.glob("docs/*.md"), ROOT / "README.md"]
    named = set(re.findall(r"(?<=\bnipper_pin\.)[\w.]*\w", " ".join(map(text_of, pages))))
    others, parts = set(), set()
    imports = re.compile(r"^ *from nipper_pin\.(\S+) import (?:\(([^)]+)\)|(.+))$", re.MULTILINE)
    asked = {
        (path.relative_to(ROOT).as_posix(), module, word.split()[0])
        for path in modules("tests")
        for module, *names in imports.findall(text_of(path))
        for word in "".join(names).partition("#")[0].split(",")
        if word.strip()
    }
    for path, module, name in asked:
        if name in nipper_pin.__all__ or {module, f"{module}.{name}"} & named:
            continue
        part = next((part for part in INSIDE if f"{module}.".startswith(f"{part}.")), None)
        if part is not None:
            parts.add(part)
        elif not is_front(module, name):
            others.add((path, f"{module}.{name}"))
    assert parts == set(INSIDE)
    assert len(others) <= MOST_OTHERS, sorted(others)
