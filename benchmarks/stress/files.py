"""Files of a campaign: a line for each verdict, and a saved case of each one that is wrong."""

from __future__ import annotations

import json
from dataclasses import asdict
from importlib.metadata import version
from pathlib import Path

from nipper_pin.errors import InputError
from nipper_pin.hybrid import Case, Resolution
from nipper_pin.hybrid.files.archive import mesh_digests
from nipper_pin.hybrid.files.npz import FORMAT
from nipper_pin.outputs import complete_file
from nipper_pin.study.folders import make_folder

from .judging import WRONG, Verdict
from .space import Trial

_VERDICTS = "verdicts.jsonl"
_TOLD = ("number", "family", "word", "kind", "detail")


def begin(folder: str | Path) -> None:
    """Make the folder of a campaign.

    Raises:
        InputError: It cannot be made, or holds verdicts already.
    """
    make_folder(folder)
    file = Path(folder) / _VERDICTS
    if file.exists():
        message = f"{file}: verdicts of another campaign; remove them, or give another --out"
        raise InputError(message, file=str(file))


def keep(item: Trial, verdict: Verdict, folder: str | Path) -> None:
    """Append a verdict to those of the folder; of a wrong one write the case, too.

    Raises:
        InputError: It cannot be written.
    """
    if verdict.word == WRONG:
        save_trial(item, verdict, folder)
    file = Path(folder) / _VERDICTS
    try:
        with file.open("a", encoding="utf-8") as stream:
            stream.write(json.dumps(asdict(verdict)) + "\n")
    except OSError as error:
        message = f"{file}: cannot be written ({error.strerror or error})"
        raise InputError(message, file=str(file)) from error


def save_trial(item: Trial, verdict: Verdict, folder: str | Path) -> None:
    """Write a trial as a saved case, which ``nipper-pin simulate --case`` runs.

    It says besides which trial it was and what was wrong.
    """
    case = Case(**{**item.case, "resolution": Resolution(**item.case["resolution"])})
    document = {
        "format": FORMAT,
        "version": version("nipper-pin"),
        "mechanism": asdict(item.source) | {"folder": str(Path(item.source.folder).resolve())},
        "meshes": mesh_digests(item.source.name, item.source.urdf, Path(item.source.folder)),
        "case": asdict(case),
        "stress": {"seed": item.seed, **{key: getattr(verdict, key) for key in _TOLD}},
    }
    target = Path(folder) / f"trial-{item.number}.json"
    with complete_file(target) as partial:
        partial.write_text(json.dumps(document, indent=1), encoding="utf-8")
