"""Statements of functions, named so that the names outlive changes elsewhere in the file."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from dataclasses import dataclass

_BODIES = ("body", "orelse", "finalbody")
# Decorators of functions that numba compiles: nothing can be recorded in there.
_COMPILED = ("compiled", "njit", "jit")


@dataclass(frozen=True)
class Statement:
    """A statement in the body of a function.

    Attributes:
        node: Its syntax tree.
        scope: Qualified name of its function.
        key: Name of it: file, scope and its first line.
        recorded: Whether it can be recorded that it runs.
    """

    node: ast.stmt
    scope: str
    key: str
    recorded: bool


def scope_key(file: str, scope: str) -> str:
    """Name of all statements of a function together."""
    return f"{file}::{scope}::"


def statements_of(file: str, tree: ast.Module) -> Iterator[Statement]:
    """All statements of functions of a file, outer ones first; docstrings are none."""
    yield from _inside(file, tree, "", within=False, recorded=True)


def _inside(
    file: str, node: ast.AST, scope: str, *, within: bool, recorded: bool
) -> Iterator[Statement]:
    for child in children(node):
        if within:
            first = ast.unparse(child).splitlines()[0]
            yield Statement(child, scope, scope_key(file, scope) + first, recorded)
        name = getattr(child, "name", "")
        if isinstance(child, (ast.FunctionDef, ast.AsyncFunctionDef)):
            plain = recorded and not any(is_compiled(item) for item in child.decorator_list)
            yield from _inside(file, child, f"{scope}.{name}", within=True, recorded=plain)
        elif isinstance(child, ast.ClassDef):
            yield from _inside(file, child, f"{scope}.{name}", within=False, recorded=recorded)
        else:
            yield from _inside(file, child, scope, within=within, recorded=recorded)


def children(node: ast.AST) -> Iterator[ast.stmt]:
    """The statements directly below a node, docstrings left out."""
    for block in blocks(node):
        for child in block:
            if not is_docstring(child):
                yield child


def blocks(node: ast.AST) -> Iterator[list[ast.stmt]]:
    """The lists of statements directly below a node."""
    for field in _BODIES:
        block = getattr(node, field, None)
        if isinstance(block, list):
            yield block
    for part in [*getattr(node, "handlers", ()), *getattr(node, "cases", ())]:
        yield part.body


def is_docstring(node: ast.stmt) -> bool:
    """Whether a statement is a text alone."""
    return (
        isinstance(node, ast.Expr)
        and isinstance(node.value, ast.Constant)
        and isinstance(node.value.value, str)
    )


def is_compiled(decorator: ast.expr) -> bool:
    """Whether a decorator hands the function to numba."""
    return any(name in ast.unparse(decorator).split(".")[-1] for name in _COMPILED)
