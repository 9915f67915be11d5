"""Small machines of a stress campaign, written out as the two texts of a model.

They are simple enough that what they ought to do is known, and their numbers go where those of a
comber cannot: a four-bar through its dead centre, flaps that leave their stops together, a mass on
a table that hardly rises.
"""

from __future__ import annotations

import copy
from dataclasses import dataclass
from functools import cache
from math import sqrt
from typing import Any

from ...mechanism import load


@dataclass(frozen=True)
class Source:
    """A model as plain data.

    Attributes:
        name: Name of the model.
        urdf: The URDF text.
        description: The TOML document.
        folder: Folder that relative mesh paths start from.
    """

    name: str
    urdf: str
    description: dict[str, Any]
    folder: str


@cache
def _e62() -> Source:
    mechanism = load("e62")
    return Source(
        mechanism.name, mechanism.urdf, dict(mechanism.description), mechanism.mesh_folder
    )


def e62() -> Source:
    """The E62-class model of the package, an estimate of that class of machine."""
    source = _e62()
    return Source(source.name, source.urdf, copy.deepcopy(source.description), source.folder)


def four_bar(
    ground: float, crank: float, coupler: float, rocker: float, masses: tuple[float, float, float]
) -> Source:
    """A four-bar with a driven crank; at q = 0 the crank points at the rocker's axis.

    With the crank at half a turn its pin is ``ground + crank`` away from that axis, so a coupler
    and a rocker that are as long together stand in their dead centre there.

    Args:
        ground: Distance of the two axes [m]; the links' lengths follow.
        crank: Length of the crank [m].
        coupler: Length of the coupler [m].
        rocker: Length of the rocker [m].
        masses: Of crank, coupler and rocker [kg].
    """
    base = ground - crank
    x = (coupler**2 + base**2 - rocker**2) / (2.0 * base)
    z = sqrt(max(coupler**2 - x**2, 0.0))
    first, second, third = masses
    parts = [
        _link("crank", first, 1e-4 * first, (0.5 * crank, 0.0)),
        _hinge("crank_axis", "frame", "crank", (0.0, 0.0)),
        _link("coupler", second, 1e-3 * second, (0.5 * x, 0.5 * z)),
        _hinge("crank_pin", "crank", "coupler", (crank, 0.0)),
        _frame("coupler_end", "coupler", (x, z)),
        _link("rocker", third, 1e-3 * third, (0.5 * (x - base), 0.5 * z)),
        _hinge("rocker_axis", "frame", "rocker", (ground, 0.0)),
        _frame("rocker_end", "rocker", (x - base, z)),
    ]
    description = _description("four-bar with a driven crank", 1, 9.81)
    description["drives"] = {
        "crank": {"joint": "crank_axis", "law": "constant_speed", "ratio": 1.0, **_SHAFT}
    }
    description["closures"] = {"coupler_pin": {"frame_a": "coupler_end", "frame_b": "rocker_end"}}
    description["phases"] = [{"number": 1, "name": "running", "closed": []}]
    return Source("four_bar", _robot("four_bar", parts), description, ".")


def flaps(
    count: int,
    swing: tuple[float, ...],
    restitution: float,
    stiffness: float,
    preload_deg: float,
    gravity: float,
) -> Source:
    """Equal flaps on an arm that swings; each lies on a stop of its own, and all leave it at once.

    Args:
        count: Number of flaps.
        swing: Cosine coefficients of the arm's angle, shape (n,) [rad].
        restitution: e_N of every stop.
        stiffness: Of the springs that press them shut [N m/rad].
        preload_deg: Their deflection on the stops [deg].
        gravity: Acceleration along -z [m/s^2].
    """
    names = [f"flap{number}" for number in range(1, count + 1)]
    parts = [_link("arm", 1.0, 1e-3, (0.05, 0.0)), _hinge("arm_axis", "frame", "arm", (0.0, 0.0))]
    for name in names:
        parts.append(_link(f"{name}_plate", 0.3, 2e-4, (0.04, 0.0)))
        parts.append(_hinge(name, "arm", f"{name}_plate", (0.1, 0.0)))
    description = _description("flaps on a swinging arm", 1 + count, gravity)
    description["drives"] = {
        "arm": {"joint": "arm_axis", "law": "fourier", "cosine_rad": list(swing), **_SHAFT}
    }
    description["springs"] = {
        name: {"joint": name, "stiffness_N_m_per_rad": stiffness, "preload_deg": preload_deg}
        for name in names
    }
    description["stops"] = {name: {"joint": name, "restitution": restitution} for name in names}
    description["transition_stop"] = names[0]
    description["phases"] = [
        {"number": 1, "name": "on the stops", "closed": names},
        {"number": 2, "name": "open", "closed": []},
    ]
    return Source("flaps", _robot("flaps", parts), description, ".")


def bouncing_mass(mass: float, lead_mm: float, restitution: float, gravity: float) -> Source:
    """A mass on a shelf that a table takes off at constant speed; then it bounces on the table.

    Args:
        mass: Of the bouncing body [kg]; the slides that tie it to the shelf have 1e-3 kg.
        lead_mm: Rise of the table in a turn [mm].
        restitution: e_N of the table.
        gravity: Acceleration along -z [m/s^2].
    """
    parts = [
        _link("table", 1.0, 1e-2, (0.0, 0.0)),
        _slide("lift", "frame", "table", "0 0 1"),
        _link("mass", mass, 1e-2 * mass, (0.0, 0.0)),
        _slide("height", "table", "mass", "0 0 1"),
        _link("slide", 1e-3, 1e-5, (0.0, 0.0)),
        _slide("slide_z", "frame", "slide", "0 0 1"),
        _link("carriage", 1e-3, 1e-5, (0.0, 0.0)),
        _slide("slide_x", "slide", "carriage", "1 0 0"),
    ]
    description = _description("bouncing mass on a rising table", 2, gravity)
    description["drives"] = {
        "table": {
            "joint": "lift",
            "law": "screw",
            "lead_mm_per_turn": lead_mm,
            "reflected_mass_kg": 10.0,
            "shaft_frequency_hz": 10.0,
            "shaft_damping_ratio": 0.7,
        }
    }
    description["stops"] = {
        "table": {"joint": "height", "restitution": restitution},
        "shelf": {"joint": "slide_z", "restitution": 0.0},
    }
    description["transition_stop"] = "table"
    description["closures"] = {"tie": {"frame_a": "carriage", "frame_b": "mass"}}
    description["phases"] = [
        {"number": 1, "name": "on the shelf", "closed": ["shelf"]},
        {"number": 2, "name": "on the table", "closed": ["table"]},
        {"number": 3, "name": "bouncing", "closed": []},
    ]
    return Source("bouncing_mass", _robot("bouncing_mass", parts), description, ".")


_SHAFT = {"reflected_inertia_kg_m2": 1.0, "shaft_frequency_hz": 10.0, "shaft_damping_ratio": 0.7}


def _description(title: str, freedom: int, gravity: float) -> dict[str, Any]:
    return {
        "format": 1,
        "title": title,
        "degrees_of_freedom": freedom,
        "gravity_m_s2": gravity,
        "initial_phase": 1,
        "cylinder": {
            "rated_speed_rpm": 300.0,
            "direction": "counter-clockwise",
            "angle_at_touch_deg": 0.0,
            "reference_index": 0.0,
            "reference_angle_deg": 0.0,
        },
    }


def _robot(name: str, parts: list[str]) -> str:
    return f'<robot name="{name}"><link name="frame"/>{"".join(parts)}</robot>'


def _link(name: str, mass: float, inertia: float, center: tuple[float, float]) -> str:
    moments = " ".join(f'{axis}="{inertia!r}"' for axis in ("ixx", "iyy", "izz"))
    return (
        f'<link name="{name}"><inertial><origin xyz="{center[0]!r} 0 {center[1]!r}"/>'
        f'<mass value="{mass!r}"/><inertia {moments} ixy="0" ixz="0" iyz="0"/></inertial></link>'
    )


def _hinge(name: str, parent: str, child: str, place: tuple[float, float]) -> str:
    return (
        f'<joint name="{name}" type="continuous"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="{place[0]!r} 0 {place[1]!r}"/><axis xyz="0 -1 0"/></joint>'
    )


def _slide(name: str, parent: str, child: str, axis: str) -> str:
    return (
        f'<joint name="{name}" type="prismatic"><parent link="{parent}"/><child link="{child}"/>'
        f'<axis xyz="{axis}"/><limit lower="-10" upper="10" effort="1000" velocity="100"/></joint>'
    )


def _frame(name: str, parent: str, place: tuple[float, float]) -> str:
    return (
        f'<link name="{name}"/><joint name="{name}_fixed" type="fixed"><parent link="{parent}"/>'
        f'<child link="{name}"/><origin xyz="{place[0]!r} 0 {place[1]!r}"/></joint>'
    )
