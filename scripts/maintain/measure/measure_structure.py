"""How is the package divided into rooms, and how large are its files and functions?

    python scripts/maintain/measure/measure_structure.py [OTHER]

Prints, for this checkout and for the folder OTHER of another one beside it, cells divided by tabs:
files of each room (folder of the package) and of each room of hybrid/; arrows, that is ordered
pairs of which the first imports the second, between rooms and between modules; one circle of each
kind; the largest and the median file, and functions that are long or have many parameters. Imports
"at start" run when a module is imported; "at any time" are also those in functions and for types.
"""

from __future__ import annotations

import argparse
import ast
import statistics
from collections.abc import Iterable, Iterator
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

HERE = Path(__file__).resolve().parents[3]
PACKAGE = "nipper_pin"
MOST_LINES = 60
MOST_PARAMETERS = 7
Module = tuple[str, ...]
Arrow = tuple[str, str]


def modules(checkout: Path) -> dict[Module, Path]:
    """Modules of a checkout's package by their names, the package's own name left out.

    Args:
        checkout: Its folder.
    """
    root = checkout / PACKAGE
    found = {}
    for path in sorted(root.rglob("*.py")):
        parts = path.relative_to(root).with_suffix("").parts
        found[parts[:-1] if parts[-1] == "__init__" else parts] = path
    return found


def _statements(tree: ast.Module, *, top: bool) -> Iterator[ast.AST]:
    """Statements that run when a module starts, or all; what only types need is not run."""
    waiting: list[ast.AST] = list(tree.body)
    while waiting:
        node = waiting.pop()
        yield node
        typing = isinstance(node, ast.If) and ast.unparse(node.test).endswith("TYPE_CHECKING")
        if not (top and (typing or isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef))):
            waiting += ast.iter_child_nodes(node)


def imported(name: Module, path: Path, known: dict[Module, Path], *, top: bool) -> Iterator[Module]:
    """Modules of the package that a module imports.

    Args:
        name: The module.
        path: Its file.
        known: All modules.
        top: Only imports that run when the module starts count.
    """
    here = name if path.stem == "__init__" else name[:-1]
    for node in _statements(ast.parse(path.read_text(encoding="utf-8")), top=top):
        if isinstance(node, ast.ImportFrom):
            target = tuple((node.module or "").split(".")) if node.module else ()
            if node.level:
                target = here[: len(here) - node.level + 1] + target
            elif target[:1] == (PACKAGE,):
                target = target[1:]
            else:
                continue
            for item in node.names:
                yield (*target, item.name) if (*target, item.name) in known else target
        elif isinstance(node, ast.Import):
            for item in node.names:
                parts = tuple(item.name.split("."))
                if parts[0] == PACKAGE:
                    yield parts[1:]


def arrows(pairs: Iterable[tuple[Module, Module]], depth: int, inside: Module = ()) -> set[Arrow]:
    """Arrows between folders.

    Args:
        pairs: Importing and imported module of each import.
        depth: Number of leading parts of a module's name that name its folder.
        inside: Only modules of this folder count.
    """
    found = set()
    for first, second in pairs:
        if first[: len(inside)] == inside == second[: len(inside)]:
            one, other = ("/".join(item[:depth]) for item in (first, second))
            if one and other and one != other:
                found.add((one, other))
    return found


def circle(found: set[Arrow]) -> str:
    """One circle among arrows, or "none".

    Args:
        found: The arrows.
    """
    graph: dict[str, list[str]] = {}
    for one, other in sorted(found):
        graph.setdefault(one, []).append(other)
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as error:
        return " > ".join(error.args[1])
    return "none"


def functions(path: Path) -> Iterator[tuple[str, int, int]]:
    """Name, lines and parameters of each function of a file; `self` and `cls` do not count.

    Args:
        path: The file.
    """
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            given = node.args
            names = [item.arg for item in (*given.posonlyargs, *given.args, *given.kwonlyargs)]
            count = len(names) - (names[:1] in (["self"], ["cls"]))
            yield node.name, (node.end_lineno or node.lineno) - node.lineno + 1, count


def _hybrid(pairs: list[tuple[Module, Module]], when: str) -> dict[str, str]:
    rows = {}
    for label, depth in (("rooms and single files", 2), ("modules", 9)):
        found = arrows(pairs, depth, ("hybrid",))
        found = {(one, other) for one, other in found if "hybrid" not in {one, other}}
        rows[f"arrows between {label} of hybrid/, {when}"] = str(len(found))
        rows[f"circle of {label} of hybrid/, {when}"] = circle(found)
    return rows


def measure(checkout: Path) -> dict[str, str]:
    """All rows of the table of a checkout.

    Args:
        checkout: Its folder.

    Returns:
        Value of each row.
    """
    root = checkout / PACKAGE
    known = modules(checkout)
    rooms = {name[:1] for name, path in known.items() if path.parent != root}
    inner = {name[:2] for name, path in known.items() if path.parent.parent == root / "hybrid"}
    rows = {"files": str(len(known))}
    for room in sorted(rooms | inner):
        files = sum(name[: len(room)] == room for name in known)
        rows[f"files of {'/'.join(room)}/"] = str(files)
    single = sum(path.parent == root / "hybrid" for path in known.values())
    rows["files of hybrid/ outside its rooms"] = str(single)
    for when, top in (("at start", True), ("at any time", False)):
        pairs = [(name, other) for name, path in known.items()
                 for other in imported(name, path, known, top=top)]  # fmt: skip
        between = arrows((item for item in pairs if {item[0][:1], item[1][:1]} <= rooms), 1)
        rows[f"arrows between rooms, {when}"] = str(len(between))
        rows[f"circle of rooms, {when}"] = circle(between)
        rows |= _hybrid(pairs, when)
    sizes = {path: len(path.read_text(encoding="utf-8").splitlines()) for path in known.values()}
    largest = max(sizes, key=lambda path: sizes[path])
    rows["largest file"] = f"{largest.relative_to(root)}, {sizes[largest]} lines"
    rows["median file"] = f"{statistics.median(sizes.values()):g} lines"
    every = [item for path in known.values() for item in functions(path)]
    rows["functions"] = str(len(every))
    rows[f"functions above {MOST_LINES} lines"] = str(sum(item[1] > MOST_LINES for item in every))
    many = sum(item[2] > MOST_PARAMETERS for item in every)
    rows[f"functions with more than {MOST_PARAMETERS} parameters"] = str(many)
    return rows


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("other", nargs="?", type=Path, help="folder of another checkout")
    other = parser.parse_args().other
    columns = [measure(other)] if other else []
    columns.append(measure(HERE))
    names = list(dict.fromkeys(name for column in reversed(columns) for name in column))
    print("\t".join(["", *(["other"] if other else []), "this"]))
    for name in names:
        print("\t".join([name, *(column.get(name, "-") for column in columns)]))


if __name__ == "__main__":
    main()
