"""``python -m benchmarks``: what measures the package, beside it in a checkout."""

from __future__ import annotations

import sys
from collections.abc import Sequence

from nipper_pin.cli import Commands
from nipper_pin.cli import main as run

COMMANDS = Commands(
    "python -m benchmarks",
    "Measure nipper_pin: run time against error, random cases, and the published study again.",
    {
        "run": ("benchmarks.commands.benchmark", "measure run time against error on this machine"),
        "stress": (
            "benchmarks.commands.stress",
            "run random and extreme cases, and check what must hold of each",
        ),
        "paper": (
            "benchmarks.commands.paper",
            "do the published study of the E62 nipper again, and what it leaves open",
        ),
    },
)
"""The commands."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; arguments and status as of ``nipper-pin``."""
    return run(arguments, COMMANDS)


if __name__ == "__main__":
    sys.exit(main())
