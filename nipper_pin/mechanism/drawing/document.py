"""The TOML document of a drawing: shaft, closures and phases, beside the tables of the model."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ...errors import meant
from .read import Tree, grown, read
from .urdf_text import LINE, frame_name, urdf_text

# Of a model's file, in the order in which they are written.
_SECTIONS = ("drives", "springs", "dampers", "forces", "initial", "stops")


def drawn_sources(tables: Mapping[str, Any], name: str) -> tuple[str, dict[str, Any]]:
    """The URDF and the TOML document of a drawing, as plain data."""
    tree = grown(read(tables, name))
    return urdf_text(tree), document(tree)


def document(tree: Tree) -> dict[str, Any]:
    """The TOML document of a drawing as plain data."""
    drawn = tree.drawn
    table, model = drawn.table, drawn.model
    given = {section: _with_frames(tree, section) for section in _SECTIONS}
    stops, springs = given.pop("stops"), given["springs"]
    struck = table.transition_stop or next(iter(stops), "")
    for key, names in (("closed", table.closed), ("transition_stop", (struck,) if struck else ())):
        for name in names:
            if name not in stops:
                allowed = f"{meant(name, stops)}a stop: {', '.join(stops) or 'there is none'}"
                drawn.refuse(key, name, allowed)
    slots = sum(cut.slot is not None for cut in tree.cut.values())
    geared = sum(joint.follows is not None for joint in tree.carried.values())
    mobility = len(tree.carried) + slots - geared - 2 * len(tree.cut)
    if mobility < 1:
        value = f"{len(tree.carried) + slots} coordinates and {len(tree.cut)} closed loops"
        allowed = (
            "a machine that moves: each pin or slot that closes a loop takes two freedoms, each "
            f"joint that follows one, and {mobility} are left; loops are closed by "
            f"{', '.join(tree.cut)}; of bodies that are guided twice alike leave one out"
        )
        drawn.refuse("joints", value, allowed)
    found: dict[str, Any] = {
        "format": 1,
        "title": table.title,
        "degrees_of_freedom": mobility,
        "gravity_m_s2": table.gravity_m_s2,
        "transition_stop": struck,
        "initial_phase": 1,
        "cylinder": {
            "rated_speed_rpm": table.speed_rpm,
            "direction": table.direction,
            "angle_at_touch_deg": table.touch_deg,
            "reference_index": 24.0,
            "reference_angle_deg": table.touch_deg if table.start_deg is None else table.start_deg,
        },
        **given,
        "stops": stops,
        "closures": _closures(tree),
        "phases": _phases(table.closed, struck),
        "shortcuts": _shortcuts(struck, springs),
        "provenance": {
            "urdf.points": table.known or table.invented,
            "urdf.links": "invention: bars of an even mass by their length, blocks as given",
            **dict.fromkeys(("drives", "springs", "stops"), table.invented),
        },
        **{key: value for key, value in model.items() if key not in _SECTIONS},
    }
    return {key: value for key, value in found.items() if value or key == "gravity_m_s2"}


def _with_frames(tree: Tree, section: str) -> dict[str, Any]:
    """Entries of a section, the ends of springs and dampers as frames."""
    drawn, found = tree.drawn, {}
    entries = drawn.model.get(section, {})
    if not isinstance(entries, Mapping):
        drawn.refuse(section, entries, "a table of tables")
    for name, entry in entries.items():
        if not isinstance(entry, Mapping):
            drawn.refuse(f"{section}.{name}", entry, "a table")
        found[name] = dict(entry)
        if ends := tree.ends.get(f"{section}.{name}"):
            first, second = (frame_name(*end) for end in ends)
            found[name] = {"frame_a": first, "frame_b": second, **entry}
            del found[name]["ends"]
    return found


def _closures(tree: Tree) -> dict[str, Any]:
    found: dict[str, Any] = {}
    for name, cut in tree.cut.items():
        first = LINE.format(name) if cut.slot else frame_name(cut.parent, cut.point)
        found[name] = {"frame_a": first, "frame_b": frame_name(cut.child, cut.point)}
        if cut.slot:
            mass = 0.02 if cut.block_mass_kg is None else cut.block_mass_kg
            found[name] |= {"slot_axis": "x", "block_mass_kg": mass}
    return found


def _phases(closed: tuple[str, ...], struck: str) -> list[dict[str, Any]]:
    """The start, the stop that is struck by itself, and nothing closed."""
    found: dict[tuple[str, ...], str] = {closed: "running"}
    if struck:
        found.setdefault((struck,), f"on the {struck}")
    found.setdefault((), "free")
    return [
        {"number": number, "name": name, "closed": list(stops)}
        for number, (stops, name) in enumerate(found.items(), start=1)
    ]


def _shortcuts(struck: str, springs: dict[str, Any]) -> dict[str, str]:
    found = {"restitution": f"stops.{struck}.restitution"} if struck else {}
    name, table = next(iter(springs.items()), ("", {}))
    if key := next((key for key in table if key.startswith("stiffness")), ""):
        found["stiffness"] = f"springs.{name}.{key}"
    return found
