"""Solids of pendulum arm, nippers and rocker."""

from __future__ import annotations

import math

import numpy as np
from e62_part import BOSS, PLAY, SHAFT, Part
from e62_shapes import Model, bar, both, disc, plate, solid
from shapely import box
from shapely.affinity import rotate, translate
from shapely.ops import unary_union


def pendulum_arm(model: Model) -> list[Part]:
    """Arms on the pendulum shaft, and the slotted guide bar in which the crank pin slides."""
    pivot, width = model.joint["nipper_pivot"], both(model.width("pendulum_arm_left"))
    arms = bar(disc((0.0, 0.0), 0.021), disc(pivot, 0.0125))
    # Pins are placed at the joints; their collision shapes may lie a little beside them.
    radius = model.radius("nipper_pivot_pin")
    hole = disc(pivot, radius + PLAY)
    low, high = model.width("guide_bar")
    reach = model.radius("pendulum_shaft")
    slot = bar(*(disc(model.axis("guide_bar", x, 0.0), 0.0052) for x in (-0.010, 0.1275)))
    guide = bar(*(disc(model.axis("guide_bar", x, 0.0), 0.010) for x in (-0.125, 0.1275)))
    guide = unary_union([guide, disc((0.0, 0.0), reach + 0.008)]).difference(slot)
    shaft = disc((0.0, 0.0), reach)
    return [
        Part("pendulum_arm", "pendulum_arms", "steel",
             solid(plate(arms.difference(hole).difference(shaft), *width))),
        Part("pendulum_arm", "guide_bar", "dark_steel", solid(
            plate(shaft, (model.width("pendulum_shaft")[0], BOSS + 0.002)),
            plate(guide, (low, high)),
            plate(disc(pivot, radius), model.width("nipper_pivot_pin")),
        )),
    ]  # fmt: skip


def bottom_nipper(model: Model) -> list[Part]:
    """Two arms, the stiffened cushion plate with its lip, studs, and the shaft of the jaw."""
    jaw, rocker = model.joint["jaw"], model.joint["rocker_pin"]
    arms = bar(disc((0.0, 0.0), 0.0135), disc(jaw, 0.0115))
    arms = arms.difference(disc((0.0, 0.0), model.radius("nipper_pivot_pin") + PLAY))
    bracket = bar(disc(rocker, 0.0095), model.outline("bottom_stiffener").intersection(
        disc(jaw, 0.045)), disc(jaw, 0.006))  # fmt: skip
    widths = both(model.width("bottom_arm_left"))
    low, high = model.width("bottom_plate")
    plates = unary_union([model.outline("bottom_plate"), model.outline("bottom_lip")])
    shaft = disc(jaw, 0.004)
    return [
        Part("bottom_nipper", "bottom_nipper", "nipper_blue", solid(
            plate(arms, *widths),
            plate(bracket, *widths),
            plate(model.outline("bottom_stiffener").buffer(-0.0002, join_style="mitre"),
                  (low + 0.002, high - 0.002)),
        )),
        Part("bottom_nipper", "cushion_plate", "steel",
             solid(plate(plates, model.width("bottom_lip")))),
        Part("bottom_nipper", "jaw_shaft", "dark_steel", solid(
            plate(shaft, (widths[1][0] - 0.001, widths[0][1] + 0.001)),
            plate(disc(rocker, model.radius("rocker_stud_left")),
                  *both(model.width("rocker_stud_left"))),
        )),
    ]  # fmt: skip


def rocker(model: Model) -> list[Part]:
    """Front rockers: an eye on the stud, a hub on the cylinder shaft."""
    foot = model.joint["rocker_foot_fixed"]
    outline = unary_union([
        bar(disc((0.0, 0.0), 0.0085), disc(foot, 0.0085)),
        disc((0.0, 0.0), 0.0105),
        model.disc("rocker_hub_left"),
    ]).difference(disc((0.0, 0.0), model.radius("rocker_stud_left") + PLAY))  # fmt: skip
    outline = outline.difference(disc(foot, SHAFT + PLAY))
    widths = both(model.width("rocker_arm_left"))
    return [Part("rocker", "rockers", "rocker_green", solid(plate(outline, *widths)))]


def top_nipper(model: Model) -> list[Part]:
    """Two arms from the jaw shaft over the plate, lugs of the steeve's pin, and the lip."""
    rod, width = model.joint["rod_pin"], model.width("top_plate")
    plates = model.outline("top_plate")
    nose = bar(model.disc("top_lip"), plates.intersection(disc(model.at("top_lip"), 0.012)))
    tip = disc(model.axis("top_plate", 0.036, 0.001), 0.0009)
    arms = bar(disc((0.0, 0.0), 0.009), disc(rod, 0.008), tip)
    # Nothing but the hub may reach below the plate, where the bottom nipper is.
    above = box(-0.1, -0.0015, 0.1, 0.1)
    pitch = math.degrees(math.atan2(*reversed(np.subtract(
        model.axis("top_plate", 1.0, 0.0), model.at("top_plate")).tolist())))  # fmt: skip
    above = rotate(above, pitch, origin=(0.0, 0.0))
    above = translate(above, *model.at("top_plate"))
    hub = model.disc("jaw_hub")
    arms = unary_union([arms.intersection(above), disc((0.0, 0.0), 0.0085)])
    lug = bar(disc(rod, 0.0075), model.outline("rod_lug_left").intersection(above))
    lug = lug.difference(disc(rod, model.radius("rod_cross_pin") + PLAY))
    bore = disc((0.0, 0.0), 0.0041)
    inner = width[1] - 0.008
    return [
        Part("top_nipper", "top_nipper", "nipper_orange", solid(
            plate(plates, width),
            plate(arms.difference(bore).difference(disc(rod, 0.0051)), *both((inner, width[1]))),
            plate(hub.difference(bore), model.width("jaw_hub")),
            plate(lug, *both(model.width("rod_lug_left"))),
        )),
        Part("top_nipper", "top_lip", "steel", solid(plate(nose, model.width("top_lip")))),
    ]  # fmt: skip
