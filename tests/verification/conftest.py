import sys
from pathlib import Path

import pytest

# Published problems and sprung machines have modules of their own beside the tests.
sys.path.insert(0, str(Path(__file__).parent))

import sprung

from nipper_pin import Mechanism


@pytest.fixture(scope="session")
def pendulum() -> Mechanism:
    """A double pendulum with springs and dampers of every kind."""
    return sprung.double_pendulum()
