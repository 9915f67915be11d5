"""Colours of arrows, lines and links, from Okabe and Ito's palette."""

from __future__ import annotations

ARROW = STOP = "#D55E00"
SPRING = "#B00020"
LINE = "#6B7480"
_FRAME = "#9AA0A8"
# Of links whose URDF says nothing: apart from one another, and paler than phases and arrows.
_LINKS = ("#6E8FB8", "#B8A16E", "#7FA889", "#A58BB0", "#B08A7E", "#7FA6AC", "#8C8FA8")


def channels(colour: str) -> tuple[float, float, float]:
    """Red, green and blue of #RRGGBB, 0 to 1."""
    red, green, blue = bytes.fromhex(colour.removeprefix("#"))
    return red / 255.0, green / 255.0, blue / 255.0


def link_colour(body: int) -> tuple[float, float, float]:
    """Red, green and blue of a link without a material, by its place; grey for what stands."""
    return channels(_LINKS[body % len(_LINKS)] if body >= 0 else _FRAME)
