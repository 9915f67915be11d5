"""Solutions that the tests of this folder look at."""

import pytest
from runs_shown import run_of, turn

from nipper_pin import Solution, load


@pytest.fixture(scope="session")
def transition() -> Solution:
    return run_of("transition")


@pytest.fixture(scope="session")
def cycle() -> Solution:
    return run_of("e62")


@pytest.fixture(scope="session")
def many_turns() -> Solution:
    return turn(load("e62"), 650.0, 24.0, turns=20)
