"""Machines of a few lines, written out part by part."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from nipper_pin import Case, Mechanism, Resolution, Solution, Window, load, simulate
from nipper_pin.mechanism import from_sources

SHAFT = {"reflected_inertia_kg_m2": 1.0, "shaft_frequency_hz": 10.0, "shaft_damping_ratio": 0.7}
SLED = {"reflected_mass_kg": 10.0, "shaft_frequency_hz": 10.0, "shaft_damping_ratio": 0.7}
# A drive that turns joint ``shaft`` as the cylinder does.
TURNING = {"joint": "shaft", "law": "constant_speed", "ratio": 1.0, **SHAFT}


def link(
    name: str, mass: float = 1.0, inertia: float = 1.0, centre: tuple[float, float] = (0.0, 0.0)
) -> str:
    """A link with mass [kg], inertia [kg m2] and centre of mass (x, z) [m]."""
    about = " ".join(f'i{axis}="{inertia!r}"' for axis in ("xx", "yy", "zz"))
    return (
        f'<link name="{name}"><inertial><origin xyz="{centre[0]!r} 0 {centre[1]!r}"/>'
        f'<mass value="{mass!r}"/><inertia {about} ixy="0" ixz="0" iyz="0"/></inertial></link>'
    )


def hinge(name: str, parent: str, child: str, at: tuple[float, float] = (0.0, 0.0)) -> str:
    """A hinge at (x, z) of its parent [m]."""
    return _joint(name, "continuous", parent, child, at, "0 -1 0")


def slide(
    name: str,
    parent: str,
    child: str,
    axis: tuple[float, float] = (1.0, 0.0),
    at: tuple[float, float] = (0.0, 0.0),
) -> str:
    """A slide along (x, z) of its parent."""
    return _joint(name, "prismatic", parent, child, at, f"{axis[0]!r} 0 {axis[1]!r}")


def frame(name: str, parent: str, at: tuple[float, float] = (0.0, 0.0), turned: float = 0.0) -> str:
    """A named frame at (x, z) of a link [m], turned counter-clockwise [rad]."""
    fixed = _joint(f"{name}_fixed", "fixed", parent, name, at, "1 0 0")
    # A rotation about +y is clockwise in the side view.
    return f'<link name="{name}"/>' + fixed.replace("<origin ", f'<origin rpy="0 {-turned!r} 0" ')


def machine(
    parts: Sequence[str], freedom: int, *, gravity: float = 0.0, **tables: Any
) -> Mechanism:
    """Build a mechanism at 60 r/min rated speed; arguments as :func:`sources`."""
    urdf, description = sources(parts, freedom, gravity=gravity, **tables)
    return from_sources("small", urdf, description, ".")


def nipper(jaw: float, steeve: float, stiffness: float, preload: float, **more: float) -> Mechanism:
    """The E62-class model with these restitutions, and the steeve's spring [N/m] and preload [mm].

    Further numbers are called by their paths, with ``__`` for the dot.
    """
    numbers = {
        "stops.jaw.restitution": jaw,
        "stops.steeve.restitution": steeve,
        "springs.steeve.stiffness_N_per_m": stiffness,
        "springs.steeve.preload_length_mm": preload,
    }
    return load("e62", numbers | {key.replace("__", "."): more[key] for key in more})


def turn(
    mechanism: Mechanism, speed_rpm: float = 60.0, tolerance: float = 1e-12, **keys: Any
) -> Solution:
    """One turn from index 0, or what further keys of the case say."""
    given = {"window": Window.CYCLE, "start_index": 0.0, **keys}
    given.setdefault("resolution", Resolution(tolerance=tolerance))
    return simulate(mechanism, Case(speed_rpm=speed_rpm, **given))


def sources(
    parts: Sequence[str], freedom: int, *, gravity: float = 0.0, **tables: Any
) -> tuple[str, dict[str, Any]]:
    """Text of the URDF and document of the TOML of a machine at 60 r/min rated speed.

    Args:
        parts: Links and joints; the root link ``frame`` is added.
        freedom: Degrees of freedom with all stops open, drives counted.
        gravity: Along -z [m/s2].
        **tables: Further tables of the description; the first stop is the transition stop and, if
            no phases are given, the initial phase has all stops open.
    """
    stops = list(tables.get("stops", {}))
    description = {
        "format": 1,
        "title": "a small machine",
        "degrees_of_freedom": freedom,
        "gravity_m_s2": gravity,
        "initial_phase": 1,
        "transition_stop": stops[0] if stops else "",
        "cylinder": {
            "rated_speed_rpm": 60.0,
            "direction": "counter-clockwise",
            "angle_at_touch_deg": 0.0,
            "reference_index": 0.0,
            "reference_angle_deg": 0.0,
        },
        "phases": [{"number": 1, "name": "free", "closed": []}],
        **tables,
    }
    urdf = f'<robot name="small"><link name="frame"/>{"".join(parts)}</robot>'
    return urdf, description


def _joint(
    name: str, kind: str, parent: str, child: str, at: tuple[float, float], axis: str
) -> str:
    limit = '<limit lower="-1e9" upper="1e9" effort="1e9" velocity="1e9"/>'
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="{at[0]!r} 0 {at[1]!r}"/><axis xyz="{axis}"/>'
        f"{limit if kind == 'prismatic' else ''}</joint>"
    )
