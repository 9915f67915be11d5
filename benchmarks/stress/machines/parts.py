"""Parts of small machines, written out as the texts of a model: links, joints and tables."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from nipper_pin.mechanism import Mechanism, from_sources

Place = tuple[float, float]
"""(x, z) of a point [m], or a direction."""

SHAFT = {"reflected_inertia_kg_m2": 1.0, "shaft_frequency_hz": 10.0, "shaft_damping_ratio": 0.7}
SLED = {"reflected_mass_kg": 10.0, "shaft_frequency_hz": 10.0, "shaft_damping_ratio": 0.7}


@dataclass(frozen=True)
class Source:
    """A model as plain data; relative mesh paths start from the folder."""

    name: str
    urdf: str
    description: dict[str, Any]
    folder: str

    def mechanism(self) -> Mechanism:
        """Build and validate the mechanism."""
        return from_sources(self.name, self.urdf, self.description, self.folder)


def description(title: str, freedom: int, gravity: float) -> dict[str, Any]:
    """The top of a TOML document, for a cylinder at 300 r/min rated speed."""
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


def robot(name: str, parts: Sequence[str]) -> str:
    """The URDF of these links and joints; the root link ``frame`` is added."""
    return f'<robot name="{name}"><link name="frame"/>{"".join(parts)}</robot>'


def link(name: str, mass: float, inertia: float, centre: Place) -> str:
    """A link with mass [kg], moment of inertia about its centre of mass [kg m^2] and that [m]."""
    moments = " ".join(f'{axis}="{inertia!r}"' for axis in ("ixx", "iyy", "izz"))
    return (
        f'<link name="{name}"><inertial><origin xyz="{centre[0]!r} 0 {centre[1]!r}"/>'
        f'<mass value="{mass!r}"/><inertia {moments} ixy="0" ixz="0" iyz="0"/></inertial></link>'
    )


def hinge(name: str, parent: str, child: str, place: Place) -> str:
    """A hinge at a place of its parent."""
    return _joint(name, "continuous", parent, child, place, '<axis xyz="0 -1 0"/>')


def slide(name: str, parent: str, child: str, axis: Place, place: Place = (0.0, 0.0)) -> str:
    """A slide along a direction of its parent."""
    along = f'<axis xyz="{axis[0]!r} 0 {axis[1]!r}"/>'
    limit = '<limit lower="-1e9" upper="1e9" effort="1e9" velocity="1e9"/>'
    return _joint(name, "prismatic", parent, child, place, along + limit)


def frame(name: str, parent: str, place: Place, turned: float = 0.0) -> str:
    """A named frame at a place of a link, turned counter-clockwise [rad]."""
    # A rotation about +y is clockwise in the side view.
    joint = _joint(f"{name}_fixed", "fixed", parent, name, place, "", f' rpy="0 {-turned!r} 0"')
    return f'<link name="{name}"/>{joint}'


def _joint(
    name: str, kind: str, parent: str, child: str, place: Place, more: str, turned: str = ""
) -> str:
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="{place[0]!r} 0 {place[1]!r}"{turned}/>{more}</joint>'
    )
