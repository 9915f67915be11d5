"""Case files of trials that failed: everything that is needed to run one again.

A file has the layout of a saved case (``nipper-pin simulate --case`` reads it, too) and says
besides which trial it was and what was wrong.
"""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path
from typing import Any

from nipper_pin.errors import InputError
from nipper_pin.hybrid.case import Case, Resolution
from nipper_pin.hybrid.files.npz import FORMAT, READ, formats_read
from nipper_pin.hybrid.files.own_files import mesh_digests, need_own_files
from nipper_pin.outputs import complete_file
from nipper_pin.study.folders import make_folder
from nipper_pin.texts import MOST_JSON, read_text

from .judging import Verdict
from .machines.parts import Source
from .space import Trial


def save_trial(item: Trial, verdict: Verdict, folder: str | Path) -> Path:
    """Write the case file of a trial.

    Args:
        item: The trial.
        verdict: What became of it.
        folder: Folder to write into; made if it is not there.

    Raises:
        InputError: The folder or the file cannot be written.
    """
    case = Case(**{**item.case, "resolution": Resolution(**item.case["resolution"])})
    document = {
        "format": FORMAT,
        "mechanism": asdict(item.source) | {"folder": str(Path(item.source.folder).resolve())},
        "meshes": mesh_digests(item.source.name, item.source.urdf, Path(item.source.folder)),
        "case": asdict(case),
        "stress": {
            "seed": item.seed,
            "number": item.number,
            "family": item.family,
            "word": verdict.word,
            "kind": verdict.kind,
            "detail": verdict.detail,
        },
    }
    target = Path(folder) / f"trial-{item.number}.json"
    make_folder(folder)
    with complete_file(target) as partial:
        partial.write_text(json.dumps(document, indent=1), encoding="utf-8")
    return target


def load_trial(path: str | Path) -> Trial:
    """Read a case file, of this module or of a saved case.

    Raises:
        InputError: The file is missing, damaged or of another format.
    """
    try:
        document: dict[str, Any] = json.loads(read_text(Path(path), MOST_JSON))
        known = document.get("stress", {})
        item = Trial(
            number=int(known.get("number", 0)),
            seed=int(known.get("seed", 0)),
            family=str(known.get("family", "file")),
            source=Source(**document["mechanism"]),
            case=dict(document["case"]),
        )
        written = document["format"]
    except (OSError, ValueError, LookupError, TypeError, AttributeError) as error:
        message = f"{path}: not a case file, or a damaged one ({error})"
        raise InputError(message, file=str(path)) from error
    if written not in READ:
        message = f"{path}: this is format {written!r}, and this version reads {formats_read()}"
        raise InputError(message, file=str(path), format=written)
    source = item.source
    folder, meshes = Path(source.folder), document.get("meshes")
    need_own_files(source.name, source.urdf, source.description, folder, meshes)
    return item
