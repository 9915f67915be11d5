import json
from pathlib import Path
from typing import Any

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
