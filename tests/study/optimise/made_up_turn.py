"""A turn of 0.1 s in which all coordinates and forces are polynomials of time."""

from __future__ import annotations

import math
from collections.abc import Iterable
from types import SimpleNamespace
from typing import Any

import numpy as np

from nipper_pin.hybrid.event import EventKind
from nipper_pin.mechanism import load

PERIOD = 0.1
HIT, SECOND, REST, OPENING = 0.03, 0.04, 0.05, 0.08
BOTH, JAW, STEEVE = frozenset({"jaw", "steeve"}), frozenset({"jaw"}), frozenset({"steeve"})
NONE: frozenset[str] = frozenset()
# Stated errors of the events in their order: times [s] and relative rates.
LATE = (1e-6, 2e-6, 4e-6, 8e-6, 16e-6, 32e-6)
BLURRED = (1e-5, 3e-5, 2e-5, 7e-5, 5e-5, 9e-5)


def jaw(t: Any) -> Any:
    """Highest at 36 ms, between the first two collisions: 10 mrad; 6.4 mrad at the first one."""
    return 0.01 - 100.0 * (t - 0.036) ** 2


def steeve(t: Any) -> Any:
    """Highest at 61 ms, between rest and opening: 4 mm."""
    return 0.004 - 2.0 * (t - 0.061) ** 2


def lips(t: Any) -> Any:
    """Force at the lips [N]."""
    return 80.0 + 1e5 * (t - 0.05) ** 2


def stop(t: Any) -> Any:
    """Force of the steeve's stop [N]: least at 12 ms."""
    return 7.0 + 2e4 * (t - 0.012) ** 2


def mean(force: Any, begin: float, end: float) -> float:
    """Integral of a quadratic by Simpson's rule, which is exact for it."""
    return float((end - begin) * (force(begin) + 4 * force((begin + end) / 2) + force(end)) / 6)


def event(
    number: int, t: float, kind: EventKind, before: frozenset[str], after: frozenset[str],
    stops: tuple[str, ...] = ("jaw",),
) -> Any:  # fmt: skip
    """One event."""
    return SimpleNamespace(
        number=number, t=t, kind=kind, stops=stops, closed_before=before, closed_after=after
    )


def events(shift: float = 0.0) -> list[Any]:
    """The steeve's stop opens, two collisions of the jaw, rest, and the jaw opens again."""
    found = [
        event(1, 0.029, EventKind.RELEASE, STEEVE, NONE, ("steeve",)),
        event(2, HIT, EventKind.COLLISION, NONE, NONE),
        event(3, SECOND, EventKind.COLLISION, NONE, NONE),
        event(4, REST, EventKind.REST, NONE, JAW),
        event(5, OPENING, EventKind.COLLISION, JAW, STEEVE, ("steeve",)),
    ]
    for item in found:
        item.t += shift
    return found


def collision(item: Any, stop_name: str = "jaw") -> Any:
    """A collision at an event."""
    return SimpleNamespace(
        stop=stop_name, t=item.t, event=item, rebound_amplitude=0.0125, rebound_time=0.0375,
        index=33.25,
    )  # fmt: skip


def mechanism() -> Any:
    """Names, phases and scale of the E62; the jaw's coordinate is the first."""
    e62 = load("e62")
    stops = {
        "jaw": SimpleNamespace(name="jaw", index=0, contact=object()),
        "steeve": SimpleNamespace(name="steeve", index=1, contact=None),
    }
    return SimpleNamespace(
        name="mine", transition_stop="jaw", initial_phase=1, cylinder=e62.cylinder,
        phase=lambda _: SimpleNamespace(closed=STEEVE), stop=lambda name: stops[name],
    )  # fmt: skip


def angle(t: float) -> float:
    """Cylinder angle: from 0.3 rad on, clockwise [rad]."""
    return 0.3 - math.tau * t / PERIOD


def index(t: float) -> float:
    """Index by the comber's scale."""
    cylinder = load("e62").cylinder
    since = (angle(t) - cylinder.reference_angle_rad) / math.tau
    return float((cylinder.reference_index + 40.0 * cylinder.sense * since) % 40.0)


def solution(
    found: Iterable[Any] | None = None, shift: float = 0.0, phases: tuple[Any, ...] = (),
    span: tuple[float, float] = (0.0, PERIOD), **others: Any,
) -> Any:  # fmt: skip
    """The motion, with its events and the two collisions of the jaw among them."""
    happened = list(events(shift) if found is None else found)

    def evaluate(t: Any, left: bool = False) -> Any:
        assert left
        assert np.min(t) >= span[0] - 1e-15
        return SimpleNamespace(q=np.stack([jaw(t - shift), steeve(t - shift)], axis=1))

    def reactions(t: Any) -> Any:
        return SimpleNamespace(contacts={"jaw": lips(t - shift), "steeve": stop(t - shift)})

    given = {
        "events": happened,
        "collisions": [
            collision(item, item.stops[0]) for item in happened if item.kind is EventKind.COLLISION
        ],
        "errors": [
            SimpleNamespace(time=late, impulse=rate)
            for late, rate in zip(LATE, BLURRED, strict=True)
        ],
        "transitions": [SimpleNamespace(t_start=HIT + shift, duration=REST - HIT, collisions=2)],
        "phases": phases, "mechanism": mechanism(), "repeated_from": None,
        "shaft": SimpleNamespace(period=PERIOD, angle=angle),
        "trajectory": SimpleNamespace(span=span, evaluate=evaluate, reactions=reactions),
    }  # fmt: skip
    return SimpleNamespace(**{**given, **others})
