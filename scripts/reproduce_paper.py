"""The published study of the E62 nipper in the Python API: ratios, one open question, the report.

Run: python scripts/reproduce_paper.py [FOLDER]
"""

from __future__ import annotations

import sys
from pathlib import Path

import nipper_pin as nip
from nipper_pin.study.paper import PaperStudy, paper_study
from nipper_pin.view.paper.files import write_paper


def main(folder: str | Path) -> PaperStudy:
    """Print every published ratio beside ours and write the report.

    Args:
        folder: Folder of the report.
    """
    mechanism = nip.load("e62")
    print(mechanism.title)
    study = paper_study(mechanism)

    for ratio in study.ratios:
        print(
            f"{ratio.name:47s} published {ratio.published:8.4f}  ours {ratio.ours:9.4f}  "
            f"{100.0 * ratio.relative_deviation:+5.1f} %"
        )
    print(f"{study.within(0.04)} of {len(study.ratios)} within 4 %, {study.within(0.10)} in 10 %")

    # From which speed on does the steeve leave its stop with the jaw open?
    for preload in (9e-3, 11e-3, 13e-3):
        limit = study.phase_one.threshold_rpm(preload)
        print(f"preload {1e3 * preload:g} mm: the steeve stays on its stop up to {limit:.1f} r/min")

    report, *others = write_paper(study, folder)
    print(f"{report} and {len(others)} more files")
    return study


if __name__ == "__main__":
    main(sys.argv[1] if len(sys.argv) > 1 else "out/paper")
