"""Words and numbers that readers stumble over."""

from __future__ import annotations

import random
import re

NUMBERS = (
    "0", "-0.0", "1", "-1", "2", "7", "nan", "inf", "-inf", "1e400", "1e308", "-1e308", "5e-324",
    "1e-300", "1e15", "1e16", "1e9", "1e6", "360", "3600", "-3600", "90", "180", "40", "65536",
    "4294967296", "9223372036854775807", "9223372036854775808", "9" * 30, "1_000", "0x10", "0b1",
    "0.1", "1e-9", "1e-12", "1e-13", ".5", "5.", "+1", "--1", "1,5", "\u0663", "1e+5",
)  # fmt: skip
TEXTS = (
    "", " ", "a", "jaw", "steeve", "anvil", "frame", "h0", "s0", "lh0", "ball", "e62", "parts", ".",
    "..", "/", "../x", "/etc/hostname", "http://127.0.0.1:9/x", "file:///etc/hostname", "true",
    "package://parts/meshes/tetrahedron.stl", "meshes/tetrahedron.stl", "meshes", "\u00e9",
    "\u202e", "\U0001f600", "x" * 300, "a.b", "a..b", "links.lh0.mass_kg", "points.h0.x_mm",
    "revolute", "prismatic", "fixed", "continuous", "floating", "table", "cam", "geared", "screw",
    "fourier", "constant_speed", "oscillating_guide", "falling", "orifice", "mesh", "box", "0 0",
    "0 0 0", "0 1 0", "0 -1 0", "1 0 0 1", "0 3.141592653589793 0", "held", "inertial", "cycle",
    "speed_rpm", "duration_s", "t.csv", "\\", "%s", "{}", "-", "clockwise", "maximum", "x", "z",
)  # fmt: skip
_NUMBER = re.compile(r"[-+]?(?:[0-9][0-9_]*\.?[0-9]*|\.[0-9]+)(?:[eE][-+]?[0-9]+)?")


def other_number(text: str, chance: random.Random) -> str:
    """A number like this one, or one that readers stumble over."""
    if chance.random() < 0.5:
        return chance.choice(NUMBERS)
    try:
        value = float(text)
    except ValueError:
        return chance.choice(NUMBERS)
    factor = chance.choice((-1.0, 0.0, 0.5, 2.0, 10.0, 1e3, 1e-3, 1e-9, 1e12, 1.0 + 1e-9))
    return repr(factor * value + chance.choice((0.0, 0.0, 1.0, -1.0)))


def other_text(text: str, chance: random.Random) -> str:
    """A text with one of its numbers changed, or another text."""
    found = list(_NUMBER.finditer(text))
    if found and chance.random() < 0.8:
        place = chance.choice(found)
        return text[: place.start()] + other_number(place.group(), chance) + text[place.end() :]
    return chance.choice((*TEXTS, *NUMBERS))
