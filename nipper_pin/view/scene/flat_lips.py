"""The lips close up in the pictures of a GIF: a cut through all links at the contact point."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from PIL import Image, ImageDraw

from ...arrays import FloatArray
from ...units import MM_PER_M
from .closeup import CloseUp
from .film import Film
from .flat import placed
from .lip_cuts import lip_cuts
from .solids import Solid

_EDGE, _INK, _PAPER, _FRAME = "#30343a", "#101418", "white", "#c5ccd6"


class LipsPainter:
    """Draws the close-up of every frame.

    Args:
        shown: The film.
        drawn: What the mechanism is drawn with.
        lips: The close-up.
        size: Width and height of the picture [pixels].
    """

    def __init__(
        self, shown: Film, drawn: Sequence[Solid], lips: CloseUp, size: tuple[int, int]
    ) -> None:
        """Cut all solids of moving links."""
        self._shown, self._lips, self._size = shown, lips, size
        self._cuts = lip_cuts(shown.solution.system.body, drawn, lips.across)

    def picture(self, frame: int, colours: Sequence[str]) -> Image.Image:
        """The close-up of one frame.

        Args:
            frame: Place of the frame in the film.
            colours: Colours of the solids as in #RRGGBB.
        """
        image = Image.new("RGB", self._size, _PAPER)
        draw = ImageDraw.Draw(image)
        for cut in self._cuts:
            for number, loop in enumerate(cut.loops):
                corners = self._pixels(placed(self._shown, frame, cut.body, loop), frame)
                # Holes lie inside of the largest outline.
                hole = number and _inside(loop, cut.loops[0])
                fill = _PAPER if hole else colours[cut.solid]
                draw.polygon(corners, fill=fill)
                draw.line([*corners, corners[0]], fill=_EDGE, width=2)
        self._scale(draw)
        draw.rectangle((0, 0, self._size[0] - 1, self._size[1] - 1), outline=_FRAME, width=2)
        return image

    def _scale(self, draw: ImageDraw.ImageDraw) -> None:
        """A bar as long as the scale."""
        width, height = self._size
        long = self._lips.scale_mm / MM_PER_M / self._lips.height * height
        left, low = 0.05 * width, 0.93 * height
        draw.rectangle((left, low, left + long, low + 0.02 * height), fill=_INK)

    def _pixels(self, points: FloatArray, frame: int) -> list[tuple[float, float]]:
        """Places in the picture: the opening direction is up, the contact point in the middle."""
        width, height = self._size
        angle = float(self._lips.angle[frame]) - 0.5 * math.pi
        cos, sin = math.cos(angle), math.sin(angle)
        x, z = (points - self._lips.place[frame]).T * (height / self._lips.height)
        right, up = cos * x + sin * z, -sin * x + cos * z
        return list(zip((0.5 * width + right).tolist(), (0.5 * height - up).tolist(), strict=True))


def _inside(loop: FloatArray, outer: FloatArray) -> bool:
    """Whether an outline lies inside of another one, by its first point."""
    x, z = loop[0]
    x1, z1 = outer.T
    x2, z2 = np.roll(outer, -1, axis=0).T
    crosses = (z1 > z) != (z2 > z)
    at = x1[crosses] + (z - z1[crosses]) / (z2[crosses] - z1[crosses]) * (x2 - x1)[crosses]
    return bool((at > x).sum() % 2)
