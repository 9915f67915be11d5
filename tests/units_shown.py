"""Units beside numbers that surfaces show, and what the document has without saying it."""

from __future__ import annotations

import csv
import io
import math
from typing import Any

from nipper_pin import Solution, record
from nipper_pin.view.run import tables

# What a value of the document is multiplied by, by its unit there and the unit that is read.
_FACTORS = {
    ("s", "ms"): 1e3, ("rad", "deg"): 180.0 / math.pi, ("rad", "mdeg"): 180e3 / math.pi,
    ("m", "mm"): 1e3, ("m", "um"): 1e6, ("m/s", "mm/s"): 1e3, ("J", "mJ"): 1e3, ("", "%"): 100.0,
}  # fmt: skip


def factor(own: str, shown: str) -> float:
    """By how much a number of the document is multiplied."""
    return 1.0 if own == shown else _FACTORS[own, shown]


def kind(run: Solution, stop: str) -> str:
    """Unit of a stop's coordinate."""
    index = run.mechanism.stop(stop).index
    (joint,) = (item for item in run.mechanism.joints if item.index == index)
    return "m" if joint.kind == "prismatic" else "rad"


def force(run: Solution, stop: str) -> str:
    """Unit of a stop's force: a moment at a hinge without a contact point."""
    bare = run.mechanism.stop(stop).contact is None
    return "N m" if bare and kind(run, stop) == "rad" else "N"


def impulse(run: Solution, stop: str) -> str:
    """The document's name of the impulse at a stop."""
    return f"impulse_{force(run, stop).replace(' ', '_')}_s"


def unit_of(label: str) -> str:
    """What stands in brackets at its end."""
    return label.rpartition("[")[2].rstrip("]")


def rows(run: Solution, name: str) -> list[dict[str, str]]:
    """Rows of a CSV file."""
    return list(csv.DictReader(io.StringIO(dict(tables(run))[name])))


def index(run: Solution, t: Any) -> Any:
    """On the comber's scale, forty to a turn, from the document's index of the first collision."""
    first: Any = record(run)["collisions"][0]  # type: ignore[index]
    return (first["index"] + 40.0 * run.case.speed_rpm / 60.0 * (t - first["t_s"])) % 40.0
