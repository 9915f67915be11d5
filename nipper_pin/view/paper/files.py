"""The study as files: the page, every figure as SVG and PDF, every table as CSV, and JSON."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable
from pathlib import Path

from ...errors import InputError
from ...outputs import complete_folder
from ...study.paper import PaperStudy
from ...texts import MOST_JSON, opened, read_text
from .report import material, report_html, study_plates
from .supplements import Supplements


def write_paper(
    study: PaperStudy,
    folder: str | Path,
    supplements: Callable[[], Supplements] = Supplements,
    progress: Callable[[int, int], None] | None = None,
) -> list[Path]:
    """Write the study; its files take the place of those of an earlier one in one step.

    Args:
        study: The study.
        folder: Folder, made if it does not exist; what else it holds stays.
        supplements: Gives results of other studies, to be shown after it. Asked when the figures
            of this study are drawn, so that the others can be computed meanwhile.
        progress: Called with (groups of figures drawn, groups in all).

    Returns:
        The files, ``report.html`` first.

    Raises:
        InputError: The folder cannot be written.
    """
    target = Path(folder)
    drawn = study_plates(study, progress)
    added = supplements()
    content = material(study, added, drawn)
    record = study.record()
    if added.sensitivities is not None:
        record["sensitivities"] = added.sensitivities.record()
    if added.designer is not None:
        record["designer"] = added.designer.record()
    files: dict[str, bytes] = {
        "report.html": report_html(study, added, content).encode(), _DOCUMENT: b"",
    }  # fmt: skip
    for plate in content.plates:
        files[f"{plate.name}.svg"] = plate.svg.encode()
        files[f"{plate.name}.pdf"] = plate.pdf
    for table in content.tables:
        files[f"{table.name}.csv"] = table.csv_text().encode()
    record["files"] = {name: _digest(data) for name, data in files.items() if data}
    files[_DOCUMENT] = (json.dumps(record, indent=1, allow_nan=False) + "\n").encode()
    with complete_folder(target, _earlier(target)) as new:
        for name, data in files.items():
            (new / name).write_bytes(data)
    return [target / name for name in files]


_DOCUMENT = "study.json"


def _earlier(folder: Path) -> tuple[str, ...]:
    """Names of the files of an earlier study, as far as they are as that one has left them.

    A document may name any file of the folder, so that its digest has to be right as well.
    """
    try:
        digests = json.loads(read_text(folder / _DOCUMENT, MOST_JSON))["files"]
        there = {file.name: file for file in folder.iterdir() if file.name in digests}
        return tuple(name for name, file in there.items() if _digest_of(file) == digests[name])
    except (OSError, InputError, ValueError, LookupError, TypeError):
        return ()


def _digest_of(file: Path) -> str:
    with opened(file) as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()


def _digest(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()
