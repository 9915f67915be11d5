"""Where a file can be mutated, and how: from its syntax tree."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from typing import Any

from .looks import IDLE, LOOKS, PROSE, SILENT_CALLS
from .operators import changes
from .statements import children, statements_of


@dataclass(frozen=True)
class Mutation:
    """One change of one file.

    Attributes:
        file: File inside the package.
        line: Its line, from 1.
        begin: First byte that is replaced.
        end: Byte behind the last.
        before: What stands there.
        after: What takes its place.
        kind: Sort of change.
        key: Name of the statement, see :class:`Statement`.
        scope: Qualified name of the function; empty outside of functions.
        names: Outside of functions: what the statement defines.
    """

    file: str
    line: int
    begin: int
    end: int
    before: str
    after: str
    kind: str
    key: str
    scope: str
    names: tuple[str, ...]

    @property
    def identity(self) -> str:
        """What distinguishes it in files of results."""
        return f"{self.file}:{self.line}:{self.begin}:{self.kind}:{self.after}"

    def record(self) -> dict[str, Any]:
        """As a JSON object."""
        return asdict(self)

    def applied(self, source: bytes) -> bytes:
        """The file with the change made."""
        return source[: self.begin] + self.after.encode() + source[self.end :]


def mutations_of(file: str, source: str) -> list[Mutation]:
    """All mutations of a file; some may not be Python, see :func:`compiles`.

    Args:
        file: Its path inside the package.
        source: Its text.
    """
    tree, text = ast.parse(source), source.encode()
    starts = [0]
    for line in text.splitlines(keepends=True):
        starts.append(starts[-1] + len(line))
    found = []
    for statement, key, scope, names in _places(file, tree):
        for kind, anchor, after in _of_statement(statement):
            begin = starts[anchor.lineno - 1] + anchor.col_offset
            end = starts[(anchor.end_lineno or 0) - 1] + (anchor.end_col_offset or 0)
            before = text[begin:end].decode()
            item = Mutation(
                file, anchor.lineno, begin, end, before, after, kind, key, scope, names
            )  # fmt: skip
            found.append(item)
    return list({item.identity: item for item in found}.values())


def compiles(item: Mutation, text: bytes) -> bool:
    """Whether a mutation of a file leaves Python behind, and another program."""
    try:
        changed = ast.parse(item.applied(text))
    except SyntaxError:
        return False
    return ast.dump(changed) != ast.dump(ast.parse(text))


def _places(file: str, tree: ast.Module) -> Iterator[tuple[ast.stmt, str, str, tuple[str, ...]]]:
    for item in statements_of(file, tree):
        yield item.node, item.key, item.scope, ()
    yield from _outside(tree, ())


def _outside(
    node: ast.AST, names: tuple[str, ...]
) -> Iterator[tuple[ast.stmt, str, str, tuple[str, ...]]]:
    """Assignments outside of functions, and the defaults of functions there."""
    for child in children(node):
        if isinstance(child, ast.ClassDef):
            yield from _outside(child, (*names, child.name))
        elif isinstance(child, (ast.FunctionDef, ast.AsyncFunctionDef)):
            yield child, "", "", (*names, child.name)
        elif isinstance(child, (ast.Assign, ast.AnnAssign)):
            targets = child.targets if isinstance(child, ast.Assign) else [child.target]
            below = [item for target in targets for item in ast.walk(target)]
            bound = [item.id for item in below if isinstance(item, ast.Name)]
            if not any(name.startswith("__") for name in bound):
                yield child, "", "", names or tuple(bound)


def _of_statement(statement: ast.stmt) -> Iterator[tuple[str, ast.expr | ast.stmt, str]]:
    """The kinds, places and texts of the changes of a statement without the ones in it."""
    if isinstance(statement, (ast.Raise, ast.Assert, ast.Import, ast.ImportFrom)):
        return
    if isinstance(statement, ast.Assign) and _is_prose(statement.targets[0]):
        return
    if isinstance(statement, ast.If) and "TYPE_CHECKING" in ast.unparse(statement.test):
        return
    if isinstance(statement, ast.Expr) and _is_silent(statement.value):
        return
    yield from _dropped(statement)
    if isinstance(statement, ast.If):
        yield "negate", statement.test, f"(not ({ast.unparse(statement.test)}))"
        if isinstance(statement.body[-1], (ast.Raise, ast.Return, ast.Continue)):
            yield "guard", statement.test, "False"
    for node, anchor in _expressions(statement):
        for kind, after in changes(node, anchor):
            yield kind, anchor, after


def _dropped(statement: ast.stmt) -> Iterator[tuple[str, ast.stmt, str]]:
    value = getattr(statement, "value", None)
    call = isinstance(statement, ast.Expr) and isinstance(value, ast.Call)
    again = isinstance(statement, ast.Assign) and ast.unparse(statement.targets[0]) in {
        ast.unparse(item) for item in ast.walk(statement.value) if isinstance(item, ast.Name)
    }
    if call or again or isinstance(statement, ast.AugAssign):
        yield "drop", statement, "pass"
    if isinstance(statement, ast.AugAssign):
        swapped = {ast.Add: "-=", ast.Sub: "+=", ast.Mult: "/=", ast.Div: "*="}
        after = swapped.get(type(statement.op))
        if after:
            target, added = ast.unparse(statement.target), ast.unparse(statement.value)
            yield "arithmetic", statement, f"{target} {after} {added}"


def _is_prose(target: ast.expr) -> bool:
    return isinstance(target, ast.Name) and target.id in PROSE


def _is_silent(value: ast.expr) -> bool:
    return isinstance(value, ast.Call) and ast.unparse(value.func).split(".")[-1] in SILENT_CALLS


def _expressions(statement: ast.stmt) -> Iterator[tuple[ast.expr, ast.expr]]:
    """Expressions of a statement, each with the one whose place in the file is known."""
    for name, value in ast.iter_fields(statement):
        if name in ("annotation", "decorator_list", "returns", "bases", "keywords", "pattern"):
            continue
        if name == "args" and isinstance(value, ast.arguments):
            parts: list[Any] = [*value.defaults, *value.kw_defaults]
        else:
            parts = value if isinstance(value, list) else [value]
        for part in parts:
            if isinstance(part, ast.expr):
                yield from _below(part, None)
            elif isinstance(part, ast.withitem):
                yield from _below(part.context_expr, None)


def _below(node: ast.AST, anchor: ast.expr | None) -> Iterator[tuple[ast.expr, ast.expr]]:
    if isinstance(node, ast.keyword) and (node.arg in PROSE | LOOKS | IDLE):
        return
    if isinstance(node, ast.Call) and _is_silent(node):
        return
    if isinstance(node, ast.JoinedStr):
        # Places inside of a formatted text are not known before Python 3.12.
        anchor = anchor or node
    if isinstance(node, ast.expr):
        yield node, anchor or node
    for child in ast.iter_child_nodes(node):
        yield from _below(child, anchor)
