import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from nipper_pin.mechanism import Mechanism
from nipper_pin.reduced import ReducedModel, build

REFERENCE = Path(__file__).parents[1] / "reference" / "e62_transition.json"


@pytest.fixture(scope="session")
def model(e62: Mechanism) -> ReducedModel:
    return build(e62)


@pytest.fixture(scope="session")
def reference() -> dict[str, Any]:
    document: dict[str, Any] = json.loads(REFERENCE.read_text(encoding="utf-8"))
    return document["cases"]


@pytest.fixture
def plain(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """What is compiled as plain Python, also where one function calls another."""
    from nipper_pin.reduced.kernels import arrival_check, flight, flight_errors, kernel, panel

    for module in (arrival_check, flight_errors, flight, kernel, panel):
        for name, function in list(vars(module).items()):
            if hasattr(function, "py_func"):
                monkeypatch.setattr(module, name, function.py_func)
    # As compiled: a division by zero is infinite.
    with np.errstate(all="ignore"):
        yield
