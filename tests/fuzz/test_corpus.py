"""Files that an earlier fuzzer found, read again: taken, or refused by one line.

A file that once failed is called ``failed_...`` by what it ended in.
"""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from nipper_pin import InputError

sys.path.insert(0, str(Path(__file__).parent))

from targets import CORPUS, TARGETS, NotOneLineError, judged

MOST_FILES, MOST_BYTES = 400, 2**20
NEEDS = {"parquet": "pyarrow", "plan": "pyarrow", "live": "viser"}


@pytest.mark.parametrize("name", TARGETS)
def test_every_input_is_taken_or_refused_by_one_line(name: str) -> None:
    """A target that took or refused everything would show nothing."""
    if name in NEEDS:
        pytest.importorskip(NEEDS[name])
    files = sorted((CORPUS / name).iterdir())
    taken = {file.name for file in files if TARGETS[name](file.read_bytes())}
    assert 0 < len(taken) < len(files)


def test_the_corpus_has_a_folder_for_each_target_and_is_small() -> None:
    assert {item.name for item in CORPUS.iterdir()} == TARGETS.keys()
    files = [item for item in CORPUS.rglob("*") if item.is_file()]
    assert len(files) <= MOST_FILES
    assert sum(item.stat().st_size for item in files) <= MOST_BYTES


def refuse(message: str) -> None:
    raise InputError(message)


def test_other_ends_than_one_line_come_through() -> None:
    assert judged(lambda: 1)
    assert not judged(lambda: refuse("a word"))
    with pytest.raises(NotOneLineError):
        judged(lambda: refuse(" "))
    with pytest.raises(ZeroDivisionError):
        judged(lambda: 1 / 0)
    with pytest.raises(RecursionError):
        judged(lambda: judged(lambda: (_ for _ in ()).throw(RecursionError())))
