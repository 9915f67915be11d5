import gc
import os
import signal
import sys
import zlib
from collections import Counter
from pathlib import Path

# The matrices are 7 by 7: threads of BLAS only cost time, and with several test workers they
# fight for the processors. Read by BLAS when numpy is imported, so it has to stand first.
os.environ["OPENBLAS_NUM_THREADS"] = "1"

# A job that a script starts in the background ignores interrupts, and so would the commands that
# tests interrupt: they would wait for ever.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)

# Machines that several folders of tests build stand beside this file.
sys.path.insert(0, str(Path(__file__).parent))

import pytest
from snapshots import Text, Words, without_the_machine
from syrupy.assertion import SnapshotAssertion

from nipper_pin import Mechanism, load

# Of a terminal, and of what its user likes.
PERSONAL = (
    "COLUMNS", "LINES", "FORCE_COLOR", "NO_COLOR", "CLICOLOR_FORCE", "TERM", "LANGUAGE",
    "MPLBACKEND", "MATPLOTLIBRC", "PYTHONIOENCODING", "PYTHONWARNINGS", "PYTHONUNBUFFERED",
    "TTY_COMPATIBLE", "TTY_INTERACTIVE",
)  # fmt: skip
WEEK = 7


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--day", type=int, help="of the campaigns only the cases that this day draws")


def pytest_report_header(config: pytest.Config) -> str | None:
    if (day := config.option.day) is None:
        return None
    return f"campaigns: cases of day {day} (again: make test-slow DAY={day}; all: make test-all)"


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Cases of campaigns are slow; each is drawn on one day of a week."""
    numbers, places, left = Counter[str](), Counter[str](), list[pytest.Item]()
    for item in items:
        name = item.nodeid.partition("[")[0]
        if (sampled := item.get_closest_marker("sampled")) is not None:
            if numbers[name] % sampled.args[0]:
                item.add_marker("campaign")
            numbers[name] += 1
        if item.get_closest_marker("campaign") is None:
            continue
        item.add_marker("slow")
        # Cases of one test follow one another, and tests of one case do not all share a day.
        place = zlib.crc32(name.encode()) + places[name]
        places[name] += 1
        if config.option.day is not None and (place - config.option.day) % WEEK:
            left.append(item)
    if left:
        config.hook.pytest_deselected(items=left)
        gone = set(left)
        items[:] = [item for item in items if item not in gone]


def pytest_collection_finish() -> None:
    """Tests live as long as the run: they are not searched for garbage again and again."""
    gc.freeze()
    gc.set_threshold(20_000, 20, 20)


def pytest_configure() -> None:
    """Whoever runs the tests is not what they are about; each that is sets what it needs."""
    for name in PERSONAL:
        os.environ.pop(name, None)
    os.environ.update({"LC_ALL": "C.UTF-8", "PYTHONUTF8": "1", "TZ": "UTC"})
    os.umask(0o022)


@pytest.fixture(scope="session")
def e62() -> Mechanism:
    return load("e62")


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder of the test's own, in which it runs."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def words(snapshot: SnapshotAssertion) -> Words:
    """Says that a text is the reviewed one."""
    reviewed = snapshot.use_extension(Text)

    def check(text: str, *, masked: bool = True) -> None:
        assert (without_the_machine(text) if masked else text) == reviewed

    return check
