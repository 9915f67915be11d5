"""Rules of CONTRIBUTING.md that a program can check: comments, docstrings, sizes."""

import ast
import inspect
import io
import re
import tokenize
from collections.abc import Iterator
from pathlib import Path

import pytest

import nipper_pin

ROOT = Path(__file__).resolve().parents[1]
PACKAGE = [
    path for room in ("nipper_pin", "benchmarks") for path in sorted((ROOT / room).rglob("*.py"))
]
OTHERS = [path for room in ("scripts", "tests") for path in sorted((ROOT / room).rglob("*.py"))]
EVERY = [*PACKAGE, *OTHERS]
COMMENT, LINES, PARAMETERS, FILE = 2, 60, 7, 500

# What remains above the limits. An entry that no longer exceeds its limit must go.
LONG = {
    "benchmarks/peers/mujoco_shell.py prepare",
    "reduced/kernels/flight.py flight",
    "reduced/kernels/kernel.py _transition",
    "reduced/kernels/panel.py solve_panel",
    "reduced/kernels/turn.py follow",
}
MANY = {
    "dynamics/impact.py _still",
    "dynamics/multipliers.py multipliers",
    "mechanism/drawing/compound.py flap",
    "mechanism/drawing/visuals.py _box",
    "mechanism/drawing/visuals.py _shape",
    "reduced/kernels/arrival_check.py in_flight",
    "reduced/kernels/arrival_check.py landed",
    "reduced/kernels/flight.py _ballistic",
    "reduced/kernels/flight.py _zero",
    "reduced/kernels/flight.py flight",
    "reduced/kernels/flight_errors.py flight_errors",
    "reduced/kernels/kernel.py _clamps",
    "reduced/kernels/kernel.py _flown",
    "reduced/kernels/kernel.py _solved",
    "reduced/kernels/kernel.py _transition",
    "reduced/kernels/kernel.py run_batch",
    "reduced/kernels/kernel.py run_one",
    "reduced/kernels/panel.py _defect",
    "reduced/kernels/panel.py _sweep",
    "reduced/kernels/panel.py solve_panel",
    "reduced/kernels/series.py settles",
    "reduced/kernels/turn.py follow",
    "reduced/kernels/turn_charts.py seen_by",
    "reduced/kernels/turn_events.py collide",
    "reduced/kernels/turn_events.py errors_after",
    "reduced/kernels/turn_quantities.py run_turns",
    "reduced/kernels/turn_quantities.py summed",
    "reduced/kernels/turn_torques.py run_torques",
    "reduced/transition.py transition",
    "reduced/transition.py transitions",
    "reduced/turns/peak_torques.py turn_torques",
    "reduced/turns/quantities.py turn_quantities",
    "reduced/turns/turn.py turns",
    "study/transitions/engine_choice.py transition_table",
    "study/turns/engine_choice.py turn_table",
}
LARGE: set[str] = set()


def comments(text: str) -> Iterator[tuple[int, int]]:
    """First line and number of lines of each block of comments."""
    lines = text.splitlines()
    rows = [
        token.start[0]
        for token in tokenize.generate_tokens(io.StringIO(text).readline)
        if token.type == tokenize.COMMENT and lines[token.start[0] - 1].lstrip()[0] == "#"
    ]
    first = previous = -1
    for row in [*rows, len(lines) + 2]:
        if row != previous + 1:
            if first > 0:
                yield first, previous - first + 1
            first = row
        previous = row


def undocumented(tree: ast.AST) -> Iterator[str]:
    """Public classes, functions and methods without a docstring."""
    for node in ast.iter_child_nodes(tree):
        if isinstance(node, ast.ClassDef | ast.FunctionDef) and not node.name.startswith("_"):
            if ast.get_docstring(node) is None:
                yield node.name
            if isinstance(node, ast.ClassDef):
                yield from undocumented(node)


def functions(text: str) -> Iterator[tuple[str, int, int]]:
    """Name, lines and parameters of each function; self and cls do not count."""
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.FunctionDef):
            every = node.args
            names = [item.arg for item in (*every.posonlyargs, *every.args, *every.kwonlyargs)]
            yield (
                node.name,
                node.end_lineno - node.lineno + 1,
                len([name for name in names if name not in {"self", "cls"}]),
            )


def beyond(place: int, limit: int) -> set[str]:
    """Functions of the package whose lines (1) or parameters (2) exceed a limit."""
    return {
        f"{path.relative_to(ROOT).as_posix().removeprefix('nipper_pin/')} {item[0]}"
        for path in PACKAGE
        for item in functions(path.read_text(encoding="utf-8"))
        if item[place] > limit
    }


def test_comments_have_at_most_two_lines() -> None:
    long = [
        f"{path.relative_to(ROOT)}:{line}: {count} lines"
        for path in EVERY
        for line, count in comments(path.read_text(encoding="utf-8"))
        if count > COMMENT
    ]
    assert not long


@pytest.mark.parametrize("name", nipper_pin.__all__)
def test_arguments_of_the_reference_are_described(name: str) -> None:
    """All of a function or method of the public module, if it describes any."""
    public = getattr(nipper_pin, name)
    of_class = vars(public).values() if inspect.isclass(public) else ()
    for item in (public, *of_class):
        if not inspect.isfunction(item) or "Args:" not in (inspect.getdoc(item) or ""):
            continue
        described = re.findall(r"^ +([\w, *]+): ", inspect.getdoc(item) or "", re.MULTILINE)
        told = {word for names in described for word in names.replace("*", "").split(", ")}
        assert set(inspect.signature(item).parameters) - {"self", "cls"} <= told


def test_public_names_have_docstrings() -> None:
    missing = [
        f"{path.relative_to(ROOT)}: {name}"
        for path in PACKAGE
        for name in undocumented(ast.parse(path.read_text(encoding="utf-8")))
    ]
    assert not missing


def test_functions_are_short_and_take_few_parameters() -> None:
    assert beyond(1, LINES) == LONG
    assert beyond(2, PARAMETERS) == MANY


def test_files_are_short() -> None:
    large = {
        path.relative_to(ROOT).as_posix()
        for path in PACKAGE
        if len(path.read_text(encoding="utf-8").splitlines()) > FILE
    }
    assert large == LARGE


@pytest.mark.parametrize(("lines", "found"), [
    (["# a", "# b"], [(1, 2)]),
    (["x = 1", "# a", "# b", "# c"], [(2, 3)]),
    (["# a", "", "x = 1  # b", "    # c"], [(1, 1), (4, 1)]),
])  # fmt: skip
def test_blocks_of_comments_are_counted(lines: list[str], found: list[tuple[int, int]]) -> None:
    assert [*comments("\n".join(lines).replace("    #", "#") + "\n")] == found


def test_missing_docstrings_long_functions_and_parameters_are_found() -> None:
    text = "class A:\n    'd'\n    def b(self, c, *, d):\n        pass\n    def _e(self): pass\n"
    assert [*undocumented(ast.parse(text))] == ["b"]
    assert [*functions(text)] == [("b", 2, 2), ("_e", 1, 0)]
