"""Sensitivities in the words of those who design or set the machine."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ..terms import TERMS, parameter_shown
from ..tolerances.study import NO_EFFECT
from ..units import MS_PER_S
from .sensitivity import QUANTITIES, SPEED, Sensitivities, Sensitivity

_SAID = ("first bounce", "transition", "clamping force")
_FEW = 3
_GAIN = 10.0
# Larger changes than these are no longer small, and the sentences would not hold.
_SMALL = {"mm": 5.0, "deg": 5.0, "%": 20.0}


def label(path: str) -> str:
    """A number of the model in words."""
    return parameter_shown(path).words


def conclusions(found: Sensitivities) -> tuple[str, ...]:
    """Sentences on the sensitivities for the design and adjustment of the machine.

    Returns:
        Sentences made from the numbers; they hold for small changes of one number at a time.
    """
    text = [*_behaviour(found), *_of_speed(found)]
    units = {"mm": "1 mm", "deg": "1 degree", "%": "1 %"}
    # Numbers that are zero have amounts of their own for units.
    units.update((row.unit, row.unit) for row in found.rows if row.unit not in units)
    for place, quantity in enumerate(QUANTITIES):
        for unit, one in units.items():
            text.extend(_strongest(found, quantity, place, unit, one))
    gain = [row for row in found.rows if _helps(row) and not row.doubtful]
    if gain:
        text.append(
            "These calm the bounce and press harder at the same time: "
            + "; ".join(_dose(row) for row in sorted(gain, key=_worth)[:_FEW])
            + "."
        )
    return (*text, *_doubtful(found), *_without_effect(found))


def _behaviour(found: Sensitivities) -> Iterator[str]:
    """Sentences on the motion of the machine with its own values."""
    bounce, lasts, clamp = (
        TERMS["rebound_amplitude"].shown().value(found.amplitude_rad),
        MS_PER_S * found.transition_time_s,
        found.clamping_force_N,
    )
    yield (
        f"{found.model} at {found.speed_rpm:g} r/min: the first bounce opens {found.stop} by "
        f"{bounce:.4g} mdeg, it is at rest after {lasts:.3g} ms, and then presses with "
        f"{clamp:.3g} N."
    )
    if found.premise_holds is False:
        yield (
            "The machine does not arrive at the touch as a transition assumes: bounce and time are "
            "those of the turn."
        )


def _of_speed(found: Sensitivities) -> Iterator[str]:
    by_path = {row.path: row for row in found.rows}
    if SPEED in by_path and not by_path[SPEED].doubtful:
        faster = by_path[SPEED].per
        yield (
            f"1 % more speed makes the first bounce {_more(faster[0], 'higher', 'lower')}, the "
            f"transition {_more(faster[1], 'longer', 'shorter')} and the clamping force "
            f"{_more(faster[2], 'larger', 'smaller')}."
        )


def _doubtful(found: Sensitivities) -> Iterator[str]:
    names = [label(row.path) for row in found.rows if row.doubtful]
    if names:
        yield (
            "The two ways to find them disagree, so that nothing is said of: "
            + ", ".join(names)
            + "."
        )


def _without_effect(found: Sensitivities) -> Iterator[str]:
    still = [row.path for row in found.rows if np.abs(row.per).max() < NO_EFFECT]
    if still:
        links = sorted({path.split(".")[1] for path in still if path.startswith("links.")})
        others = [label(path) for path in still if not path.startswith("links.")]
        named = [*others, *(f"mass and inertia of {link.replace('_', ' ')}" for link in links)]
        yield "Without any effect while the shafts hold their speed: " + ", ".join(named) + "."


def _strongest(
    found: Sensitivities, quantity: str, place: int, unit: str, one: str
) -> tuple[str, ...]:
    """The sentence on the numbers of one unit that change a quantity most."""
    rows = [
        row
        for row in found.ranked(quantity)
        if row.unit == unit
        and row.path != SPEED
        and not row.doubtful
        and abs(row.per[place]) >= NO_EFFECT
    ][:_FEW]
    if not rows:
        return ()
    items = ", ".join(f"{label(row.path)} {row.per[place]:+.2g} %" for row in rows)
    return (f"What {one} more changes the {_SAID[place]} by, the strongest first: {items}.",)


def _more(percent: float, up: str, down: str) -> str:
    return f"{abs(percent):.2g} % {up if percent > 0.0 else down}"


def _helps(row: Sensitivity) -> bool:
    """Return whether a small change lowers bounce and time enough and raises the force."""
    bounce, lasts, clamp = row.per
    sense = -1.0 if bounce > 0.0 else 1.0
    small = abs(bounce) * _SMALL.get(row.unit, 0.0) >= _GAIN
    adjustable = row.path != SPEED and not row.path.startswith("stops.")
    return bool(small and adjustable and sense * lasts < 0.0 < sense * clamp)


def _worth(row: Sensitivity) -> float:
    """Gain of clamping force, negative, for a first bounce lower by a given part."""
    return float(row.per[2] / row.per[0])


def _dose(row: Sensitivity) -> str:
    change = -_GAIN / row.per[0]
    unit = {"deg": "degrees"}.get(row.unit, row.unit)
    return (
        f"{label(row.path)} {change:+.2g} {unit} for a bounce lower by {_GAIN:g} % "
        f"(clamping force {change * row.per[2]:+.2g} %)"
    )
