"""Write the pages of benchmark tables from a folder of `python -m benchmarks run --out FOLDER`.

Run: python scripts/maintain/figures/write_benchmark_pages.py FOLDER [DOCS]
"""

from __future__ import annotations

import math
import sys
from pathlib import Path

_READ = "Output of `python -m benchmarks run`, by `make benchmark`; [how to read it](benchmark.md)."
_SAME = " The run is that of the [engines](benchmark_engines.md)."
_TITLES = {
    "benchmark_engines": "Benchmark tables: engines",
    "benchmark_peers": "Benchmark tables: peers",
    "benchmark_costs": "Benchmark tables: costs and growth",
}
_ENGINES = "Engines: one transition, 650 r/min, e = 0.2"
_PEERS = "Peers: the same transition"
_COSTS = (
    "Cost of the phases",
    "Parts of one transition",
    "Growth with",
    "Peak memory",
)
_BOUNDS = (1e-3, 1e-6, 1e-9)


def main(folder: str, docs: str = "docs") -> None:
    """Write the pages.

    Args:
        folder: Folder with ``tables.md``.
        docs: Folder of the pages.
    """
    written = pages((Path(folder) / "tables.md").read_text(encoding="utf-8"))
    for name, text in written.items():
        (Path(docs) / f"{name}.md").write_text(text, encoding="utf-8")
    print(f"wrote {', '.join(written)} to {docs}")


def pages(tables: str) -> dict[str, str]:
    """Return the text of each page, by its name.

    Args:
        tables: The Markdown tables of a benchmark, each below its heading.
    """
    header, *sheets = tables.rstrip().split("\n### ")
    parts = {name: [f"# {title}"] for name, title in _TITLES.items()}
    for name, part in parts.items():
        part += [_READ, header.rstrip()] if name == "benchmark_engines" else [_READ + _SAME]
    found = {}
    for sheet in sheets:
        title, _, body = sheet.partition("\n\n")
        found[title] = body
        name = "benchmark_engines"
        if title.startswith(_COSTS):
            name = "benchmark_costs"
        elif title == _PEERS:
            name = "benchmark_peers"
        parts[name].append(f"## {title}\n\n{body.rstrip()}")
    if _PEERS in found:
        least = least_times([(_ENGINES, found[_ENGINES]), (_PEERS, found[_PEERS])])
        parts["benchmark_peers"].insert(2, least)
    return {name: "\n\n".join(part) + "\n" for name, part in parts.items()}


def least_times(sheets: list[tuple[str, str]]) -> str:
    """Return the least time of each engine and peer for some errors, as a section.

    Args:
        sheets: Title and table of each.
    """
    reached: dict[str, list[tuple[float, float]]] = {}
    for _, body in sheets:
        headings, _, *rows = [_cells(line) for line in body.splitlines() if line.startswith("|")]
        error, time = headings.index("worst of four"), headings.index("ms")
        for row in rows:
            if row[error] != "-":
                reached.setdefault(row[0], []).append((float(row[error]), float(row[time])))
    lines = [
        "## Least time for an error",
        "Median time [ms] of the cheapest setting whose worst error of four is below the bound.",
        "| engine or peer | " + " | ".join(f"{bound:.0e}" for bound in _BOUNDS)
        + " | least error | its time |\n| --- | ---: | ---: | ---: | ---: | ---: |",
    ]  # fmt: skip
    for name, points in reached.items():
        least = (min((t for e, t in points if e < b), default=math.inf) for b in _BOUNDS)
        cells = [f"{t:.3g}" if math.isfinite(t) else "-" for t in least]
        best, time_of_best = min(points)
        lines[-1] += f"\n| {name} | {' | '.join(cells)} | {best:.1e} | {time_of_best:.3g} |"
    return "\n\n".join(lines)


def _cells(line: str) -> list[str]:
    return [cell.strip() for cell in line.strip("|").split("|")]


if __name__ == "__main__":
    main(*sys.argv[1:3])
