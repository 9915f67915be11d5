"""Solids of the steeve with its springs, and of the eccentrics that it hangs from."""

from __future__ import annotations

import math

import numpy as np
from e62_part import BOSS, PLAY, Part, tension_radius
from e62_shapes import Model, Pair, both, coil, disc, plate, solid, tube


def steeve(model: Model) -> list[Part]:
    """Rod with nut below, tube with head above, and between them the spring, left and right."""
    head = model.joint["steeve"]
    length = math.hypot(*head)
    up = np.array(head) / length

    def on(distance: float) -> Pair:
        return float(up[0] * distance), float(up[1] * distance)

    y = sum(model.width("steeve_rod_left")) / 2.0
    top = 2.0 * math.hypot(*model.at("steeve_tube_left"))
    nut, end = 0.036, length - top
    rods, nuts, tubes = [], [], []
    for side in (y, -y):
        width = (side - 0.0075, side + 0.0075)
        eye = disc((0.0, 0.0), 0.0095).difference(disc((0.0, 0.0), 0.0051))
        rods += [*plate(eye, width), tube(on(0.0085), on(0.108), side, 0.005)]
        nuts += [tube(on(nut - 0.008), on(nut - 0.002), side, 0.0088, n=6),
                 tube(on(nut - 0.002), on(nut), side, 0.0095)]  # fmt: skip
        ring = disc((0.0, 0.0), model.radius("steeve_head_left"))
        ring = ring.difference(disc((0.0, 0.0), model.radius("eccentric_disc_left") + PLAY))
        tubes += [
            *plate(ring, (side - 0.009, side + 0.009)),
            tube(
                _less(head, on(length - 0.017)), _less(head, on(end + 0.001)), side, 0.009, 0.0053
            ),
            tube(_less(head, on(end + 0.004)), _less(head, on(end)), side, 0.0105, 0.0056),
        ]
    pitch = math.atan2(up[0], up[1])
    start = on(nut)
    springs = [
        Part("steeve_lower", f"spring_steeve_{name}", "spring_red",
             coil(end - nut) if name == "left" else None, file="spring",
             origin=f'xyz="{start[0]:.8f} {side:g} {start[1]:.8f}" rpy="0 {pitch!r} 0"',
             scale=f"1 1 {end - nut:.8f}")
        for name, side in (("left", y), ("right", -y))
    ]  # fmt: skip
    pin = plate(disc((0.0, 0.0), model.radius("rod_cross_pin")), model.width("rod_cross_pin"))
    return [
        Part("steeve_lower", "steeve_rods", "steeve_grey", solid(rods)),
        Part("steeve_lower", "steeve_nuts", "dark_steel", solid(nuts, pin)),
        *springs,
        Part("steeve_upper", "steeve_tubes", "steeve_grey", solid(tubes)),
    ]


def _less(head: Pair, point: Pair) -> Pair:
    """From the frame of the lower half of the steeve to that of the upper one."""
    return point[0] - head[0], point[1] - head[1]


def eccentric(model: Model) -> list[Part]:
    """Tension shaft and its two eccentrics."""
    low, _ = model.width("tension_shaft")
    shaft = disc((0.0, 0.0), tension_radius(model))
    discs = disc(model.joint["eccentric_pin_fixed"], model.radius("eccentric_disc_left"))
    return [
        Part("eccentric", "tension_shaft", "dark_steel", solid(plate(shaft, (low, BOSS + 0.002)))),
        Part("eccentric", "eccentric_discs", "drum_brass",
             solid(plate(discs.difference(shaft), *both(model.width("eccentric_disc_left"))))),
    ]  # fmt: skip
