"""The TOML document of a drawing: shaft, drives, springs, stops, closures and phases."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any, TypeVar

from ...errors import InputError
from .parts import Damper, Drawing, Drive, Force, Slot, Spring, Start, Stop, Tie
from .tree import Tree, grown
from .urdf_text import LINE, ends_of, frame_name, urdf_text

_ADDED = ("drives", "springs", "dampers", "forces", "initial", "stops")
Entry = TypeVar("Entry")


def drawn_sources(drawing: Drawing) -> tuple[str, dict[str, Any]]:
    """The URDF and the TOML document of a drawing, as plain data.

    Raises:
        InputError: The drawing does not hang together.
    """
    tree = grown(drawing)
    return urdf_text(tree, drawing.name), document(tree)


def document(tree: Tree) -> dict[str, Any]:
    """The TOML document of a drawing as plain data.

    Raises:
        InputError: A drive, spring, damper or stop is on a joint without a coordinate, or there
            are two drives, starts or stops of one name.
    """
    drawing = tree.drawing
    given = {key: value for key, value in drawing.tables.items() if key not in _ADDED}
    stops = _stops(tree)
    struck = drawing.struck or next(iter(stops), "")
    if missing := [name for name in (*drawing.closed, struck) if name and name not in stops]:
        message = f"{drawing.name}: {', '.join(missing)} are no stops; stops: {', '.join(stops)}"
        raise InputError(message, stops=missing)
    slots = sum(isinstance(cut, Slot) for cut in tree.cut.values())
    springs = {**_springs(tree), **_added(drawing, "springs")}
    found: dict[str, Any] = {
        "format": 1,
        "title": drawing.title,
        "degrees_of_freedom": len(tree.carried) + slots - 2 * len(tree.cut),
        "gravity_m_s2": drawing.gravity_m_s2,
        "transition_stop": struck,
        "initial_phase": 1,
        "cylinder": {
            "rated_speed_rpm": drawing.speed_rpm,
            "direction": "clockwise" if drawing.clockwise else "counter-clockwise",
            "angle_at_touch_deg": drawing.touch_deg,
            "reference_index": 24.0,
            "reference_angle_deg": drawing.start_deg,
        },
        "drives": {**_drives(tree), **_added(drawing, "drives")},
        "springs": springs,
        "dampers": {**_dampers(tree), **_added(drawing, "dampers")},
        "forces": {**_forces(drawing), **_added(drawing, "forces")},
        "initial": {**_initial(tree), **_added(drawing, "initial")},
        "stops": stops,
        "closures": _closures(tree),
        "phases": _phases(drawing.closed, struck),
        "shortcuts": _shortcuts(struck, springs),
        "provenance": {
            "urdf.points": drawing.known or drawing.invented,
            "urdf.links": "invention: bars of an even mass by their length, blocks as given",
            **{table: drawing.invented for table in ("drives", "springs", "stops")},
        },
        **given,
    }
    return {key: value for key, value in found.items() if value or key == "gravity_m_s2"}


def _added(drawing: Drawing, section: str) -> dict[str, Any]:
    """Entries of a section that a drawing has as tables, their ends as frames."""
    entries = drawing.tables.get(section, {})
    if not isinstance(entries, Mapping):
        # What reads the document says what is wrong.
        return {section: entries}
    found = {}
    for name, entry in entries.items():
        if isinstance(entry, Mapping) and "ends" in entry:
            frames = [frame_name(*end) for end in ends_of(drawing, entry["ends"])]
            entry = {**dict(zip(("frame_a", "frame_b"), frames, strict=True)), **entry}
            del entry["ends"]
        found[name] = entry
    return found


def _single(drawing: Drawing, kind: str, entries: Iterable[tuple[str, Entry]]) -> dict[str, Entry]:
    """Entries by name, of which there is one each."""
    found: dict[str, Entry] = {}
    for name, entry in entries:
        if name in found:
            message = f"{drawing.name}: two {kind} are called {name!r}, and there can be one"
            raise InputError(message, name=name)
        found[name] = entry
    return found


def _several(entries: Iterable[tuple[str, Entry]]) -> dict[str, Entry]:
    """Entries by name; the second one of a name is called ``NAME_2``."""
    found: dict[str, Entry] = {}
    for name, entry in entries:
        own, number = name, 1
        while own in found:
            number += 1
            own = f"{name}_{number}"
        found[own] = entry
    return found


def _drives(tree: Tree) -> dict[str, Any]:
    return _single(tree.drawing, "drives", [(part.joint, _drive(tree, part))
                   for part in tree.drawing.parts if isinstance(part, Drive)])  # fmt: skip


def _drive(tree: Tree, part: Drive) -> dict[str, Any]:
    return {
        "joint": part.joint,
        "law": part.law,
        **part.keys,
        _unit(tree, part.joint, "reflected_mass_kg", "reflected_inertia_kg_m2"): part.inertia,
        "shaft_frequency_hz": part.frequency_hz,
        "shaft_damping_ratio": part.damping_ratio,
    }


def _springs(tree: Tree) -> dict[str, Any]:
    found: list[tuple[str, dict[str, Any]]] = []
    for part in tree.drawing.parts:
        if isinstance(part, Spring):
            stiff = _unit(tree, part.joint, "stiffness_N_per_m", "stiffness_N_m_per_rad")
            preload = _unit(tree, part.joint, "preload_length_mm", "preload_deg")
            entry = {"joint": part.joint, stiff: part.stiffness, preload: part.preload}
            found.append((part.joint, entry))
        elif isinstance(part, Tie):
            first, second = (frame_name(*end) for end in ends_of(tree.drawing, part.ends))
            entry = {
                "frame_a": first,
                "frame_b": second,
                "stiffness_N_per_m": part.stiffness,
                "free_length_mm": part.free_mm,
            }
            found.append((part.name, entry))
    return _several(found)


def _dampers(tree: Tree) -> dict[str, Any]:
    keys = "damping_N_s_per_m", "damping_N_m_s_per_rad"
    return _several(
        (part.joint, {"joint": part.joint, _unit(tree, part.joint, *keys): part.damping})
        for part in tree.drawing.parts
        if isinstance(part, Damper)
    )


def _initial(tree: Tree) -> dict[str, Any]:
    return _single(tree.drawing, "starts", [(part.joint, _start(tree, part))
                   for part in tree.drawing.parts if isinstance(part, Start)])  # fmt: skip


def _start(tree: Tree, part: Start) -> dict[str, Any]:
    return {
        _unit(tree, part.joint, "at_mm", "at_deg"): part.at,
        _unit(tree, part.joint, "rate_mm_per_s", "rate_rad_per_s"): part.rate,
    }


def _forces(drawing: Drawing) -> dict[str, Any]:
    return _several(
        (part.joint, {"joint": part.joint, "law": part.law, **part.keys})
        for part in drawing.parts
        if isinstance(part, Force)
    )


def _stops(tree: Tree) -> dict[str, Any]:
    drawn = [(part.name or part.joint, _stop(tree, part))
             for part in tree.drawing.parts if isinstance(part, Stop)]  # fmt: skip
    return {**_single(tree.drawing, "stops", drawn), **_added(tree.drawing, "stops")}


def _stop(tree: Tree, part: Stop) -> dict[str, Any]:
    found: dict[str, Any] = {"joint": part.joint, "restitution": part.restitution}
    key = _unit(tree, part.joint, "at_mm", "at_deg")
    if part.side != "lower":
        found["side"] = part.side
    if part.at:
        found[key] = part.at
    if part.adjusted is not None:
        found["adjusted"] = dict(part.adjusted)
    if part.law is not None:
        found["restitution_law"] = dict(part.law)
    return found


def _closures(tree: Tree) -> dict[str, Any]:
    found: dict[str, Any] = {}
    for name, cut in tree.cut.items():
        if isinstance(cut, Slot):
            found[name] = {
                "frame_a": LINE.format(name),
                "frame_b": frame_name(cut.pinned, cut.at),
                "slot_axis": "x",
                "block_mass_kg": cut.block_kg,
            }
        else:
            found[name] = {
                "frame_a": frame_name(cut.parent, cut.point),
                "frame_b": frame_name(cut.child, cut.point),
            }
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
    for name, table in springs.items():
        stiffness = next(key for key in table if key.startswith("stiffness"))
        found["stiffness"] = f"springs.{name}.{stiffness}"
        break
    return found


def _unit(tree: Tree, joint: str, of_slide: str, of_hinge: str) -> str:
    return of_slide if tree.slides(joint) else of_hinge
