"""The commands of the campaign: small inputs, what was there before, and what each writes."""

from __future__ import annotations

import shutil
from dataclasses import dataclass
from pathlib import Path

_EXAMPLES = Path(__file__).resolve().parents[3]
_SWEEP = """
format = 1
title = "two numbers"
model = "e62"
chunk = 4
quantities = ["duration_s", "rebound_amplitude_1"]
[parameters.speed_rpm]
low = 420.0
high = 680.0
points = 6
[parameters.restitution]
values = [0.1, 0.2]
"""
_DESIGN = """
format = 1
title = "preload"
model = "e62"
minimise = ["rebound_amplitude_1", "clamping_force_N"]
case = { speed_rpm = 650.0 }
[parameters."springs.steeve.preload_length_mm"]
low = 8.0
high = 14.0
[limits]
clamping_force_N = { low = 80.0, high = 105.0 }
"""
_RUN = ["simulate", "e62", "--speed"]
_FIT = ["identify", "{in}/identify_camera.toml", "--starts", "1", "--profiles", "0"]
_FRONT = ["optimise", "{in}/design.toml", "--no-check", "--starts", "1", "--workers", "1"]
_FILM = ["view", "hanging_pendulum", "--window", "transition", "--slow"]
_LIMIT = ["study", "speed-limit", "--speeds", "2", "--turns", "2", "--json", "limit.json",
          "--plot", "limit.svg"]  # fmt: skip


@dataclass(frozen=True, kw_only=True)
class Command:
    """One command that writes.

    Attributes:
        name: Its name in the table.
        words: Its arguments; ``{in}`` is the folder of the inputs.
        before: Commands that make what is there before; nothing is there without them.
        targets: Files and folders that it writes, each whole for itself.
        parts: Pattern of files in a target that are finished one by one, and kept.
        pair: Arguments of another command that writes the same; by default those of `words`.
        kills: Its share of the kills.
        step: Only every so many of its calls are disturbed one by one.
    """

    name: str
    words: list[str]
    before: tuple[list[str], ...] = ()
    targets: tuple[str, ...] = ("out",)
    parts: str = ""
    pair: list[str] | None = None
    kills: int = 0
    step: int = 1


COMMANDS = (
    Command(
        name="simulate --out", words=[*_RUN, "650", "--out", "out"],
        before=([*_RUN, "500", "--out", "out"],), pair=[*_RUN, "600", "--out", "out"], kills=12,
    ),
    Command(
        name="simulate --out, new", words=[*_RUN, "650", "--out", "out"],
        pair=[*_RUN, "600", "--out", "out"], kills=4,
    ),
    Command(
        name="simulate --json", words=[*_RUN, "650", "--json", "run.json"],
        before=([*_RUN, "500", "--json", "run.json"],), targets=("run.json",),
        pair=[*_RUN, "600", "--json", "run.json"], kills=2,
    ),
    Command(
        name="sweep", words=["sweep", "{in}/sweep.toml", "--out", "out", "--workers", "2"],
        parts=r"plan\.json|chunks/.*", kills=8,
    ),
    Command(
        name="optimise", words=[*_FRONT, "--out", "out", "--points", "3"],
        before=([*_FRONT, "--out", "out", "--points", "2"],), parts=r"problem\.json|parts/.*",
        pair=[*_FRONT, "--out", "out", "--points", "4"], kills=5, step=5,
    ),
    Command(
        name="identify", words=[*_FIT, "--out", "machine", "--json", "fit.json"],
        targets=("machine", "fit.json"), kills=5, step=3,
    ),
    Command(
        name="study paper", words=["study", "paper", "--out", "out"],
        before=(["study", "paper", "e62_identified", "--out", "out"],),
        pair=["study", "paper", "e62_identified", "--out", "out"], kills=4, step=3,
    ),
    Command(
        name="study speed-limit", words=[*_LIMIT, "--from", "600", "--to", "700"],
        before=([*_LIMIT, "--from", "500", "--to", "550"],), targets=("limit.json", "limit.svg"),
        pair=[*_LIMIT, "--from", "650", "--to", "700"], kills=2,
    ),
    Command(
        name="view --html", words=[*_FILM, "10", "--html", "a.html"],
        before=([*_FILM, "20", "--html", "a.html"],), targets=("a.html",),
        pair=[*_FILM, "30", "--html", "a.html"],
    ),
    Command(
        name="view --gif", words=[*_FILM, "2", "--gif", "a.gif"],
        before=([*_FILM, "1", "--gif", "a.gif"],), targets=("a.gif",),
        pair=[*_FILM, "3", "--gif", "a.gif"],
    ),
    Command(name="new", words=["new", "press"], targets=("press",)),
    Command(
        name="new --from", words=["new", "press", "--from", "toggle_press"], targets=("press",)
    ),
    Command(
        name="check --json", words=["check", "e62", "--speed", "650", "--json", "check.json"],
        before=(["check", "e62", "--json", "check.json"],), targets=("check.json",),
        pair=["check", "e62", "--speed", "600", "--json", "check.json"],
    ),
    Command(
        name="plot", words=["plot", "{in}/swept", "--out", "out"],
        before=(["plot", "{in}/swept_before", "--out", "out"],),
    ),
)  # fmt: skip


def write_inputs(folder: Path) -> None:
    """Write the studies that the commands read.

    Args:
        folder: Folder to write into.
    """
    folder.mkdir()
    for name in ("identify_camera.toml", "identify_camera_measured.csv"):
        shutil.copy(_EXAMPLES / name, folder / name)
    (folder / "sweep.toml").write_text(_SWEEP, encoding="utf-8")
    before = _SWEEP.replace("[0.1, 0.2]", "[0.1, 0.25]")
    (folder / "sweep_before.toml").write_text(before, encoding="utf-8")
    (folder / "design.toml").write_text(_DESIGN, encoding="utf-8")
