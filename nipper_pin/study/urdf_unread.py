"""What a URDF holds and nobody reads: nothing of a file is dropped in silence.

What docs/model_urdf.md calls ignored is passed over; all else that is not read is named.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from xml.etree import ElementTree

# What is read of each element: its attributes, and the elements in it of which each counts once.
_PLACE = ({"xyz", "rpy"}, set[str]())
_SHAPE = ({"name"}, {"origin", "geometry", "material"})
_READ: dict[str, tuple[set[str], set[str]]] = {
    "robot": ({"name"}, set()),
    "link": ({"name"}, {"inertial"}),
    "joint": (
        {"name", "type"},
        {"origin", "parent", "child", "axis", "limit", "dynamics", "mimic"},
    ),
    "inertial": (set(), {"origin", "mass", "inertia"}),
    "visual": _SHAPE,
    "collision": _SHAPE,
    "origin": _PLACE,
    "axis": ({"xyz"}, set()),
    "parent": ({"link"}, set()),
    "child": ({"link"}, set()),
    "limit": ({"lower", "upper"}, set()),
    "dynamics": ({"damping", "friction"}, set()),
    "mimic": ({"joint", "multiplier", "offset"}, set()),
    "mass": ({"value"}, set()),
    "inertia": ({"ixx", "ixy", "ixz", "iyy", "iyz", "izz"}, set()),
    "geometry": (set(), set()),
    "box": ({"size"}, set()),
    "cylinder": ({"radius", "length"}, set()),
    "sphere": ({"radius"}, set()),
    "mesh": ({"filename", "scale"}, set()),
    "material": ({"name"}, {"color"}),
    "color": ({"rgba"}, set()),
}
# Elements of which any number is read, by the one that they stand in.
_MANY = {
    "robot": {"link", "joint", "material"},
    "link": {"visual", "collision"},
    "geometry": {"box", "cylinder", "sphere", "mesh"},
}
# What docs/model_urdf.md calls ignored: elements with all that is in them, and attributes.
_IGNORED = {
    "robot": {"gazebo", "transmission"},
    "joint": {"calibration", "safety_controller"},
    "material": {"texture"},
    "robot attributes": {"version"},
    "limit attributes": {"effort", "velocity"},
}
_HINTS = {
    "joint_properties": "damping belongs into <dynamics>",
    "spring_stiffness": "a spring belongs into [springs] of the TOML file",
    "spring_reference": "a spring belongs into [springs] of the TOML file",
}
_MOST, _MOST_WORDS = 6, 30


def unread(root: ElementTree.Element) -> Iterator[str]:
    """Sentences on what is not read, and on what counts once and is there more often."""
    found: Counter[str] = Counter()
    repeated: list[str] = []
    _look(root, "", found, repeated)
    names = [name if count == 1 else f"{name} ({count} times)" for name, count in found.items()]
    if names:
        more = f" and {len(names) - _MOST} more" if len(names) > _MOST else ""
        hints = [hint for word, hint in _HINTS.items() if any(word in name for name in names)]
        told = "".join(f"; {hint}" for hint in dict.fromkeys(hints))
        yield f"the URDF holds what is not read: {', '.join(names[:_MOST])}{more}{told}"
    yield from repeated


def _look(
    element: ElementTree.Element, where: str, found: Counter[str], repeated: list[str]
) -> None:
    """Look at an element that is read, and at all in it."""
    tag = str(element.tag)
    attributes, once = _READ[tag]
    passed = _IGNORED.get(f"{tag} attributes", set())
    named = tag in ("link", "joint")
    place = f"{tag} {element.get('name', '')}".strip() if named else where
    holder = place if named else f"<{tag}>{_in(where)}"
    for name in element.attrib:
        if name not in attributes and name not in passed:
            found[f"attribute {_short(name)} of {holder}"] += 1
    for text in (element.text, *(child.tail for child in element)):
        words = " ".join((text or "").split())
        if words:
            found[f"text {words[:_MOST_WORDS]!r} in {holder}"] += 1
    seen: Counter[str] = Counter()
    for child in element:
        if not isinstance(child.tag, str) or child.tag in _IGNORED.get(tag, set()):
            continue
        if child.tag not in once and child.tag not in _MANY.get(tag, set()):
            found[f"<{_short(child.tag)}>{_in(place)}"] += 1
            continue
        seen[child.tag] += 1
        if child.tag in once and seen[child.tag] == 2:
            count = len(element.findall(child.tag))
            repeated.append(
                f"{place or tag} has {count} <{child.tag}> in the URDF, and only the first one "
                "counts: put all that it says into one"
            )
        _look(child, place, found, repeated)


def _in(where: str) -> str:
    return f" in {where}" if where else ""


def _short(name: str) -> str:
    """A name without the address of its namespace."""
    return name.rpartition("}")[2]
