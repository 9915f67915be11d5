import json
import sys
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from nipper_pin import Mechanism
from nipper_pin.reduced import ReducedModel, build

KERNELS = sorted((Path(__file__).parents[2] / "nipper_pin/reduced/kernels").glob("[!_]*.py"))
# The solution in 80-bit arithmetic.
sys.path.append(str(Path(__file__).parents[1] / "reference"))
REFERENCE = Path(__file__).parents[1] / "reference" / "e62_transition.json"


@pytest.fixture(scope="session")
def model(e62: Mechanism) -> ReducedModel:
    return build(e62)


@pytest.fixture(scope="session")
def fine(e62: Mechanism, model: ReducedModel) -> ReducedModel:
    """Other nodes, twice the degrees, and a little more room."""
    return build(e62, tolerance=1e-13, gap_max=1.02 * model.gap_max, travel_rad=2.2)


@pytest.fixture(scope="session")
def reference() -> dict[str, Any]:
    document: dict[str, Any] = json.loads(REFERENCE.read_text(encoding="utf-8"))
    return document["cases"]


@pytest.fixture
def plain(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """What is compiled as plain Python, also where one function calls another."""
    # All are imported before any is changed: one that is imported later would keep the change.
    modules = [import_module(f"nipper_pin.reduced.kernels.{path.stem}") for path in KERNELS]
    for module in modules:
        for name, function in list(vars(module).items()):
            if hasattr(function, "py_func"):
                monkeypatch.setattr(module, name, function.py_func)
    # As compiled: a division by zero is infinite.
    with np.errstate(all="ignore"):
        yield
