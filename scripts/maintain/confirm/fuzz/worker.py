"""One target under the fuzzer, in a process of its own: `fuzz_files.py` starts it.

Inputs that end in anything but an answer are kept, a few of each kind, and the fuzzer goes on.
"""

from __future__ import annotations

import hashlib
import json
import random
import resource
import sys
import time
import traceback
import warnings
from collections import Counter
from collections.abc import Callable
from importlib import import_module
from pathlib import Path

import atheris

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[3]
sys.path[:0] = [str(ROOT), str(ROOT / "tests" / "fuzz"), str(HERE)]
_KEPT = 2  # inputs of one kind of failure
_PLAIN = 0.1  # part of the inputs that the fuzzer's own mutator makes
_RIGHT = 0.5  # sum of this part, and of that which is made of an input that is taken
_TOLD = 100  # inputs between two records
# What numba compiles can have no counters in it.
_KERNELS = ROOT / "nipper_pin" / "reduced" / "kernels"
_COMPILED = [f"nipper_pin.reduced.kernels.{file.stem}" for file in _KERNELS.glob("*.py")]


class Watched:
    """A target that counts, takes times and keeps what fails.

    Args:
        target: The target.
        folder: Folder of failures and of the record.
        last: Number of the last input.
    """

    def __init__(self, target: Callable[[bytes], bool], folder: Path, last: int) -> None:
        """Count nothing yet."""
        self._target, self._folder, self._last = target, folder, last
        self.inputs = self.taken = 0
        self.slowest_s = 0.0
        self.failures: Counter[str] = Counter()

    def __call__(self, data: bytes) -> None:
        """Give the target an input."""
        began = time.perf_counter()
        try:
            self.taken += self._target(data)
        except Exception as error:
            self._keep(data, error)
        took = time.perf_counter() - began
        self.inputs += 1
        if took > self.slowest_s:
            self.slowest_s = took
            (self._folder / "slowest").write_bytes(data)
        if self.inputs % _TOLD == 0 or self.inputs >= self._last:
            self.tell()

    def tell(self) -> None:
        """Write the record."""
        record = {
            "inputs": self.inputs,
            "taken": self.taken,
            "slowest_s": round(self.slowest_s, 3),
            "peak_MB": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss // 1024,
            "failures": dict(self.failures),
        }
        (self._folder / "record.json").write_text(json.dumps(record), encoding="utf-8")

    def _keep(self, data: bytes, error: Exception) -> None:
        frames = traceback.extract_tb(error.__traceback__)
        own = [item for item in frames if "nipper_pin/" in item.filename] or list(frames)
        place = f"{own[-1].filename.rpartition('nipper_pin/')[2]}:{own[-1].lineno}"
        kind = f"{type(error).__name__} {place}"
        self.failures[kind] += 1
        if self.failures[kind] <= _KEPT:
            name = hashlib.sha256(data).hexdigest()[:12]
            (self._folder / f"failure_{name}").write_bytes(data)
            text = "".join(traceback.format_exception(error))
            (self._folder / f"failure_{name}.txt").write_text(text, encoding="utf-8")


def main(name: str, folder: Path, options: list[str]) -> None:
    """Fuzz one target; does not return.

    Args:
        name: Name of the target.
        folder: Folder of failures and of the record.
        options: Of libFuzzer, with the corpora.
    """
    # A warning that a user would see beside a sentence is a failure, too.
    warnings.simplefilter("error", RuntimeWarning)
    with atheris.instrument_imports(
        include=["nipper_pin", "viser.infra"], exclude=_COMPILED, enable_loader_override=False
    ):
        from mutators import MUTATORS

        readers = import_module("targets")
        targets = readers.TARGETS

        # The process ends without leave when the last input is done.
        last = next(int(item.partition("=")[2]) for item in options if item.startswith("-runs="))
        watched = Watched(targets[name], folder, last)
        mutate = MUTATORS[name]
        # What is imported or compiled at its first use is no time of an input.
        readers.turned(readers.load("e62"))
        first = [file.read_bytes() for file in sorted(Path(options[1]).glob("*"))]
        right = [data for data in first if targets[name](data)]

        def changed(data: bytes, most: int, seed: int) -> bytes:
            chance = random.Random(seed)
            kind = chance.random()
            if kind < _PLAIN:
                return bytes(atheris.Mutate(data, most))
            return mutate(chance.choice(right) if kind < _RIGHT else data, chance)[:most]

        atheris.Setup([sys.argv[0], *options], watched, custom_mutator=changed)
        atheris.Fuzz()


if __name__ == "__main__":
    main(sys.argv[1], Path(sys.argv[2]), sys.argv[3:])
