"""Random linkages as a family of a stress campaign, and as model folders."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from nipper_pin.mechanism.drawing import Drawing, drawn_sources, write_drawing

from ..machines.draws import Draft, Generator
from ..machines.parts import Source
from .random_linkage import random_linkage


def linkage(rng: Generator) -> Draft:
    """A random linkage, and a turn or two of it with held or inertial shafts.

    Args:
        rng: Where all its numbers come from.
    """
    drawing, case = _draft(rng)
    urdf, description = drawn_sources(drawing)
    return Source(drawing.name, urdf, description, "."), case


def write_linkage(seed: int, number: int, folder: str | Path) -> dict[str, Any]:
    """Write the machine of a trial of this family as a model folder.

    Args:
        seed: Seed of a campaign of this family alone.
        number: Number of the trial in it.
        folder: Folder to write; its name becomes the model's.

    Returns:
        What is done with the machine, as arguments of :class:`~nipper_pin.Case`.

    Raises:
        InputError: The folder cannot be written or is not empty.
    """
    drawing, case = _draft(np.random.default_rng([seed, number]))
    write_drawing(drawing, folder)
    return case


def _draft(rng: Generator) -> tuple[Drawing, dict[str, Any]]:
    drawing = random_linkage(rng)
    return drawing, {
        "speed_rpm": drawing.speed_rpm, "window": "cycle", "cycles": int(rng.integers(1, 3)),
        "drive": "inertial" if rng.random() < 0.4 else "held", "max_collisions": 200,
    }  # fmt: skip
