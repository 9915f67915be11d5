"""A mechanism in one line, and as a notebook shows it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..notebook import html

if TYPE_CHECKING:
    from .mechanism import Mechanism


def line(mechanism: Mechanism) -> str:
    """One line.

    Args:
        mechanism: The mechanism.
    """
    stops = ", ".join(stop.name for stop in mechanism.stops)
    return (
        f"<Mechanism {mechanism.name}: {len(mechanism.joints)} joints, "
        f"{len(mechanism.closures)} closures, {len(mechanism.drives)} drives, "
        f"stops {stops or 'none'}, mobility {mechanism.degrees_of_freedom}>"
    )


def page(mechanism: Mechanism) -> str:
    """HTML: what it is, and its joints.

    Args:
        mechanism: The mechanism.
    """
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
