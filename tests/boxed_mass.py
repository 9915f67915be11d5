"""A mass between the floor and the ceiling of a box that rises at constant speed."""

from __future__ import annotations

from small_machines import SLED, link, machine, slide

from nipper_pin import Mechanism

GRAVITY, HEIGHT, SPEED = 9.81, 0.2, 5.0
FLOOR, CEILING = 0.75, 0.6
MASS = 0.7


def box(sense: float, below: float) -> Mechanism:
    """Build the box; the mass hangs on a shelf until the floor hits it.

    Args:
        sense: 1 if the mass's coordinate counts upwards, -1 if downwards: then the floor is the
            upper limit.
        below: Distance of the floor below the mass at touch [m].
    """
    sides = ("lower", "upper") if sense > 0.0 else ("upper", "lower")
    floor, ceiling = (1e3 * sense * place for place in (-below, HEIGHT - below))
    return machine(
        [
            link("box"),
            slide("lift", "frame", "box", (0.0, 1.0)),
            link("mass", MASS),
            slide("height", "box", "mass", (0.0, sense)),
            link("shelf", 1e-3),
            slide("shelf_z", "frame", "shelf", (0.0, 1.0)),
            link("carriage", 1e-3),
            slide("shelf_x", "shelf", "carriage"),
        ],
        2,
        gravity=GRAVITY,
        drives={
            "lift": {
                "joint": "lift",
                "law": "screw",
                "lead_mm_per_turn": 1e3 * SPEED,
                **SLED,
            }
        },
        stops={
            "floor": {
                "joint": "height", "restitution": FLOOR, "side": sides[0], "at_mm": floor
            },
            "ceiling": {
                "joint": "height", "restitution": CEILING, "side": sides[1], "at_mm": ceiling
            },
            "shelf": {"joint": "shelf_z", "restitution": 0.0},
        },
        closures={"tie": {"frame_a": "carriage", "frame_b": "mass"}},
        phases=[
            {"number": 1, "name": "on the shelf", "closed": ["shelf"]},
            {"number": 2, "name": "free", "closed": []},
            {"number": 3, "name": "on the floor", "closed": ["floor"]},
        ],
    )  # fmt: skip
