"""Write page and record of the benchmark, from a folder of `python -m benchmarks run --out FOLDER`.

Run: python scripts/maintain/figures/write_benchmark_page.py FOLDER [DOCS]
     Copies the picture of the run, too.
"""

from __future__ import annotations

import json
import math
import shutil
import sys
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from benchmarks.run_time.recorded import RECORDED, record
from benchmarks.views.sheet import Sheet

_PAGE = Path(__file__).with_name("benchmark_page.md")
_PICTURE = "work_precision.png"
_BOUNDS = (1e-3, 1e-6, 1e-9)
# Engines and peers are compared with these, at the same bound of the error.
_SCIPY = "SciPy DOP853, located events (hand-derived equation)"
_NUMBA = "fixed-step RK4, located impacts (numba, hand-derived equation)"


def main(folder: str, docs: str = "docs") -> None:
    """Write the page, its picture, and the times that later runs are compared with.

    Args:
        folder: Folder with ``benchmark.json`` and ``work_precision.png``.
        docs: Folder of the pages.
    """
    document = json.loads((Path(folder) / "benchmark.json").read_text(encoding="utf-8"))
    target = Path(docs) / "benchmark.md"
    target.write_text(page(document), encoding="utf-8")
    shutil.copyfile(Path(folder) / _PICTURE, Path(docs) / "images" / _PICTURE)
    RECORDED.write_text(json.dumps(record(document)) + "\n", encoding="utf-8")
    print(f"wrote {target}, {_PICTURE} and {RECORDED.name}")


def page(document: Mapping[str, Any]) -> str:
    """The text of the page.

    Args:
        document: What a benchmark writes as JSON.
    """
    found, cost = document["environment"], document["cost"]
    versions = ", ".join(f"{name} {value}" for name, value in found["versions"].items())
    reduced = document["reduced"]
    return _PAGE.read_text(encoding="utf-8").format(
        run=f"{found['date'][:10]}, {found['processor']}, {found['cores']} cores, Python "
        f"{found['python']}, {versions}",
        least=least_times([*document["engines"], *document["peers"]]),
        turns=_table("A turn at a tolerance", document["turns"], {
            "engine": "engine", "setting": "setting", "ms": "wall_ms", "error of times":
            "error_times", "error of impulses": "error_impulses", "tables [ms]": "tables_ms",
        }, text=2),
        batch=f"{reduced['transitions_per_s']:,.0f}",
        tables=_number(reduced["build_ms"]),
        repeated=_table("Turns that repeat are copied", cost["turns"], {
            "turns": "turns", "copied where they repeat [ms]": "reuse_ms",
            "each computed [ms]": "no_reuse_ms",
        }),
        links=_table("Growth with the number of links", cost["links"], {
            "links": "links", "held [ms]": "held_ms", "inertial [ms]": "inertial_ms",
            "an evaluation [us]": "evaluation_us",
        }),
    )  # fmt: skip


def least_times(rows: Iterable[Mapping[str, Any]]) -> str:
    """Least time of each engine and peer for some errors, and its ratio to two of them.

    Args:
        rows: Measured settings, with ``engine``, ``fastest_ms`` and ``error_worst``.
    """
    reached: dict[str, list[tuple[float, float]]] = {}
    for row in rows:
        if row["error_worst"] is not None:
            point = float(row["error_worst"]), float(row["fastest_ms"])
            reached.setdefault(row["engine"], []).append(point)
    least = {
        name: [min((t for e, t in points if e < bound), default=math.nan) for bound in _BOUNDS]
        for name, points in reached.items()
    }
    headings = (
        "engine or peer", *(f"< {bound:.0e}" for bound in _BOUNDS),
        f"by SciPy, < {_BOUNDS[-1]:.0e}", "by numba, the same", "least error", "its time",
    )  # fmt: skip
    missing, cells = [math.nan] * len(_BOUNDS), []
    for name, points in reached.items():
        ratios = [least[name][-1] / least.get(one, missing)[-1] for one in (_SCIPY, _NUMBA)]
        error, time = min(points)
        numbers = (*map(_number, (*least[name], *ratios)), f"{error:.1e}", _number(time))
        cells.append((name, *numbers))
    return Sheet("The cheapest setting below each bound [ms]", headings, tuple(cells)).markdown()


def _table(
    title: str, rows: Iterable[Mapping[str, Any]], columns: Mapping[str, str], text: int = 1
) -> str:
    """Rows as Markdown, by the heading of each column and its name."""
    cells = (tuple(_number(row[name]) for name in columns.values()) for row in rows)
    return Sheet(title, tuple(columns), tuple(cells), text).markdown()


def _number(value: Any) -> str:
    """A number in three digits, text as it is, and a dash for what is not there."""
    if isinstance(value, str):
        return value
    return f"{value:.3g}" if value is not None and math.isfinite(value) else "-"


if __name__ == "__main__":
    main(*sys.argv[1:3])
