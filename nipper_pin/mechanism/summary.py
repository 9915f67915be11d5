"""A mechanism in one line, as a notebook shows it, and what to know before its numbers are used."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..notebook import html
from ..terms.shown import counted
from ..tolerances.mechanics import CURVE_DEPARTURE
from ..units import MM_PER_M

if TYPE_CHECKING:
    from .mechanism import Mechanism


def line(mechanism: Mechanism) -> str:
    """One line."""
    stops = ", ".join(stop.name for stop in mechanism.stops)
    parts = {"joint": mechanism.joints, "closure": mechanism.closures, "drive": mechanism.drives}
    counts = ", ".join(counted(len(items), noun) for noun, items in parts.items())
    return (
        f"<Mechanism {mechanism.name}: {counts}, stops {stops or 'none'}, "
        f"mobility {mechanism.degrees_of_freedom}>"
    )


def page(mechanism: Mechanism) -> str:
    """HTML: what it is, and its joints."""
    facts = {
        "links": ", ".join(mechanism.links),
        "closures": ", ".join(item.name for item in mechanism.closures) or "none",
        "drives": ", ".join(item.name for item in mechanism.drives) or "none",
        "stops": ", ".join(f"{item.name} (e_N {item.restitution:g})" for item in mechanism.stops)
        or "none",
        "mobility": mechanism.degrees_of_freedom,
        "rated speed [r/min]": mechanism.cylinder.rated_speed_rpm,
    }
    joints = [(item.name, item.kind, item.parent, item.child) for item in mechanism.joints]
    title = f"{mechanism.name}: {mechanism.title}" if mechanism.title else mechanism.name
    return html(title, facts, ("joint", "kind", "parent", "child"), joints)


def closing(mechanism: Mechanism) -> str:
    """What was closed of loops that rounded numbers leave open; empty if all meet."""
    words = []
    for closure in mechanism.closures:
        x, z = (MM_PER_M * value for value in closure.gap_m)
        if x or z:
            length = float(np.hypot(x, z))
            words.append(
                f"closure {closure.name} by {length:.3g} mm (x {x:.3g}, z {z:.3g}) from "
                f"{closure.first_side} to {closure.frame_b}, "
                f"{length / MM_PER_M / mechanism.reach_m:.2g} of the machine's reach"
            )
    if not words:
        return ""
    return (
        "loops that rounded numbers of the URDF leave open are closed at touch by moving the "
        f"frames that meet: {'; '.join(words)}"
    )


def curves(mechanism: Mechanism) -> str:
    """Which tables of springs bend away from the lines between their rows; empty if none does."""
    told = (
        f"the smooth curve of spring {item.name} leaves the straight line after row {row} by "
        f'{100.0 * share:.0f} % of the range of its forces: interpolation = "linear" joins '
        "rows by lines, more rows beside a kink keep the curve near them, and "
        'interpolation = "smooth" says that it is meant so'
        for item in mechanism.tabulated_springs
        if item.characteristic.interpolation is None
        for share, row in [item.characteristic.departure]
        if share > CURVE_DEPARTURE
    )
    return "; ".join(told)
