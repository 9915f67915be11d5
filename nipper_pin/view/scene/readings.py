"""Numbers of every frame, phases and collisions, as text beside the picture."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import groupby
from typing import Any

import numpy as np

from ...arrays import FloatArray
from ...hybrid import Collision, Solution, Window
from ...hybrid.result.quantities import force_unit
from ...mechanism import INDEX_PER_TURN, Mechanism
from ...terms import digits
from ...units import MS_PER_S
from ..phases import intervals
from ..reading import case_text, contact_shown, coordinate_shown, force_name, gap_noun
from .arrows import arrow_body, arrow_place, arrow_stops
from .closeup import close_up
from .film import Curve, Film, bouncing_stop, curves, drawn_limit
from .objects import arrow_path, body_path

_DIGITS = 6
_ROUND_OFF = 1e-12
_TICKS = 120
NOTE = (
    "Shapes are illustrations built on the model's dimensions; {source}"
    "the arrow at a stop is its impulse, in proportion to the largest one."
)


def readings(film: Film) -> dict[str, Any]:
    """Everything that the page writes, as plain data."""
    solution, pace = film.solution, film.pace
    mechanism = solution.mechanism
    last = pace.machine[-1]
    shown = [item for item in intervals(solution) if item.start <= last]
    starts = pace.playback_at(np.array([item.start for item in shown]))
    return {
        "title": mechanism.title or mechanism.name,
        "case": case_text(solution),
        **drawing(film),
        "index_per_turn": INDEX_PER_TURN,
        "playback": rounded(pace.playback),
        "duration": float(pace.playback[-1]),
        "columns": [
            {"label": label, "unit": unit, "values": rounded(values)}
            for label, unit, values in columns(film)
        ],
        "phase_of_frame": film.phase.tolist(),
        "phases": [
            {"name": item.name, "start": float(start), "colour": item.colour}
            for item, start in zip(shown, starts, strict=True)
        ],
        "legend": list(dict.fromkeys((item.name, item.colour) for item in shown)),
        "collisions": [
            {"at": float(pace.playback_at(item.t)), "stop": item.stop, "text": text}
            for item, text in _told(solution) if pace.machine[0] <= item.t <= last
        ],
        "ticks": [
            {"at": float(pace.playback_at(t)), **tick}
            for t, tick in ticks(last) if t >= pace.machine[0]
        ],
        "curves": [curve_record(curve) for curve in curves(film)],
        "names": _names(mechanism),
        "arrows": [arrow_path(mechanism, stop).split("/") for stop in arrow_stops(mechanism)],
    }  # fmt: skip


def _names(mechanism: Mechanism) -> list[dict[str, object]]:
    """Names in the picture, the nodes that they move with, and their places in these [m]."""
    model = mechanism.model
    found = []
    for body, joint in enumerate(mechanism.joints):
        centre = model.inertias[body + 1].lever
        found.append(_name(mechanism, body, joint.child, centre.tolist()))
    stop = bouncing_stop(mechanism)
    if stop is not None and stop.contact is not None:
        place = arrow_place(mechanism, stop)[:3, 3].tolist()
        found.append(_name(mechanism, arrow_body(mechanism, stop), f"contact of the {stop.name}",
                           place))  # fmt: skip
    return found


def _name(mechanism: Mechanism, body: int, text: str, place: list[float]) -> dict[str, object]:
    path = body_path(mechanism, body).split("/")
    return {"text": text.replace("_", " "), "path": path, "place": place}


def drawing(film: Film) -> dict[str, Any]:
    """What the page writes about how large rebounds are drawn, as plain data."""
    lips = close_up(film)
    return {
        "exaggerate": film.larger,
        "note": note(film),
        "lips": None if lips is None else lips.record(),
    }


def curve_record(curve: Curve) -> dict[str, object]:
    """A curve as plain data."""
    return {
        "label": curve.label,
        "stop": curve.stop,
        "text": digits(curve.most),
        "most": curve.most,
        "colour": curve.colour,
        "values": rounded(curve.values),
    }


def ticks(end: float) -> Iterator[tuple[float, dict[str, object]]]:
    """Times of the scale from the start of the window [s], multiples of a round step, in words."""
    step = 10.0 ** math.floor(math.log10(end / _TICKS))
    step *= next(part for part in (1.0, 2.0, 5.0, 10.0) if part * step >= end / _TICKS)
    for number in range(math.floor(end / step * (1.0 + 1e-12)) + 1):
        yield step * number, {"text": f"{MS_PER_S * step * number:.10g}", "number": number}


def collision_text(mechanism: Mechanism, hits: Sequence[Collision]) -> str:
    """Text about the last collision, or all those of one event."""
    told = []
    for hit in hits:
        unit = force_unit(mechanism, mechanism.stop(hit.stop))
        told.append(f"{hit.number} ({hit.stop}): impulse {digits(hit.impulse)} {unit} s")
    return f"last: collision{'s' if len(told) > 1 else ''} {'; '.join(told)}"


def _told(solution: Solution) -> Iterator[tuple[Collision, str]]:
    """Collisions with the text of their event."""
    for _, hits in groupby(solution.collisions, key=lambda item: item.event.number):
        struck = list(hits)
        text = collision_text(solution.mechanism, struck)
        yield from ((item, text) for item in struck)


def columns(film: Film) -> Iterator[tuple[str, str, FloatArray]]:
    """Label, unit and values of the numbers that follow the film."""
    mechanism, pace = film.solution.mechanism, film.pace
    yield "index", "", film.index
    yield "time", "ms", MS_PER_S * pace.machine
    yield "slow motion 1 :", "", pace.stretch
    for stop in mechanism.stops:
        # In a transition there are rebounds alone, which are small.
        bounces = stop.name == mechanism.transition_stop
        small = bounces and film.solution.case.window is Window.TRANSITION
        term = coordinate_shown(mechanism, stop.index, small=small)
        gap = stop.gaps(film.q)
        yield f"{stop.name} {gap_noun(mechanism, stop)}", term.unit, term.value(gap)
        if (lips := contact_shown(stop)) is not None:
            yield f"{stop.name} {lips.words}", lips.unit, lips.value(gap)
        name = force_name(mechanism, stop.name).partition(" [")[0]
        yield f"{stop.name} {name}", force_unit(mechanism, stop), film.force[stop.name]


def note(film: Film) -> str:
    """Note about the origin of the shapes and about exaggerated motion."""
    source = ""
    if "estimate" in film.solution.mechanism.title:
        source = "these dimensions are estimates, not the maker's drawings; "
    said = NOTE.format(source=source)
    if film.larger > 1.0:
        stop = film.solution.mechanism.transition_stop
        said += (
            f" Rebounds of the {stop} are drawn {film.larger:g} times as large, up to "
            f"{_limit(film)}, and the other links follow; closing, opening and all numbers are "
            "those of the machine."
        )
    return said


def _limit(film: Film) -> str:
    """Largest exaggerated gap that is drawn, with its unit."""
    mechanism = film.solution.mechanism
    term = coordinate_shown(mechanism, mechanism.stop(mechanism.transition_stop).index)
    return f"{term.value(drawn_limit(mechanism)):.3g} {term.unit}"


def rounded(values: FloatArray) -> list[float]:
    """Rounded numbers, of shape (K,); round-off beside the largest of them is zero."""
    least = _ROUND_OFF * float(np.abs(values).max(initial=0.0))
    return [float(f"{value:.{_DIGITS}g}") if abs(value) > least else 0.0 for value in values]
