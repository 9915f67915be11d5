"""Curves under the picture: gaps and forces of the stops over the time of the film."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from ...arrays import FloatArray
from ...hybrid.result.quantities import force_unit
from ...mechanism import Stop
from ..naming import contact_shown, coordinate_shown
from .film import Film, bouncing_stop
from .rebounds import highest_drawn

_GAP, _FORCE, _OTHER = "#0072B2", "#CC79A7", "#009E73"
# Room above the largest rebound, and curves of other stops.
_ROOM, _OTHERS = 1.15, 2


@dataclass(frozen=True)
class Curve:
    """One curve.

    Attributes:
        label: Lines of its name, the last one the unit.
        stop: The stop whose collisions are marked at it.
        colour: As in #RRGGBB.
        most: Largest value that is drawn, in the unit of the label.
        values: Values in the frames, shape (K,).
    """

    label: tuple[str, ...]
    stop: str
    colour: str
    most: float
    values: FloatArray


def curves(film: Film) -> list[Curve]:
    """Gap and force of the transition stop, then the gaps of others.

    The scale of the first is that of its rebounds; beyond it the curve ends.
    """
    mechanism = film.solution.mechanism
    main = bouncing_stop(mechanism)
    found = [] if main is None else list(_main(film, main))
    others = [stop for stop in mechanism.stops if stop is not main]
    for stop in others[:_OTHERS]:
        term = coordinate_shown(mechanism, stop.index)
        values = term.value(stop.gaps(film.q))
        found.append(Curve((f"{stop.name} {term.words}", f"[{term.unit}]"), stop.name,
                           _OTHER, _scale(values), values))  # fmt: skip
    return found


def _main(film: Film, stop: Stop) -> Iterator[Curve]:
    mechanism = film.solution.mechanism
    term = contact_shown(stop) or coordinate_shown(mechanism, stop.index)
    values = term.value(stop.gaps(film.q))
    rebounds = highest_drawn(film.solution, film.pace.machine, values)
    most = _ROOM * rebounds if rebounds > 0.0 else _scale(values)
    yield Curve((f"{stop.name} gap", f"[{term.unit}]"), stop.name, _GAP, most, values)
    force = film.force[stop.name]
    unit = force_unit(mechanism, stop)
    yield Curve(("clamping", f"force [{unit}]"), "", _FORCE, _scale(force), force)


def _scale(values: FloatArray) -> float:
    """Largest value of an axis that shows all values."""
    return _ROOM * float(values.max(initial=0.0)) or 1.0
