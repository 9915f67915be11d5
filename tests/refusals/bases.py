"""Machines of which models with one mistake are made."""

from __future__ import annotations

import shutil
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

from small_machines import frame, hinge, link, slide, sources

from nipper_pin.mechanism import find_model

# A lever and a wheel on hinges, and a sled on an inclined slide.
PARTS = (
    link("lever"), hinge("pivot", "frame", "lever"), frame("a", "lever", (0.1, 0.0)),
    link("wheel"), hinge("axle", "frame", "wheel", (0.0, 0.5)), frame("c", "wheel", (0.1, 0.0)),
    link("sled"), slide("rail", "frame", "sled", (0.6, 0.8)), frame("b", "sled", (0.103, 0.004)),
)  # fmt: skip
SMALL = """format = 1
title = "a lever, a wheel and a sled"
degrees_of_freedom = 3
gravity_m_s2 = 9.81
transition_stop = "low"
initial_phase = 1
cylinder = { rated_speed_rpm = 60.0, direction = "clockwise", angle_at_touch_deg = 0.0, \
reference_index = 0.0, reference_angle_deg = 0.0 }
phases = [{ number = 1, name = "free", closed = [] }]
stops.low = { joint = "pivot", restitution = 0.1, at_deg = -20.0 }
stops.high = { joint = "pivot", restitution = 0.1, side = "upper", at_deg = 30.0 }
stops.end = { joint = "rail", restitution = 0.1, at_mm = -4.0 }
"""


Edits = str | Sequence[str]
"""Old and new text in turn, of either file; a single text comes below the TOML."""


class Row(NamedTuple):
    """A mistake that lies in other files of the folder."""

    edits: Edits
    files: Mapping[str, bytes]


def model(base: str, edits: Edits, folder: Path) -> Path:
    """Write a base machine into a folder, with its edits; return the folder of the model."""
    home = folder / base
    if base == "small":
        home.mkdir()
        (home / "small.urdf").write_text(sources(PARTS, 0)[0], encoding="utf-8")
        (home / "small.toml").write_text(SMALL, encoding="utf-8")
    else:
        shutil.copytree(find_model(base), home)
    texts = {kind: home / f"{base}.{kind}" for kind in ("toml", "urdf")}
    changed = {kind: path.read_text(encoding="utf-8") for kind, path in texts.items()}
    if isinstance(edits, str):
        changed["toml"] += edits + "\n"
        edits = ()
    changed = edited(changed, edits)
    for kind, path in texts.items():
        path.write_text(changed[kind], encoding="utf-8")
    return home


def edited(texts: Mapping[str, str], edits: Sequence[str]) -> dict[str, str]:
    """Texts of files with old pieces replaced by new ones, in turn; each is in one of them."""
    changed = dict(texts)
    for old, new in zip(edits[::2], edits[1::2], strict=True):
        (kind,) = (kind for kind, text in changed.items() if old in text)
        changed[kind] = changed[kind].replace(old, new, 1)
    return changed
