"""Solutions that the tests of this folder look at."""

import pytest

from nipper_pin.hybrid.case import Case
from nipper_pin.hybrid.result.solution import Solution
from nipper_pin.hybrid.simulate import simulate
from nipper_pin.mechanism import load


@pytest.fixture(scope="session")
def transition() -> Solution:
    return simulate(load("e62"), Case(speed_rpm=650.0))


@pytest.fixture(scope="session")
def cycle() -> Solution:
    return simulate(load("e62"), Case(speed_rpm=650.0, window="cycle"))


@pytest.fixture(scope="session")
def many_turns() -> Solution:
    return simulate(load("e62"), Case(speed_rpm=650.0, window="cycle", cycles=20))
