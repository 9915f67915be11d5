"""Ways to change an expression."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from typing import Any

from .looks import IDLE, LOOKS, PROSE

# No test can notice that these are missing or changed: messages, types, looks.
LEFT_ALONE = IDLE | LOOKS | PROSE

_COMPARISONS: dict[type[ast.cmpop], tuple[type[ast.cmpop], ...]] = {
    ast.Lt: (ast.LtE, ast.Gt),
    ast.LtE: (ast.Lt, ast.GtE),
    ast.Gt: (ast.GtE, ast.Lt),
    ast.GtE: (ast.Gt, ast.LtE),
    ast.Eq: (ast.NotEq,),
    ast.NotEq: (ast.Eq,),
    ast.Is: (ast.IsNot,),
    ast.IsNot: (ast.Is,),
    ast.In: (ast.NotIn,),
    ast.NotIn: (ast.In,),
}
_ARITHMETIC: dict[type[ast.operator], type[ast.operator]] = {
    ast.Add: ast.Sub,
    ast.Sub: ast.Add,
    ast.Mult: ast.Div,
    ast.Div: ast.Mult,
    ast.FloorDiv: ast.Mult,
    ast.Mod: ast.FloorDiv,
    ast.Pow: ast.Mult,
}
_CONVERSIONS = {"degrees", "radians", "rad2deg", "deg2rad", "sqrt", "abs", "fabs"}
_SYMMETRIC = {
    "hypot", "max", "min", "isinstance", "isclose", "array_equal", "gcd", "cross", "maximum",
    "minimum",
}  # fmt: skip
# Names of pairs that are easily confused.
_PAIRS = (
    ("before", "after"), ("approach", "separation"), ("min", "max"), ("first", "last"),
    ("lower", "upper"), ("start", "end"), ("sin", "cos"), ("left", "right"), ("x", "z"),
    ("any", "all"), ("amplitude", "time"), ("rebound_amplitude", "rebound_time"),
    ("approach_rate", "separation_rate"), ("v_before", "v_after"), ("t_start", "t_end"),
    ("minimum", "maximum"), ("argmin", "argmax"), ("q", "v"), ("mean", "median"),
    ("impulse", "energy_lost"), ("width", "height"), ("floor", "ceil"), ("row", "column"),
)  # fmt: skip
_OTHER = {**dict(_PAIRS), **{b: a for a, b in _PAIRS}}
_UNITS = re.compile(r"(?<![A-Za-z])(mrad|rad|mm|ms|mJ|deg|kN|r/min|N m s|N s|N m|N/m|rpm)(?![a-z])")
_OTHER_UNIT = {
    "mrad": "rad", "rad": "deg", "mm": "m", "ms": "s", "mJ": "J", "deg": "rad", "kN": "N",
    "r/min": "1/s", "N m s": "N s", "N s": "N m s", "N m": "N", "N/m": "N", "rpm": "hz",
}  # fmt: skip


def changes(node: ast.expr, anchor: ast.expr) -> Iterator[tuple[str, str]]:
    """Kinds of change of an expression, and what then stands in place of the anchor.

    Args:
        node: The expression.
        anchor: It or one around it.
    """
    for kind, field, value in _fields(node):
        kept = getattr(node, field)
        setattr(node, field, value)
        try:
            text = ast.unparse(anchor)
        finally:
            setattr(node, field, kept)
        yield kind, text if isinstance(anchor, (ast.Constant, ast.JoinedStr)) else f"({text})"
    if node is anchor:
        yield from _whole(node)


def _fields(node: ast.expr) -> Iterator[tuple[str, str, Any]]:
    """A kind of change, the field of the node that changes and what it becomes."""
    if isinstance(node, ast.Compare):
        for other in _COMPARISONS[type(node.ops[0])][0 if _counts(node) else -1 :]:
            yield "comparison", "ops", [other(), *node.ops[1:]]
    elif isinstance(node, ast.BinOp) and type(node.op) in _ARITHMETIC:
        if not isinstance(node.left, (ast.JoinedStr, ast.List, ast.Tuple)):
            yield "arithmetic", "op", _ARITHMETIC[type(node.op)]()
    elif isinstance(node, ast.BoolOp):
        yield "boolean", "op", ast.Or() if isinstance(node.op, ast.And) else ast.And()
    elif isinstance(node, ast.Constant):
        for kind, value in _constants(node.value):
            yield kind, "value", value
    elif isinstance(node, ast.Attribute) and isinstance(node.ctx, ast.Load):
        if node.attr in _OTHER:
            yield "name", "attr", _OTHER[node.attr]
    elif isinstance(node, ast.Name) and isinstance(node.ctx, ast.Load) and node.id in _OTHER:
        if node.id in ("min", "max", "any", "all"):
            yield "name", "id", _OTHER[node.id]
    elif isinstance(node, ast.Call):
        yield from _calls(node)
    elif isinstance(node, (ast.Tuple, ast.List)) and isinstance(node.ctx, ast.Load):
        yield from (("swap", "elts", items) for items in _swapped(node.elts))


def _counts(node: ast.Compare) -> bool:
    """Whether equality matters: between floats it hardly ever happens."""
    sides = [node.left, *node.comparators]
    return any(isinstance(item, ast.Constant) and isinstance(item.value, int) for item in sides)


def _whole(node: ast.expr) -> Iterator[tuple[str, str]]:
    """Kinds of change that put something else in place of the whole expression."""
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, (ast.USub, ast.Not)):
        if not isinstance(node.operand, ast.Constant):
            yield "sign", f"({ast.unparse(node.operand)})"
    elif isinstance(node, ast.IfExp):
        yield (
            "negate",
            (
                f"({ast.unparse(node.orelse)} if {ast.unparse(node.test)}"
                f" else {ast.unparse(node.body)})"
            ),
        )
    elif isinstance(node, ast.Call) and len(node.args) == 1:
        name = ast.unparse(node.func).split(".")[-1]
        if name in _CONVERSIONS:
            yield "unit", f"({ast.unparse(node.args[0])})"


def _calls(node: ast.Call) -> Iterator[tuple[str, str, Any]]:
    plain = not any(isinstance(item, ast.Starred) for item in node.args)
    if plain and ast.unparse(node.func).split(".")[-1] not in _SYMMETRIC:
        yield from (("swap", "args", items) for items in _swapped(node.args))
    for place, item in enumerate(node.keywords):
        if item.arg is not None and item.arg not in LEFT_ALONE:
            yield "keyword", "keywords", node.keywords[:place] + node.keywords[place + 1 :]


def _swapped(items: list[ast.expr]) -> Iterator[list[ast.expr]]:
    for place in range(len(items) - 1):
        if ast.dump(items[place]) != ast.dump(items[place + 1]):
            yield [*items[:place], items[place + 1], items[place], *items[place + 2 :]]


def _constants(value: object) -> Iterator[tuple[str, object]]:
    if isinstance(value, bool):
        yield "boolean", not value
    elif isinstance(value, int):
        yield "number", value + 1
        if value > 1:
            yield "number", value - 1
    elif isinstance(value, float):
        # Powers of a thousand are units.
        if value in (1e3, 1e-3, 1e6, 1e-6, 60.0):
            yield "unit", 1.0
        yield "number", 2.0 * value if value else 1.0
        if value:
            yield "number", -value
    elif isinstance(value, str) and len(value) > 1:
        if match := _UNITS.search(value):
            begin, end = match.span()
            yield "text", value[:begin] + _OTHER_UNIT[match[0]] + value[end:]
        elif value not in LEFT_ALONE and re.fullmatch(r"[A-Za-z_][\w.]*", value):
            yield "text", value + "_"
