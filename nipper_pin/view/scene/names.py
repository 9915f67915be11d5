"""Names that stand beside links and lips in the picture."""

from __future__ import annotations

from ...mechanism import Mechanism
from .arrows import arrow_body, arrow_place
from .film import bouncing_stop
from .objects import body_path


def names(mechanism: Mechanism) -> list[dict[str, object]]:
    """Texts, the nodes that they move with, and their places in these (x, y, z) [m]."""
    model = mechanism.model
    found = []
    for body, joint in enumerate(mechanism.joints):
        centre = model.inertias[body + 1].lever
        found.append(_name(mechanism, body, joint.child, centre.tolist()))
    stop = bouncing_stop(mechanism)
    if stop is not None and stop.contact is not None:
        place = arrow_place(mechanism, stop)[:3, 3].tolist()
        found.append(_name(mechanism, arrow_body(mechanism, stop), f"contact of the {stop.name}",
                           place))  # fmt: skip
    return found


def _name(mechanism: Mechanism, body: int, text: str, place: list[float]) -> dict[str, object]:
    path = body_path(mechanism, body).split("/")
    return {"text": text.replace("_", " "), "path": path, "place": place}
