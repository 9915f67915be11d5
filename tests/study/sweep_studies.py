"""Small studies that the tests of sweeps share."""

from __future__ import annotations

from pathlib import Path

from nipper_pin.study.sweep import Plan, read_plan

TABLE = """
[samples]
method = "sobol"
count = 600
seed = 7
[parameters.speed_rpm]
low = 420.0
high = 680.0
[parameters.restitution]
low = 0.05
high = 0.25
[parameters.stiffness]
low = 7000.0
high = 11000.0
scale = "log"
[parameters.preload]
low = 9.0
high = 13.0
"""
GEOMETRY = """
chunk = 4
[parameters."points.eccentric_pin.radius_mm"]
low = 4.0
high = 6.0
points = 5
[parameters."drives.tension.ratio"]
values = [2.0, 2.2, 2.4]
[parameters.speed_rpm]
values = [450.0, 650.0]
"""


def study(folder: Path, text: str, name: str = "study") -> str:
    path = folder / f"{name}.toml"
    path.write_text(f'format = 1\ntitle = "test"\n{text}', encoding="utf-8")
    return str(path)


def plan(folder: Path, text: str) -> Plan:
    return read_plan(study(folder, text))
