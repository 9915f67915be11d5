"""Draw the work-precision picture from the recorded tables of the documents, without a new run.

Run: python scripts/maintain/figures/draw_recorded_benchmark.py [DOCS]
"""

from __future__ import annotations

import re
import sys
from pathlib import Path

from benchmarks.run_time.work_precision import Row
from benchmarks.views.work_precision_plot import draw_rows
from nipper_pin.view.figure_file import save_figure

_TABLES = (
    ("benchmark_engines.md", "Engines: one transition, 650 r/min, e = 0.2"),
    ("benchmark_peers.md", "Peers: the same transition"),
)


def rows(text: str, title: str) -> list[Row]:
    """Rows of one table.

    Args:
        text: The page.
        title: Heading of the table.
    """
    body = text.partition(f"## {title}\n")[2].partition("\n## ")[0]
    lines = [line.strip("|").split("|") for line in body.splitlines() if line.startswith("|")]
    headings, _, *found = [[cell.strip() for cell in line] for line in lines]
    return [_row(dict(zip(headings, cells, strict=True))) for cells in found]


def _row(cells: dict[str, str]) -> Row:
    """The numbers that are drawn; how many runs there were is not in the tables."""
    numbers = {name: None if text == "-" else text for name, text in cells.items()}
    worst, transition = numbers["worst of four"], numbers["transition"]
    return Row(
        engine=next(iter(cells.values())),
        setting=cells["setting"],
        wall_ms=float(cells["ms"]),
        first_ms=float(cells["first"]),
        fastest_ms=float(cells["fastest"]),
        spread_ms=float(cells["spread"]),
        runs=0,
        error_duration=None if transition is None else float(transition),
        error_worst=None if worst is None else float(worst),
    )


def main(docs: str = "docs") -> None:
    """Write the picture.

    Args:
        docs: Folder of the pages, which has the folder images.
    """
    home = Path(docs)
    texts = [(home / name).read_text(encoding="utf-8") for name, _ in _TABLES]
    every = [
        row for text, (_, title) in zip(texts, _TABLES, strict=True) for row in rows(text, title)
    ]
    # "2026-11-21T20:26:48+00:00, full run", and below it platform and processor.
    found = re.search(r"^(\d{4}-\d\d-\d\d)T.*\n[^,]+, (.*?), \d+ cores", texts[0], re.MULTILINE)
    if found is None:
        sys.exit(f"{home / _TABLES[0][0]}: does not say when and on what it was measured")
    target = home / "images" / "work_precision.png"
    save_figure(draw_rows(every, *found.groups()), target, "png")
    print(f"wrote {target}")


if __name__ == "__main__":
    main(*sys.argv[1:2])
