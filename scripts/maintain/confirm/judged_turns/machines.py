"""Random geometries of combers and linkages, and random cases of each."""

from __future__ import annotations

import tomllib
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np

from nipper_pin import Mechanism, NipperError, export, load
from nipper_pin.mechanism.edit import read_layout
from nipper_pin.mechanism.gallery import GALLERY, drawn

MODELS = Path(__file__).resolve().parents[4] / "models"
# Combers: the first in each two of four geometries, then the others in turn; then the gallery.
_E62, _OTHERS = "e62", ("e62_identified", "e62_offset_guide", "hanging_pendulum")
_KINDS = ("e62", "e62", "other", "gallery")
# Points that the frame or the drives hold are moved by the drives' own numbers only.
_FREE = ("nipper_pivot", "rocker_pin", "rod_pin", "rod_end", "rod_bracket")
_DRAWS, _WITH_TIMING = 40, 0.5


@dataclass(frozen=True)
class Setting:
    """One case: what is a number of a run on the reduced engine.

    Attributes:
        speed_rpm: Cylinder speed.
        turns: Number of turns.
        values: Restitutions, spring rates and preloads by their paths.
    """

    speed_rpm: float
    turns: int
    values: dict[str, float]


@dataclass(frozen=True)
class Geometry:
    """A machine: a model folder and the numbers that are changed in it."""

    label: str
    folder: Path
    changes: dict[str, float]

    def mechanism(self, values: dict[str, float] | None = None) -> Mechanism:
        """The machine, with the numbers of a case."""
        return load(self.folder, {**self.changes, **(values or {})})


def geometry(seed: int, number: int, home: Path) -> Geometry:
    """The random geometry of that number, which its loader accepts.

    Args:
        seed: Seed of all.
        number: Number from 0.
        home: Where machines of the gallery are written.
    """
    random = np.random.default_rng([seed, number])
    kind = _KINDS[number % len(_KINDS)]
    for draw in range(_DRAWS):
        if kind == "gallery":
            name = str(random.choice(sorted(GALLERY)))
            folder = home / name
            if not folder.exists():
                export(drawn(name).mechanism(), folder)
            return Geometry(name, folder, {})
        name = _E62 if kind == "e62" else _OTHERS[number // len(_KINDS) % len(_OTHERS)]
        found = Geometry(f"{name} {number}", MODELS / name, _changes(random, MODELS / name, draw))
        try:
            found.mechanism()
        except NipperError:
            continue
        return found
    message = f"none of {_DRAWS} draws of geometry {number} can be loaded"
    raise RuntimeError(message)


def _changes(random: np.random.Generator, folder: Path, draw: int) -> dict[str, float]:
    """Points moved by some millimetres, masses, timing and drive changed by some per cent.

    Where draws fail, later ones change less, and leave the timing as it is.
    """
    size = 1.0 - draw / _DRAWS
    document, root = _read(folder)
    layout = read_layout(root, document, folder.name)
    changes: dict[str, float] = {}
    for name in layout.points:
        if name in _FREE:
            for axis, place in zip(("x_mm", "z_mm"), layout.point_mm(name), strict=True):
                changes[f"points.{name}.{axis}"] = place + size * float(random.normal(0.0, 2.0))
    for link in root.iter("link"):
        mass = link.find("inertial/mass")
        if mass is not None:
            path = f"links.{link.get('name')}.mass_kg"
            changes[path] = float(mass.get("value", "1")) * float(random.uniform(0.6, 1.6))
    touch = document["cylinder"]["angle_at_touch_deg"]
    turned = float(random.uniform(-12.0, 12.0))
    if size > _WITH_TIMING:
        changes["cylinder.angle_at_touch_deg"] = touch + turned
    for name, drive in document["drives"].items():
        if drive["law"] == "geared":
            changes[f"drives.{name}.ratio"] = drive["ratio"] * float(random.uniform(0.9, 1.1))
    return changes


def setting(seed: int, number: int, case: int, machine: Geometry) -> Setting:
    """The random case of that number."""
    random = np.random.default_rng([seed, number, case])
    document, _ = _read(machine.folder)
    rated = float(document["cylinder"]["rated_speed_rpm"])
    values: dict[str, float] = {}
    for name in document["stops"]:
        values[f"stops.{name}.restitution"] = 0.02 * 40.0 ** float(random.uniform())
    for name, spring in document.get("springs", {}).items():
        for key, low, high in (("stiffness", 0.5, 1.6), ("preload", 0.2, 1.6)):
            for own, value in spring.items():
                if own.startswith(key) and isinstance(value, int | float):
                    factor = float(random.uniform(low, high))
                    values[f"springs.{name}.{own}"] = float(value) * factor
    return Setting(
        rated * 0.4 * 11.0 ** float(random.uniform()), int(random.integers(1, 4)), values
    )


def _read(folder: Path) -> tuple[dict[str, Any], ElementTree.Element]:
    document = tomllib.loads((folder / f"{folder.name}.toml").read_text(encoding="utf-8"))
    root = ElementTree.fromstring((folder / f"{folder.name}.urdf").read_text(encoding="utf-8"))
    return document, root
