"""Which mutations are tried, and which tests run for one."""

from __future__ import annotations

import ast
import hashlib
import json
import math
from collections import Counter, defaultdict
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from .sites import Mutation, mutations_of
from .statements import scope_key, statements_of

# Shares of the mutations by room: most in rooms whose output people read.
ROOMS = {"view": 0.3, "study": 0.3, "mechanism": 0.16, "cli": 0.12, "reduced": 0.12}
_KINDS = {
    "unit": 3.0, "arithmetic": 3.0, "comparison": 2.5, "number": 2.5, "name": 2.5, "text": 2.0,
    "drop": 2.0, "negate": 2.0, "sign": 2.0, "boolean": 2.0, "swap": 2.0, "keyword": 1.5,
    "guard": 1.5,
}  # fmt: skip
# Bridges to simulators that may not be installed, colours, dimensions of the gallery's machines:
# no test can tell a right value of these from a wrong one.
_LEFT_OUT = ("view/style.py", "view/scene/colours.py", "mechanism/gallery/")


@dataclass(frozen=True)
class Recorded:
    """A test.

    Attributes:
        name: Its name.
        seconds: How long it takes.
        keys: Statements that run in it.
    """

    name: str
    seconds: float
    keys: frozenset[str]


def recorded(files: Iterable[Path]) -> dict[str, Recorded]:
    """Tests that passed.

    Args:
        files: Files that ``record`` wrote; later ones count more.
    """
    tests: dict[str, Recorded] = {}
    for file in files:
        with file.open(encoding="utf-8") as stream:
            keys = json.loads(next(stream))
            for line in stream:
                item = json.loads(line)
                tests.pop(item.get("test", ""), None)
                if item.get("passed"):
                    ran = frozenset(keys[number] for number in item["keys"])
                    tests[item["test"]] = Recorded(item["test"], item["seconds"], ran)
    return tests


def drawn(package: Path, rooms: Iterable[str], seed: int) -> list[Mutation]:
    """All mutations of some rooms in random order; the first ones are the sample.

    A mutation keeps its number when the file changes elsewhere, so that two versions of the
    package are measured by nearly the same sample.
    """
    found: dict[str, list[Mutation]] = {}
    for room in rooms:
        for path in sorted((package / room).rglob("*.py")):
            file = path.relative_to(package).as_posix()
            if not file.startswith(_LEFT_OUT):
                text = path.read_text(encoding="utf-8")
                found.setdefault(room, []).extend(mutations_of(file, text))
    ranked = []
    seen: Counter[str] = Counter()
    for room, items in found.items():
        of_kind = Counter(item.kind for item in items)
        for item in items:
            parts = (seed, item.file, item.scope, item.key, item.kind, item.before, item.after)
            lasting = repr(parts)
            seen[lasting] += 1
            digest = hashlib.sha256(f"{lasting}:{seen[lasting]}".encode()).digest()
            number = (int.from_bytes(digest[:7], "big") + 0.5) / 2**56
            weight = ROOMS.get(room, 0.2) * _KINDS[item.kind] / of_kind[item.kind]
            ranked.append((-math.log(number) / weight, item))
    return [item for _, item in sorted(ranked, key=lambda pair: pair[0])]


class Choice:
    """Finds the tests for a mutation."""

    def __init__(self, package: Path, tests: dict[str, Recorded], existing: set[str]) -> None:
        """Note for every statement which tests execute it; those that are gone do not count."""
        tests = {name: test for name, test in tests.items() if name in existing}
        self._tests = tests
        self._by_key: dict[str, set[str]] = defaultdict(set)
        for test in tests.values():
            for key in test.keys:
                self._by_key[key].add(test.name)
                self._by_key[key[: key.rindex("::") + 2]].add(test.name)
                self._by_key[key[: key.index("::")]].add(test.name)
                self._by_key[key.split("/")[0]].add(test.name)
        self._users: dict[str, set[str]] = defaultdict(set)
        self._compiled: set[str] = set()
        for path in sorted(package.rglob("*.py")):
            file = path.relative_to(package).as_posix()
            tree = ast.parse(path.read_text(encoding="utf-8"))
            for item in statements_of(file, tree):
                if not item.recorded:
                    self._compiled.add(scope_key(file, item.scope))
                for name in _names(item.node):
                    self._users[name].add(item.key)

    def tests(self, mutation: Mutation, budget: float) -> tuple[list[str], int]:
        """The tests to run for a mutation, quickest and nearest first, and how many are left out.

        Args:
            mutation: The mutation.
            budget: Seconds that they may take together, by their recorded times.
        """
        names = self._executing(mutation)
        room = mutation.file.split("/")[0]
        stem = Path(mutation.file).stem

        def rank(name: str) -> float:
            test = self._tests[name]
            near = 1.0 if f"/{stem}" in name or f"_{stem}" in name.split("::")[0] else 3.0
            near *= 1.0 if f"/{room}/" in name or f"_{room}" in name else 3.0
            return near * (0.05 + test.seconds) * math.sqrt(len(test.keys))

        chosen: list[str] = []
        spent = 0.0
        ordered = sorted(names, key=rank)
        for name in ordered:
            if chosen and spent + self._tests[name].seconds > budget:
                continue
            chosen.append(name)
            spent += self._tests[name].seconds
        return chosen, len(ordered) - len(chosen)

    def limits(self, names: list[str]) -> dict[str, float]:
        """Seconds after which each of the tests counts as endless, on a busy machine."""
        # The first test in reduced/ waits until numba has compiled.
        least = 600.0 if any("/reduced/" in name for name in names) else 90.0
        return {name: least + 15.0 * self._tests[name].seconds for name in names}

    def _executing(self, mutation: Mutation) -> set[str]:
        if mutation.names:
            # A value of a module: tests of the functions that use it, else of anything in the file.
            prefix = scope_key(mutation.file, f".{mutation.names[0]}")[:-2]
            keys = set(self._users[mutation.names[-1]]) | set(self._users[mutation.names[0]])
            own = {key for key in self._by_key if key.startswith(prefix)}
            near = {key for key in keys | own if key.startswith(mutation.file)}
            for choice in (near, keys, {mutation.file}, {mutation.file.split("/")[0]}):
                found = set().union(*(self._by_key.get(key, set()) for key in choice))
                if found:
                    return found
        if mutation.key in self._by_key:
            return self._by_key[mutation.key]
        scope = scope_key(mutation.file, mutation.scope)
        if scope in self._compiled:
            # Compiled functions are not recorded: any test of the room may execute them.
            return self._by_key.get(mutation.file.split("/")[0], set())
        # The statement is newer than the record: tests of its function, else of its file.
        return self._by_key.get(scope) or self._by_key.get(mutation.file, set())


def _names(node: ast.AST) -> set[str]:
    return {item.id for item in ast.walk(node) if isinstance(item, ast.Name)} | {
        item.attr for item in ast.walk(node) if isinstance(item, ast.Attribute)
    }
