"""The tables of a run as CSV: collisions, phases, velocities of the links, and the motion."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterator, Mapping

import numpy as np

from ...frames import Column
from ...hybrid import Solution
from ...hybrid.result.columns import columns
from ...units import DEG_PER_RAD

_FILES = {
    "collisions.csv": "collisions",
    "phases.csv": "phases",
    "link_velocities.csv": "links",
    "motion.csv": "motion",
}
TABLES = tuple(_FILES)
"""Names of the files."""
_ANGLE = "cylinder_angle_rad"


def tables(solution: Solution, units: str = "SI") -> Iterator[tuple[str, str]]:
    """Name and content of each table that :func:`export` writes.

    Args:
        units: "SI", or "mm" for mm and degrees.
    """
    for file, table in _FILES.items():
        found: dict[str, Column] = {}
        for name, values in columns(solution, table, units).items():
            found[name] = values
            if name == _ANGLE:
                found["cylinder_angle_deg"] = np.asarray(values) * DEG_PER_RAD
        yield file, csv_text(found)


def csv_text(found: Mapping[str, Column]) -> str:
    """Columns of one length as CSV."""
    written = {name: _cells(values) for name, values in found.items()}
    stream = io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerow(written)
    # repr of a Python float is the shortest text that reads back to the same float.
    writer.writerows(zip(*written.values(), strict=True))
    return stream.getvalue()


def _cells(values: Column) -> list[object]:
    """Values of a column; an empty cell for a number that there is not."""
    plain = values.tolist() if isinstance(values, np.ndarray) else values
    return ["" if value is None or value != value else value for value in plain]
