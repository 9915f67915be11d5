"""Machines with a pin in a slot that throw a flap against stops on both sides."""

from __future__ import annotations

from math import atan2, hypot

from .chains import Chain
from .draws import Generator, log
from .parts import SHAFT, Place, frame, hinge, link


def slotted_lever(rng: Generator, radius: float, axis: Place, block: float) -> Chain:
    """A crank pin in the slot of a lever, with a flap hinged to the lever.

    With the lever's axis just inside or outside the circle of the pin the lever turns over in no
    time: the pin passes its axis, which is the dead centre of this machine.

    Args:
        rng: Where the numbers of the flap come from.
        radius: Of the crank [m], which points along x at touch.
        axis: Of the lever (x, z) [m].
        block: Mass of the block in the slot [kg].
    """
    machine = Chain(freedom=1)
    x, z = radius - axis[0], -axis[1]
    machine.parts += [
        link("crank", 2.0, 0.01, (0.01, 0.0)), hinge("shaft", "frame", "crank", (0.0, 0.0)),
        frame("crank_pin", "crank", (radius, 0.0)),
        link("lever", 1.0, 0.02, (0.05, 0.0)), hinge("lever_axis", "frame", "lever", axis),
        frame("slot_line", "lever", (0.0, 0.0), atan2(z, x)),
    ]  # fmt: skip
    drive = {"joint": "shaft", "law": "constant_speed", "ratio": 1.0, **SHAFT}
    machine.tables["drives"]["shaft"] = drive
    machine.tables["closures"]["slot"] = {
        "frame_a": "slot_line", "frame_b": "crank_pin", "slot_axis": "x", "block_mass_kg": block,
    }  # fmt: skip
    machine.links.append(("lever", axis))
    mass = log(rng, 1e-2, 10.0)
    arm = hypot(x, z)
    machine.parts += [
        link("flap", mass, mass * (0.3 * arm) ** 2, (0.5 * arm, 0.1 * arm)),
        hinge("flap", "lever", "flap", (x, z)),
    ]
    machine.joints["flap"] = True
    machine.links.append(("flap", (radius, 0.0)))
    machine.freedom += 1
    machine.mass = mass
    return machine
