"""Calls of Python that are refused: kinds of errors and their sentences; nothing is written."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from snapshots import Words, blocks

import nipper_pin as nip
from nipper_pin.mechanism.gallery import drawn
from nipper_pin.study.levers import levers
from nipper_pin.study.speed_limit import speed_limit


def test_sentences(here: Path, words: Words, e62: nip.Mechanism) -> None:
    run = nip.simulate(e62, nip.Case(speed_rpm=650.0))
    names = {"nip": nip, "e62": e62, "run": run, "Path": Path, "replace": replace, "drawn": drawn,
             "levers": levers, "speed_limit": speed_limit}  # fmt: skip
    text = ""
    for call in (item.name for item in blocks(__file__, "test_sentences")):
        said = "nothing"
        try:
            eval(call, names)
        except nip.NipperError as error:
            # What numpy says of shapes is its own.
            said = f"{type(error).__name__}: {error.message.partition(': shape mismatch')[0]}"
        text += f"{call}\n    {said}\n"
    words(text, masked=False)
    assert not any(here.iterdir())
