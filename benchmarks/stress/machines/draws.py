"""Random numbers for the families of a stress campaign."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from nipper_pin.mechanism.edit import apply_overrides

from .parts import Source
from .small_machines import e62

Generator = np.random.Generator
Draft = tuple[Source, dict[str, Any]]
"""A model and the arguments of its case."""

JAW, STEEVE = "stops.jaw.restitution", "stops.steeve.restitution"
STIFFNESS, PRELOAD = "springs.steeve.stiffness_N_per_m", "springs.steeve.preload_length_mm"


def log(rng: Generator, low: float, high: float) -> float:
    """A number whose logarithm is uniform; the ends themselves one time in ten."""
    if rng.random() < 0.1:
        return float(rng.choice([low, high]))
    return float(10.0 ** rng.uniform(np.log10(low), np.log10(high)))


def one_of(rng: Generator, *values: float) -> float:
    """One of these numbers."""
    return float(rng.choice(values))


def sign(rng: Generator) -> float:
    """1 or -1."""
    return one_of(rng, -1.0, 1.0)


def restitution(rng: Generator) -> float:
    """Any e_N, the ends and their neighbours among them."""
    return one_of(rng, 0.0, 1e-12, 0.2, 0.5, 0.9, 0.999, 1.0, rng.uniform(), rng.uniform())


def changed(values: Mapping[str, object], source: Source | None = None) -> Source:
    """A model, by default the E62-class one, with other numbers."""
    base = source or e62()
    data, urdf = apply_overrides(base.description, base.urdf, values, base.name)
    return Source(base.name, urdf, data, base.folder)


def usual(rng: Generator) -> dict[str, object]:
    """Values that a comber may have."""
    return {
        JAW: float(rng.uniform(0.0, 0.6)),
        STEEVE: float(rng.uniform(0.0, 0.6)),
        STIFFNESS: log(rng, 3e3, 3e4),
        PRELOAD: float(rng.uniform(2.0, 20.0)),
    }


def window(rng: Generator, speed: float) -> dict[str, Any]:
    """A transition, or one or two turns."""
    case: dict[str, Any] = {"speed_rpm": speed, "max_collisions": 200}
    if rng.random() < 0.5:
        case |= {"window": "cycle", "cycles": int(rng.integers(1, 3))}
    return case
