"""One page with two machines in the same film: the viewer's page with a second machine in it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ...study.compare import Comparison
from ...terms import digits
from ..scene import Look, Solid, pictured
from ..scene.colours import channels
from ..scene.film import true_size
from ..scene.objects import ROOT, animation
from ..scene.page import assembled, cameras, encoded, machine_messages
from ..scene.readings import curve_record, drawing, readings, rounded
from .pair import COLOUR_A, COLOUR_B, Lane, Pair, clock_text, lanes, pair
from .words import cells, changes_text, finding, names, shown_rows

_OTHER = "other"
_OPACITY = 0.45
_Message = dict[str, Any]


def comparison_page(comparison: Comparison, look: Look) -> str:
    """The page of a comparison, served or written alike."""
    both = pair(comparison, look)
    machines = [item.solution.mechanism for item in (both.a, both.b)]
    drawn = [pictured(mechanism) for mechanism in machines]
    found = _readings(comparison, both)
    found["cameras"] = cameras((both.a, drawn[0]), (both.b, drawn[1]))
    if both.a.larger > 1.0:
        plain = replace(both, a=true_size(both.a), b=true_size(both.b))
        found["true_size"] = {**_drawing(plain), "scene": encoded(_animation(plain, drawn))}
    one, other = map(machine_messages, machines, drawn)
    messages = [*one, *map(_renamed, other), _animation(both, drawn)]
    return assembled(messages, found, __package__)


def _animation(both: Pair, drawn: Sequence[Sequence[Solid]]) -> _Message:
    """The message that plays both films."""
    one, other = (animation(film, own) for film, own in zip((both.a, both.b), drawn, strict=True))
    clips: list[Any] = [one["animations"], _renamed(other)["animations"]]
    return {**one, "animations": [*clips[0], *clips[1]]}


def _renamed(message: _Message) -> _Message:
    """A message about the first machine as one about the second: elsewhere, tinted, transparent."""
    changed = {**message, "path": _moved(message["path"])}
    if "animations" in message:
        # The colour of the first machine tells its phase; that of the second one that it is B.
        changed["animations"] = [
            {**item, "path": _moved(item["path"]),
             "clip": {**item["clip"], "name": f"{_OTHER} {item['clip']['name']}"}}
            for item in message["animations"]
            if not item["path"].endswith("<object>")
        ]  # fmt: skip
    if message["type"] == "set_object":
        colour = int.from_bytes(bytes(round(255.0 * part) for part in channels(COLOUR_B)))
        # Where both stand in one place the first one is seen.
        tint = {"color": colour, "transparent": True, "opacity": _OPACITY, "polygonOffset": True,
                "polygonOffsetFactor": 2.0, "polygonOffsetUnits": 4.0}  # fmt: skip
        drawn = message["object"]
        materials = [{**item, **tint} for item in drawn["materials"]]
        changed["object"] = {**drawn, "materials": materials}
    return changed


def _moved(path: str) -> str:
    return f"/{_OTHER}{path.removeprefix(f'/{ROOT}')}" if path.startswith(f"/{ROOT}") else path


def _readings(comparison: Comparison, both: Pair) -> _Message:
    """What the page's script reads: that of A's film, with B's beside it."""
    one, other = readings(both.a), readings(both.b)
    name_a, name_b = names(comparison)
    return {
        **one,
        "title": "A and B",
        "case": "",
        **_drawing(both),
        "columns": _columns(one["columns"], other["columns"]),
        "collisions": _collisions(one["collisions"], other["collisions"]),
        "curves": [_lane_record(lane) for lane in lanes(both)],
        "arrows": [*one["arrows"], *([_OTHER, *path[1:]] for path in other["arrows"])],
        "compare": {
            "a": {"name": name_a, "colour": COLOUR_A, "root": [ROOT]},
            "b": {"name": name_b, "colour": COLOUR_B, "root": [_OTHER],
                  "opacity": _OPACITY},
            "finding": finding(comparison),
            "changes": changes_text(comparison),
            "notes": list(comparison.notes),
            "rows": [cells(row) for row in shown_rows(comparison)],
        },
    }  # fmt: skip


def _drawing(both: Pair) -> _Message:
    """What the page writes about how large rebounds are drawn."""
    one, other = drawing(both.a), drawing(both.b)
    note = f"{clock_text(both)} {one['note']}"
    return {**one, "note": note, **_lips(one["lips"], other["lips"])}


def _columns(one: Any, other: Any) -> list[_Message]:
    """Numbers of A with those of B of the same name and unit; then what B alone has."""
    values = {(item["label"], item["unit"]): item["values"] for item in other}
    own = {(item["label"], item["unit"]) for item in one}
    kept = [{**item, "other": values.get((item["label"], item["unit"]))} for item in one]
    alone = [item for item in other if (item["label"], item["unit"]) not in own]
    return [*kept, *({**item, "values": None, "other": item["values"]} for item in alone)]


def _collisions(one: Any, other: Any) -> list[_Message]:
    """Collisions of both in order of time, in the colour of their run."""
    marked: Iterator[_Message] = (
        {**hit, "colour": colour, "text": f"{side} {hit['text']}"}
        for side, colour, hits in (("A", COLOUR_A, one), ("B", COLOUR_B, other))
        for hit in hits
    )
    return sorted(marked, key=lambda hit: float(hit["at"]))


def _lane_record(lane: Lane) -> _Message:
    record = curve_record(lane.first)
    lines = [{"colour": colour, "values": _gaps(values)} for colour, values in lane.lines]
    return {**record, **lines[0], "most": lane.most, "text": digits(lane.most), "more": lines[1:]}


def _gaps(values: Any) -> list[float | None]:
    """Numbers, None where there is no motion."""
    there = np.isfinite(values)
    told = rounded(np.where(there, values, 0.0))
    return [value if known else None for value, known in zip(told, there, strict=True)]


def _lips(one: Any, other: Any) -> dict[str, object]:
    """Close-ups of both to one scale; none of a machine without a contact point."""
    known = [item for item in (one, other) if item is not None]
    largest = max(known, key=lambda item: float(item["height"]), default=None)
    if largest is None:
        return {"lips": None, "other_lips": None}
    scale = {"height": largest["height"], "scale_mm": largest["scale_mm"]}
    first, second = (
        None if item is None else {**item, **scale, "name": side}
        for item, side in ((one, "A"), (other, "B"))
    )
    return {"lips": first, "other_lips": second}
