"""Textbook linkages, each with one or two stops somewhere along its motion: one drawing each."""

from __future__ import annotations

from pathlib import Path

from ...errors import looked_up
from ..drawing import Drawing

GROUPS: dict[str, tuple[str, ...]] = {
    "Four-bars": ("crank_rocker", "double_crank", "double_rocker", "triple_rocker"),
    "Slider-cranks and yoke": (
        "slider_crank",
        "slider_crank_offset",
        "oscillating_cylinder",
        "scotch_yoke",
    ),
    "Quick returns": ("whitworth", "crank_shaper", "drag_link"),
    "Toggles": ("toggle_press", "knuckle_press", "moulding_machine", "jaw_crusher", "riveter"),
    "Six-bars": ("watt_1", "watt_2", "stephenson_1", "stephenson_2", "stephenson_3"),
    "Straight lines": (
        "hoeken",
        "chebyshev",
        "roberts",
        "watt_line",
        "scott_russell",
        "peaucellier",
        "evans",
    ),
    "Legs and parallel bars": ("klann", "jansen", "pantograph", "scissors_lift", "wiper"),
    "Machines": (
        "drop_hammer",
        "pump_jack",
        "loom_sley",
        "sieve",
        "needle_bar",
        "ratchet_feed",
        "film_claw",
    ),
    "Devices": (
        "valve_train",
        "door_closer",
        "piano_key",
        "circuit_breaker",
        "relay",
        "bell",
        "doorbell",
    ),
}
"""Names of the machines, by kind."""

GALLERY = {
    name: Path(__file__).with_name(f"{name}.toml") for group in GROUPS.values() for name in group
}
"""The file that draws each machine, by its name."""


def drawn(name: str) -> Drawing:
    """The drawing of a machine of the gallery.

    Raises:
        UnknownNameError: There is no such machine.
    """
    return Drawing.load(file_of(name))


def file_of(name: str) -> Path:
    """The file that draws a machine of the gallery; errors as of :func:`drawn`."""
    return looked_up("machine of the gallery", name, GALLERY)
