"""The study as files: the page, every figure as SVG and PDF, every table as CSV, and JSON."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

from ...outputs import complete_folder
from ...study.paper import PaperStudy
from .report import material, report_html, study_plates
from .supplements import Supplements


def write_paper(
    study: PaperStudy, folder: str | Path, supplements: Callable[[], Supplements] = Supplements
) -> list[Path]:
    """Write the study; each file appears only when it is complete.

    Args:
        study: The study.
        folder: Folder, made if it does not exist; files of the same names are replaced.
        supplements: Gives results of other studies, to be shown after it. Asked when the figures
            of this study are drawn, so that the others can be computed meanwhile.

    Returns:
        The files, ``report.html`` first.

    Raises:
        InputError: The folder cannot be written.
    """
    target = Path(folder)
    drawn = study_plates(study)
    added = supplements()
    content = material(study, added, drawn)
    record = study.record()
    if added.sensitivities is not None:
        record["sensitivities"] = added.sensitivities.record()
    document = json.dumps(record, indent=1, allow_nan=False) + "\n"
    files: dict[str, bytes] = {
        "report.html": report_html(study, added, content).encode(),
        "study.json": document.encode(),
    }
    for plate in content.plates:
        files[f"{plate.name}.svg"] = plate.svg.encode()
        files[f"{plate.name}.pdf"] = plate.pdf
    for table in content.tables:
        files[f"{table.name}.csv"] = table.csv_text().encode()
    with complete_folder(target, ()) as new:
        for name, data in files.items():
            (new / name).write_bytes(data)
    return [target / name for name in files]
