"""The lips close up on the live page: a drawing that is sent once and moved by a style.

The view goes along the hinge and moves with the lower lip; the near half is cut away.
"""

from __future__ import annotations

import numpy as np

from ...arrays import FloatArray
from ...dynamics import multibody
from ...mechanism import Mechanism
from ...units import MM_PER_M
from ..scene import Colour, solids
from ..scene.arrows import arrow_body, arrow_place
from ..scene.film import bouncing_stop
from ..scene.lip_cuts import LipCut, lip_cuts

_WIDTH, _HEIGHT = 320.0, 180.0  # pixels
# Heights of the view and its scales [mm]; a rebound fills at most a quarter of the height.
_VIEWS_MM = ((12.0, 2.0), (25.0, 5.0), (50.0, 10.0), (100.0, 20.0), (250.0, 50.0))
_PART = 0.25
_EDGE = "#30343a"


class Lips:
    """The close-up of the transition stop of one mechanism.

    Args:
        mechanism: The mechanism; stops and springs of others may differ, not the tree.

    Attributes:
        html: The drawing; empty if the stop has no contact point.

    Raises:
        InputError: A mesh cannot be read.
    """

    def __init__(self, mechanism: Mechanism) -> None:
        """Cut the links at the contact point."""
        self.html = ""
        self._body = multibody(mechanism)
        self._cuts: list[LipCut] = []
        stop = bouncing_stop(mechanism)
        if stop is None or stop.contact is None:
            return
        self._lever = stop.lever
        self._lower = arrow_body(mechanism, stop)
        local = arrow_place(mechanism, stop)
        self._point, self._opens = local[[0, 2], 3], local[[0, 2], 1]
        drawn = solids(mechanism)
        self._cuts = lip_cuts(self._body, drawn, float(stop.contact.point[1]))
        paths = "".join(_path(cut, drawn[cut.solid].colour) for cut in self._cuts)
        self.html = (
            f'<svg id="lips" viewBox="0 0 {_WIDTH:g} {_HEIGHT:g}" role="img" '
            f'aria-label="{stop.name} along its hinge, near half cut away">{paths}'
            f'<rect class="lips-bar" y="{0.93 * _HEIGHT:g}" width="1" height="3"/></svg>'
            '<div id="lips-scale"></div>'
        )

    def style(self, q: FloatArray, gap: float, larger: float) -> str:
        """Style that moves the drawing to a configuration.

        Args:
            q: Configuration as it is drawn, shape (nv,) [rad or m].
            gap: Largest gap of the setting's rebounds, in the stop's coordinate.
            larger: Exaggeration of rebounds [-].
        """
        if not self._cuts:
            return ""
        placements = self._body.placements(q)
        turns = [item.rotation[np.ix_([0, 2], [0, 2])] for item in placements]
        places = [item.translation[[0, 2]] for item in placements]
        turn, place = np.eye(2), np.zeros(2)
        if self._lower >= 0:
            turn, place = turns[self._lower], places[self._lower]
        high_mm, bar_mm = _view(MM_PER_M * self._lever * gap * larger)
        scale = _HEIGHT / high_mm
        x, z = turn @ self._opens
        # Up on the page is the direction in which the upper lip opens.
        seen = scale * np.array([[z, -x], [-x, -z]])
        rules = [f".lips-bar {{ transform: translate({0.05 * _WIDTH:g}px) "
                 f"scale({scale * bar_mm:.3f}, 1) }}"]  # fmt: skip
        middle, contact = np.array([0.5 * _WIDTH, 0.5 * _HEIGHT]), place + turn @ self._point
        for body in sorted({cut.body for cut in self._cuts}):
            turned = seen @ turns[body]
            moved = middle + seen @ (MM_PER_M * (places[body] - contact))
            numbers = ", ".join(f"{value:.5f}" for value in (*turned.T.ravel(), *moved))
            rules.append(f".lips-{body} {{ transform: matrix({numbers}) }}")
        drawn = "true" if larger == 1.0 else f"rebounds x {larger:g}"
        rules.append(f'#lips-scale::after {{ content: "bar {bar_mm:g} mm; {drawn}" }}')
        return f"<style>{' '.join(rules)}</style>"


def _view(gap_mm: float) -> tuple[float, float]:
    """Height of the view and its scale [mm]: steps, so that they seldom change."""
    for high, bar in _VIEWS_MM:
        if gap_mm <= _PART * high:
            return high, bar
    return _VIEWS_MM[-1]


def _path(cut: LipCut, colour: Colour) -> str:
    """Outlines of a cut in mm, which its style turns and moves."""
    outlines = "".join(
        "M" + "L".join(f"{x:.3f} {z:.3f}" for x, z in (MM_PER_M * loop).tolist()) + "Z"
        for loop in cut.loops
    )
    red, green, blue = (round(255.0 * part) for part in colour)
    return (
        f'<path class="lips-{cut.body}" d="{outlines}" fill="rgb({red},{green},{blue})" '
        f'fill-rule="evenodd" stroke="{_EDGE}" vector-effect="non-scaling-stroke"/>'
    )
