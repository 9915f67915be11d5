"""Solids of the frame and of what turns in it: wall, base, rollers, cylinder."""

from __future__ import annotations

import math

import numpy as np
from e62_part import BOSS, FRONT, PLAY, SHAFT, WALL, WALL_BACK, Part, tension_radius
from e62_shapes import Model, bar, both, disc, plate, solid
from shapely import Point, Polygon, box
from shapely.ops import unary_union


def frame(model: Model) -> list[Part]:
    """Wall, base and rollers; the cylinder, which turns, stands at its angle of touch."""
    shaft, tension = model.joint["pendulum_shaft"], model.joint["tension_shaft"]
    lower, upper = (model.at(f"detaching_roller_{side}") for side in ("lower", "upper"))
    middle, floor = (0.0, 0.0), -0.127
    # Bearings of the three shafts: boss and bore.
    bearings = (
        (shaft, 0.024, model.radius("pendulum_shaft")),
        (middle, 0.020, SHAFT),
        (tension, 0.020, tension_radius(model)),
    )
    webs = ((shaft, middle), (shaft, tension), (tension, middle),
            (shaft, (shaft[0], floor)), (middle, (0.02, floor)))  # fmt: skip
    bosses = unary_union([disc(place, radius) for place, radius, _ in bearings])
    bores = unary_union([disc(place, bore + PLAY) for place, _, bore in bearings])
    wall = unary_union([bosses, *(bar(disc(a, 0.012), disc(b, 0.012)) for a, b in webs)])
    # Journals that ran to the wall would collide with the guide bar: the rollers have stands of
    # their own, outside the circle of the crank.
    foot = (0.095, 0.03)
    stand = unary_union([
        bar(disc(lower, 0.016), disc(upper, 0.016), disc(foot, 0.010)),
        bar(disc(foot, 0.010), disc((foot[0], floor), 0.010)),
    ])  # fmt: skip
    journals = unary_union([disc(lower, 0.006), disc(upper, 0.006)])
    # An open base: drawn without a graphics card, a closed one took a third of the time.
    left, right, depth = shaft[0] - 0.04, 0.11, floor - 0.008
    base = box(left, depth, right, floor)
    ends = unary_union(
        [box(left, depth, left + 0.03, floor), box(right - 0.03, depth, right, floor)]
    )
    stands = both((0.122, 0.131))
    parts = [
        Part("frame", "frame_wall", "steel", solid(
            plate(wall.difference(bores), (WALL, WALL_BACK)),
            plate(bosses.difference(bores), (WALL, BOSS)),
            plate(stand.difference(journals.buffer(PLAY)), *stands),
            plate(base, (FRONT - 0.01, FRONT + 0.02), (WALL, BOSS)),
            plate(ends, (FRONT - 0.01, BOSS)),
        ))
    ]  # fmt: skip
    for side, material, flutes in (("lower", "steel", 36), ("upper", "rubber", 0)):
        name = f"detaching_roller_{side}"
        outline = model.disc(name)
        for k in range(flutes):
            turn = math.tau * k / flutes
            x, z = (c + model.radius(name) * f(turn)
                    for c, f in zip(model.at(name), (math.cos, math.sin), strict=True))  # fmt: skip
            outline = outline.difference(Point(x, z).buffer(0.0006, quad_segs=2))
        low, high = model.width(name)
        journal = plate(disc(model.at(name), 0.006), (-0.133, 0.133))
        parts.append(Part("frame", name, material, solid(plate(outline, (low, high)), journal)))
    return parts + cylinder(model)


def cylinder(model: Model) -> list[Part]:
    """Crankshaft, drum and comb segment, at the cylinder angle of the touch configuration."""
    drive = model.toml["drives"]["pendulum"]
    touch = math.radians(model.toml["cylinder"]["angle_at_touch_deg"])
    radius = 1e-3 * drive["crank_radius_mm"]
    pin = (radius * math.cos(touch), radius * math.sin(touch))
    low, high = model.width("guide_bar")
    inner, outer = (low - 0.0075, low - 0.0015), (high + 0.0015, high + 0.0065)
    web = bar(disc((0.0, 0.0), 0.016), disc(pin, 0.011))
    shaft = disc((0.0, 0.0), SHAFT)
    crank = solid(
        plate(shaft, (FRONT, inner[0]), (outer[1], BOSS + 0.002)),
        plate(web, inner, outer),
        plate(disc(pin, 0.005), (inner[0], outer[1])),
    )
    rim = model.radius("cylinder_drum")
    holes = [disc((0.032 * math.cos(a), 0.032 * math.sin(a)), 0.011)
             for a in np.linspace(0.0, math.tau, 6)[:-1]]  # fmt: skip
    face = disc((0.0, 0.0), rim - 0.0105).difference(unary_union([shaft, *holes]))
    side = model.width("cylinder_drum")[1] - 0.001
    # The needles pass under the lips while the nipper is at its rear end, where the guide bar
    # touches the circle of the crank pin: the first of two such places after the jaw has closed.
    axis = np.subtract(drive["guide_axis_mm"], drive["crank_axis_mm"])
    offset, away = drive.get("guide_offset_mm", 0.0), math.hypot(*axis)
    rear = [
        math.atan2(axis[1], axis[0])
        + sign * math.acos((drive["crank_radius_mm"] + sign * offset) / away)
        for sign in (1.0, -1.0)
    ]
    centre = 0.5 * math.pi + min((touch - psi) % math.tau for psi in rear)
    half, rows = math.radians(50.0), 17
    sector = Polygon([(0.0, 0.0), *((0.1 * math.cos(centre + a), 0.1 * math.sin(centre + a))
                                    for a in np.linspace(-half, half, 9))])  # fmt: skip
    comb = disc((0.0, 0.0), rim - 0.0045).difference(disc((0.0, 0.0), rim - 0.012))
    comb = comb.intersection(sector)
    teeth = []
    for a in np.linspace(-half + 0.05, half - 0.05, rows):
        # Needles lean forward, in the sense in which the cylinder turns.
        corners = [(rim - 0.006, 0.028), (rim - 0.0001, -0.018), (rim - 0.006, -0.012)]
        teeth.append(Polygon([(r * math.cos(centre + a + b), r * math.sin(centre + a + b))
                              for r, b in corners]))  # fmt: skip
    return [
        Part("frame", "cylinder_shaft", "dark_steel", crank),
        Part("frame", "cylinder_drum", "drum_brass", solid(plate(face, (-side, side)))),
        Part("frame", "cylinder_comb", "steel",
             solid(plate(unary_union([comb, *teeth]), (-side, side)))),
    ]  # fmt: skip
