"""Mechanisms generated in code, for questions that one model cannot answer.

* A mass that bounces on a rising table: as many collisions as the restitution allows, in closed
  form; the comber's jaw comes to no rest in a turn if its restitution is large.
* A chain of N four-bars, the planar benchmark of Gonzalez, Dopico, Lugris and Cuadrado (A
  benchmarking system for MBS simulation software, Multibody Syst. Dyn. 16, 2006; IFToMM library of
  computational benchmark problems, "N four-bar mechanism"): all links 1 m and 1 kg, one degree of
  freedom whatever N. There the chain falls freely through the configuration in which all links
  are in line and the freedom is not one; here its first crank is driven and swings about the
  vertical, so that cost and not a singularity is what is measured.
"""

from __future__ import annotations

import math
from pathlib import Path

from nipper_pin.mechanism import Mechanism, load
from nipper_pin.units import MM_PER_M

TABLE_SPEED_M_S = 0.06
_GRAVITY = 9.81
_SWING_RAD = 0.5
_BAR = '<mass value="1"/><inertia ixx="{0}" iyy="{0}" izz="{0}" ixy="0" ixz="0" iyz="0"/>'
_HINGE = '<axis xyz="0 -1 0"/></joint>\n'

_CYLINDER = """
[cylinder]
rated_speed_rpm = 60.0
direction = "counter-clockwise"
angle_at_touch_deg = 0.0
reference_index = 0.0
reference_angle_deg = 0.0
"""

_MASS_URDF = """<?xml version="1.0"?>
<robot name="bouncing_mass">
  <link name="frame"/>
  {links}
</robot>
"""
_MASS_TOML = f"""format = 1
title = "mass that bounces on a rising table"
degrees_of_freedom = 2
gravity_m_s2 = {_GRAVITY}
transition_stop = "table"
initial_phase = 1
{_CYLINDER}
[drives.table]
joint = "lift"
law = "screw"
lead_mm_per_turn = {MM_PER_M * TABLE_SPEED_M_S}
reflected_mass_kg = 10.0
shaft_frequency_hz = 10.0
shaft_damping_ratio = 0.7

[stops.table]
joint = "height"
restitution = {{restitution!r}}

[stops.shelf]
joint = "slide_z"
restitution = 0.0

[closures.tie]
frame_a = "carriage"
frame_b = "mass"

[[phases]]
number = 1
name = "on the shelf"
closed = ["shelf"]

[[phases]]
number = 2
name = "on the table"
closed = ["table"]

[[phases]]
number = 3
name = "bouncing"
closed = []
"""
# Name, parent, joint, axis, mass [kg].
_SLIDES = (
    ("table", "frame", "lift", "0 0 1", 1.0),
    ("mass", "table", "height", "0 0 1", 0.7),
    ("slide", "frame", "slide_z", "0 0 1", 1e-3),
    ("carriage", "slide", "slide_x", "1 0 0", 1e-3),
)

_CHAIN_TOML = """format = 1
title = "chain of {count} four-bars"
degrees_of_freedom = 1
gravity_m_s2 = 9.81
initial_phase = 1
{cylinder}
[drives.crank]
joint = "crank_0"
law = "fourier"
sine_rad = [{swing}]
reflected_inertia_kg_m2 = 10.0
shaft_frequency_hz = 5.0
shaft_damping_ratio = 0.7
{closures}
[[phases]]
number = 1
name = "swinging"
closed = []
"""


def bouncing_mass(folder: Path, restitution: float) -> Mechanism:
    """Write and load the bouncing mass.

    A shelf holds the mass until the table, which rises with ``TABLE_SPEED_M_S``, takes it over.

    Args:
        folder: Folder for its files; one of its own for each call.
        restitution: Restitution e of the table.
    """
    links = []
    for name, parent, joint, axis, mass in _SLIDES:
        links.append(
            f'<link name="{name}"><inertial><mass value="{mass!r}"/>'
            '<inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link>'
            f'<joint name="{joint}" type="prismatic"><parent link="{parent}"/>'
            f'<child link="{name}"/><axis xyz="{axis}"/>'
            '<limit lower="-10" upper="10" effort="1000" velocity="100"/></joint>'
        )
    urdf = _MASS_URDF.format(links="\n  ".join(links))
    return _loaded(folder, "bouncing_mass", urdf, _MASS_TOML.format(restitution=restitution))


def bouncing_mass_rest(restitution: float) -> float:
    """Time from the first collision to rest, 2 e V / (g (1 - e)) [s]."""
    return 2.0 * restitution * TABLE_SPEED_M_S / (_GRAVITY * (1.0 - restitution))


def bouncing_mass_times(restitution: float, count: int) -> list[float]:
    """Times of the first collisions, 2 e V (1 - e^k) / (g (1 - e)) [s]."""
    rest = bouncing_mass_rest(restitution)
    # expm1 keeps the digits of late collisions of a nearly elastic mass.
    return [-rest * math.expm1(k * math.log(restitution)) for k in range(count)]


def four_bar_chain(folder: Path, count: int) -> Mechanism:
    """Write and load the chain: cranks 0 to N on the ground 1 m apart, couplers 1 to N on top.

    Crank 0 swings by 0.5 rad sin psi; with parallelograms all cranks do, and couplers stay level.

    Args:
        folder: Folder for its files; one of its own for each call.
        count: Number N of four-bars, from 1.
    """
    parts = ['<?xml version="1.0"?>\n<robot name="chain">\n<link name="frame"/>\n']
    closures = []
    for number in range(count + 1):
        parts.append(_bar(f"arm_{number}", "0 0 0.5"))
        parts.append(
            f'<joint name="crank_{number}" type="continuous"><parent link="frame"/>'
            f'<child link="arm_{number}"/><origin xyz="{number} 0 0"/>{_HINGE}'
        )
        if number < count:
            parts.append(_bar(f"coupler_{number + 1}", "0.5 0 0"))
            parts.append(
                f'<joint name="pin_{number + 1}" type="continuous"><parent link="arm_{number}"/>'
                f'<child link="coupler_{number + 1}"/><origin xyz="0 0 1"/>{_HINGE}'
            )
            parts.append(_frame(f"end_{number + 1}", f"coupler_{number + 1}", "1 0 0"))
        if number > 0:
            parts.append(_frame(f"tip_{number}", f"arm_{number}", "0 0 1"))
            closures.append(
                f'[closures.pin_{number}]\nframe_a = "end_{number}"\nframe_b = "tip_{number}"\n'
            )
    parts.append("</robot>\n")
    toml = _CHAIN_TOML.format(
        count=count, cylinder=_CYLINDER, swing=_SWING_RAD, closures="\n" + "\n".join(closures)
    )
    return _loaded(folder, "chain", "".join(parts), toml)


def _bar(name: str, centre: str) -> str:
    inertial = _BAR.format(1.0 / 12.0)
    return f'<link name="{name}"><inertial><origin xyz="{centre}"/>{inertial}</inertial></link>\n'


def _frame(name: str, parent: str, place: str) -> str:
    return (
        f'<link name="{name}"/><joint name="{name}_fixed" type="fixed"><parent link="{parent}"/>'
        f'<child link="{name}"/><origin xyz="{place}"/></joint>\n'
    )


def _loaded(folder: Path, name: str, urdf: str, toml: str) -> Mechanism:
    home = folder / name
    home.mkdir(parents=True, exist_ok=True)
    (home / f"{name}.urdf").write_text(urdf, encoding="utf-8")
    (home / f"{name}.toml").write_text(toml, encoding="utf-8")
    return load(home)
