"""Numbers of a mechanism that the sliders set, with their units and ranges."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from ...errors import InputError
from ...mechanism import Mechanism, Spring, retuned
from ...terms import Shown
from ..reading import coordinate_shown, stiffness_shown

SPEED = "speed"
LARGER = "larger"
RESTITUTION = "restitution"
_MOST_RESTITUTION = 0.8
_MOST_LARGER = 50.0
# A range ends at these parts of the value that the model has.
_SPEED_RANGE = (0.4, 2.0)
_SPRING_RANGE = (0.25, 2.5)
_STEPS_OF_VALUE = 50.0
# Scale of a preload that is zero in the model: an angle, or a part of the mechanism's reach.
_PRELOAD_ANGLE = math.radians(10.0)
_PRELOAD_STROKE = 0.02


@dataclass(frozen=True, kw_only=True)
class Knob:
    """One number that a slider sets.

    Attributes:
        key: Name of the number among the values of a setting.
        shown: What the slider is called, and the unit of the values below.
        start: Where the slider stands at first.
    """

    key: str
    shown: Shown
    low: float
    high: float
    step: float
    start: float


def knobs(mechanism: Mechanism, speed_rpm: float) -> tuple[Knob, ...]:
    """Sliders of a mechanism: speed [r/min], restitution, and rate and preload of every spring.

    Raises:
        InputError: The mechanism has no transition that could be shown, or the speed cannot be
            used.
    """
    if not any(stop.name == mechanism.transition_stop for stop in mechanism.stops):
        message = (
            f"{mechanism.name} has no transition stop, so there are no rebounds that could follow "
            "a slider; name one in its TOML file (transition_stop)"
        )
        raise InputError(message, model=mechanism.name)
    if not mechanism.drives:
        message = (
            f"{mechanism.name} has no drive that closes its stop in the touch configuration, where "
            "a transition starts, so there are no rebounds that could follow a slider: view it in "
            "whole turns (nipper-pin view, window cycle)"
        )
        raise InputError(message, model=mechanism.name)
    if not (math.isfinite(speed_rpm) and speed_rpm > 0.0):
        message = f"--speed {speed_rpm:g} cannot be used: a finite speed above 0 r/min"
        raise InputError(message, speed_rpm=speed_rpm)
    rated = mechanism.cylinder.rated_speed_rpm
    stop = mechanism.stop(mechanism.transition_stop)
    found = [
        _knob(SPEED, Shown(words="speed", unit="r/min"), rated, _SPEED_RANGE, speed_rpm),
        Knob(
            key=RESTITUTION,
            shown=Shown(words=f"restitution of the {stop.name}"),
            low=0.0,
            high=max(_MOST_RESTITUTION, stop.restitution),
            step=0.01,
            start=stop.restitution,
        ),
    ]
    for spring in mechanism.springs:
        found += _spring_knobs(mechanism, spring)
    return tuple(found)


def larger_knob(start: float) -> Knob:
    """How much larger rebounds are drawn, at first by a factor."""
    shown, high = Shown(words="rebounds drawn larger", unit="times"), max(start, _MOST_LARGER)
    return Knob(key=LARGER, shown=shown, low=1.0, high=high, step=1.0, start=start)


def in_si(controls: Sequence[Knob], values: Mapping[str, float]) -> dict[str, float]:
    """Values in SI units, of those in the units of their knobs, by key."""
    return {item.key: values[item.key] / item.shown.factor for item in controls}


def changed(mechanism: Mechanism, values: Mapping[str, float]) -> Mechanism:
    """The mechanism with the values of a setting, in SI units; its tree is not built again."""
    return retuned(
        mechanism,
        restitution={mechanism.transition_stop: values[RESTITUTION]},
        stiffness=[
            values.get(_key(spring, "stiffness"), spring.stiffness) for spring in mechanism.springs
        ],
        preload=[values[_key(spring, "preload")] for spring in mechanism.springs],
    )


def _spring_knobs(mechanism: Mechanism, spring: Spring) -> list[Knob]:
    """Rate, unless the model has none to start from, and preload of one spring."""
    of = "" if len(mechanism.springs) == 1 else f" of spring {spring.name}"
    rate = stiffness_shown(mechanism, spring.index).called(f"stiffness{of}")
    preload = coordinate_shown(mechanism, spring.index).called(f"preload{of}")
    key, start = _key(spring, "stiffness"), spring.stiffness
    found = [_knob(key, rate, start, _SPRING_RANGE, start)] if start > 0.0 else []
    usual = _PRELOAD_ANGLE if preload.unit == "deg" else _PRELOAD_STROKE * mechanism.reach_m
    ends, start = (0.0, _SPRING_RANGE[1]), spring.preload
    return [*found, _knob(_key(spring, "preload"), preload, start or usual, ends, start)]


def _key(spring: Spring, what: str) -> str:
    return f"{spring.name}.{what}"


def _knob(key: str, shown: Shown, scale: float, ends: tuple[float, float], start: float) -> Knob:
    """A knob whose ends and step are round numbers; the ends hold the start between them.

    Args:
        scale: Usual value, SI.
        ends: Ends of the range, in parts of the usual value.
        start: First value, SI.
    """
    usual, first = shown.value(scale), shown.value(start)
    step = _round_step(abs(usual) / _STEPS_OF_VALUE)
    low, high = sorted(part * usual for part in ends)
    # Twelve digits drop what binary fractions add to a multiple of the step.
    low, high, first = (
        float(f"{value:.12g}")
        for value in (step * math.floor(low / step), step * math.ceil(high / step), first)
    )
    low, high = min(low, first), max(high, first)
    return Knob(key=key, shown=shown, low=low, high=high, step=step, start=first)


def _round_step(value: float) -> float:
    """The largest of 1, 2, 5 times a power of ten that is not above a value."""
    power = 10.0 ** math.floor(math.log10(value))
    return float(f"{power * max(part for part in (1, 2, 5) if part * power <= value):.12g}")
