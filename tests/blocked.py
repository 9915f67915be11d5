"""The command in a separate process, in which some libraries are not installed.

Called as ``python blocked.py NAME,NAME,... ARGUMENTS``: imports of these modules fail as if they
were not there.
"""

import importlib.abc
import os
import subprocess
import sys
from collections.abc import Iterable
from pathlib import Path


class Refusal(importlib.abc.MetaPathFinder):
    """Finds nothing of some packages, and keeps others from looking."""

    def __init__(self, names: Iterable[str]) -> None:
        self._names = frozenset(names)

    def find_spec(self, name, path=None, target=None):  # noqa: ARG002
        if name.partition(".")[0] in self._names:
            message = f"No module named {name!r}"
            raise ModuleNotFoundError(message, name=name)


def run_without(
    modules: Iterable[str], *arguments: str, folder: Path
) -> subprocess.CompletedProcess[str]:
    """Run the command in a folder, without these modules."""
    return subprocess.run(
        [sys.executable, __file__, ",".join(modules), *arguments],
        cwd=folder,
        env=os.environ | {"PYTHONPATH": os.pathsep.join(path for path in sys.path if path)},
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        check=False,
    )


if __name__ == "__main__":
    sys.meta_path.insert(0, Refusal(sys.argv[1].split(",")))
    from nipper_pin.cli import main

    sys.exit(main(sys.argv[2:]))
