"""Machines and studies with one mistake, as reviewed texts have them, and how they are written."""

from __future__ import annotations

import shutil
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from small_machines import frame, hinge, link, slide, sources

from nipper_pin.mechanism import find_model

# A lever and a wheel on hinges, and a sled on an inclined slide.
PARTS = (
    link("lever"), hinge("pivot", "frame", "lever"), frame("a", "lever", (0.1, 0.0)),
    link("wheel"), hinge("axle", "frame", "wheel", (0.0, 0.5)), frame("c", "wheel", (0.1, 0.0)),
    link("sled"), slide("rail", "frame", "sled", (0.6, 0.8)), frame("b", "sled", (0.103, 0.004)),
)  # fmt: skip
# A spring and a drive of the small machine whose rows stand in files of their own.
ROWS = """springs.coil = { joint = "rail", file = "coil.csv" }
drives.x = { joint = "axle", law = "table", file = "x.csv" }
"""


def right(name: str) -> str:
    """A file without a mistake."""
    return (Path(__file__).with_name("right") / name).read_text(encoding="utf-8")


Edits = Sequence[str]
"""Old and new text in turn, of any file; a single text comes below the TOML."""


def model(base: str, edits: Edits, folder: Path) -> Path:
    """Write a base machine into a folder, with its edits; return the folder of the model.

    The small machine with rows has those of a spring and of a drive in files of their own.
    """
    home = folder / base.partition(" ")[0]
    if home.name == "small":
        home.mkdir()
        texts = {"small.urdf": sources(PARTS, 0)[0], "small.toml": right("small.toml")}
        if base == "small with rows":
            texts["small.toml"] += ROWS
            texts |= {name: right(name) for name in ("coil.csv", "x.csv")}
    else:
        shutil.copytree(find_model(base), home)
        texts = {path.name: path.read_text("utf-8") for path in home.glob("*.*")}
    if len(edits) == 1:
        texts[f"{home.name}.toml"] += f"{edits[0]}\n"
    else:
        texts = edited(texts, edits)
    for name, text in texts.items():
        (home / name).write_text(text, encoding="utf-8")
    return home


def edited(texts: Mapping[str, str], edits: Sequence[str]) -> dict[str, str]:
    """Texts of files with old pieces replaced by new ones, in turn; each is in one of them."""
    changed = dict(texts)
    for old, new in zip(edits[::2], edits[1::2], strict=True):
        (kind,) = (kind for kind, text in changed.items() if old in text)
        changed[kind] = changed[kind].replace(old, new, 1)
    return changed


def places(document: object, path: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """The path of everything inside a document."""
    members = document.items() if isinstance(document, dict) else ()
    for step, item in enumerate(document) if isinstance(document, list) else members:
        yield (*path, step)
        yield from places(item, (*path, step))


# Files of a study by name; a command reads the first.
STUDIES = {
    "sweep": ("sweep.toml",), "identify": ("fit.toml", "seen.csv"),
    "camera": ("fit.toml", "camera.csv"), "optimise": ("design.toml",),
}  # fmt: skip
_E62 = (find_model("e62") / "e62.toml").read_text(encoding="utf-8")
TENSION = _E62[_E62.index("[drives.tension]") : _E62.index("[springs.steeve]")]
_STOPS = right("small.toml").partition("stops.low")
# Models beside the studies: base machine and edits.
BESIDE: dict[str, tuple[str, Edits]] = {
    "two_springs": ("e62", (
        "[springs.steeve]", "[springs.second]\njoint = \"jaw\"\nstiffness_N_m_per_rad = 1.0\n"
        "preload_deg = 0.0\n\n[springs.steeve]")),
    "free": ("small", ('transition_stop = "low"\n', "", "".join(_STOPS[1:]), "")),
    "clamped_first": ("e62", ("initial_phase = 1", "initial_phase = 2")),
    "one_drive": ("e62", (TENSION, "")),
    "stop_elsewhere": ("e62", ('joint = "steeve"\nrestitution',
                               'joint = "steeve"\nat_mm = -0.5\nrestitution')),
    "third_phase": ("e62", ("initial_phase = 1", "initial_phase = 3")),
    "steeve_last": ("e62", ("initial_phase = 1", "initial_phase = 2",
                            'transition_stop = "jaw"', 'transition_stop = "steeve"')),
}  # fmt: skip
