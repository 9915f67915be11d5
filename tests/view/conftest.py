"""Solutions that the tests of this folder look at."""

from collections.abc import Callable

import pytest
from runs_shown import run_of, turn

import nipper_pin as nip
from nipper_pin import Comparison, Solution, load


@pytest.fixture(scope="session")
def transition() -> Solution:
    return run_of("transition")


@pytest.fixture(scope="session")
def cycle() -> Solution:
    return run_of("e62")


@pytest.fixture(scope="session")
def many_turns() -> Solution:
    return turn(load("e62"), 650.0, 24.0, turns=20)


@pytest.fixture(scope="session")
def page_of(tmp_path_factory: pytest.TempPathFactory) -> Callable[..., str]:
    """The page of a run or a comparison, as it is written; in true size where nothing is said."""
    file = tmp_path_factory.mktemp("pages") / "page.html"

    def text(shown: Solution | Comparison, **look: float | None) -> str:
        return nip.view(shown, file, **{"exaggerate": 1.0, **look}).read_text(encoding="utf-8")

    return text
