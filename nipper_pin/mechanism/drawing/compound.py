"""Groups of parts that are common in machines with stops."""

from __future__ import annotations

from .parts import Body, Part, Pin, Slide, Spring, Stop


def telescope(
    name: str,
    points: str,
    stiffness: float,
    preload_mm: float,
    *,
    longer: bool = False,
    density_kg_m: float = 1.0,
    restitution: float = 0.2,
) -> tuple[Part, ...]:
    """A rod of two halves that a preloaded spring holds against an end stop.

    Its halves are the links ``NAME_1`` and ``NAME_2``; the slide between them, the spring and the
    end stop have the name of the rod. The first half has to hang on something already.

    Args:
        name: Name of the rod.
        points: Its two ends, the first one on the first half.
        stiffness: Of the spring [N/m].
        preload_mm: Its deflection on the end stop [mm].
        longer: Whether the rod gives way by getting longer; shorter otherwise.
        density_kg_m: Of either half [kg/m].
        restitution: Of the end stop.
    """
    first, second = points.split()
    half = f"{first}/{second}"
    return (
        Body(f"{name}_1", f"{first} {half}", density_kg_m),
        Body(f"{name}_2", f"{half} {second}", density_kg_m),
        Slide(name, f"{name}_1", f"{name}_2", half,
              f"{first} {second}" if longer else f"{second} {first}"),
        Spring(name, stiffness, preload_mm),
        Stop(name, restitution=restitution),
    )  # fmt: skip


def flap(
    name: str,
    parent: str,
    points: str,
    stiffness: float,
    preload_deg: float,
    gap_deg: float,
    *,
    density_kg_m: float = 0.5,
    restitution: float = 0.4,
) -> tuple[Part, ...]:
    """A lever that a spring holds against a stop of the link that it hangs on, with a second stop.

    The lever, its hinge, the spring and the first stop have the name; the second stop is called
    ``NAME_open``.

    Args:
        name: Name of the lever.
        parent: Link that it hangs on.
        points: Its hinge and its end.
        stiffness: Of the spring [N m/rad].
        preload_deg: Its deflection on the first stop [deg].
        gap_deg: How far the lever can turn, counter-clockwise, or clockwise if negative [deg].
        density_kg_m: Of the lever [kg/m].
        restitution: Of both stops.
    """
    sense = 1.0 if gap_deg > 0.0 else -1.0
    sides = ("lower", "upper") if gap_deg > 0.0 else ("upper", "lower")
    return (
        Body(name, points, density_kg_m),
        Pin(points.split()[0], parent, name, name),
        Spring(name, stiffness, sense * preload_deg),
        Stop(name, sides[0], 0.0, restitution),
        Stop(name, sides[1], gap_deg, restitution, f"{name}_open"),
    )
