"""Textbook linkages, each with one or two stops somewhere along its motion."""

from __future__ import annotations

from collections.abc import Callable

from ...errors import UnknownNameError
from ..drawing import Drawing
from .devices import DEVICES
from .exact_lines import EXACT_LINES
from .feeds import FEEDS
from .four_bars import FOUR_BARS
from .legs import LEGS
from .machines import MACHINES
from .presses import PRESSES
from .quick_returns import QUICK_RETURNS
from .six_bars import SIX_BARS
from .sliders import SLIDERS
from .straight_lines import STRAIGHT_LINES
from .switches import SWITCHES

GROUPS: dict[str, tuple[Callable[[], Drawing], ...]] = {
    "Four-bars": FOUR_BARS,
    "Slider-cranks and yoke": SLIDERS,
    "Quick returns": QUICK_RETURNS,
    "Toggles": PRESSES,
    "Six-bars": SIX_BARS,
    "Straight lines": STRAIGHT_LINES + EXACT_LINES,
    "Legs and parallel bars": LEGS,
    "Machines": MACHINES + FEEDS,
    "Devices": DEVICES + SWITCHES,
}
"""What draws each machine, by kind."""

GALLERY = {draw.__name__: draw for group in GROUPS.values() for draw in group}
"""What draws each machine, by its name."""


def drawn(name: str) -> Drawing:
    """The drawing of a machine of the gallery.

    Raises:
        UnknownNameError: There is no such machine.
    """
    if name not in GALLERY:
        raise UnknownNameError(kind="machine of the gallery", name=name, known=GALLERY)
    return GALLERY[name]()
