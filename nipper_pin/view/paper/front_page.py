"""First page of the report: what a designer wants to know, in sentences and a short table."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

from ...hybrid.result.quantities import force_unit
from ...mechanism import INDEX_PER_TURN
from ...study.conclusions import label
from ...study.paper import PaperStudy
from ...study.paper.designer import Designer
from ...study.paper.levers import Lever
from ...study.speed_limit import Verdict, where
from ...terms import digits, named
from ...units import MM_PER_M, UM_PER_M
from .terms import REBOUND_TIME, TIME, rebound, unit_text

# Words for a number of a point that grows, and that falls.
_WAYS = {
    "x_mm": ("forward", "backward"),
    "z_mm": ("upward", "downward"),
    "radius_mm": ("farther from its shaft", "nearer to its shaft"),
    "angle_deg": ("counter-clockwise about its shaft", "clockwise about its shaft"),
}
_ONE = {"mm": "1 mm", "deg": "1 degree", "%": "1 %"}


@dataclass(frozen=True)
class LeverLine:
    """One lever as the page shows it; changes are in per cent, with their sign.

    Attributes:
        words: What is changed, and by how much.
        value: Old and new value with the unit.
        amplitude: Old and new amplitude of the first rebound.
        amplitude_change: Its change.
        duration: Old and new time to rest.
        duration_change: Its change.
        clamping_change: Change of the clamping force.
        typed: The change as the command line takes it.
    """

    words: str
    value: str
    amplitude: str
    amplitude_change: str
    duration: str
    duration_change: str
    clamping_change: str
    typed: str


@dataclass(frozen=True)
class FrontPage:
    """What the first page says.

    Attributes:
        speed_rpm: Cylinder speed of bounce and levers [r/min].
        bounces: Sentences on what bounces.
        why: Why it does.
        levers: The levers, the strongest first.
        amplitude_unit: Unit of rebounds.
        fast: Sentences on how fast the machine can run.
    """

    speed_rpm: float
    bounces: tuple[str, ...]
    why: str
    levers: tuple[LeverLine, ...]
    amplitude_unit: str
    fast: tuple[str, ...]


def front_page(study: PaperStudy, found: Designer) -> FrontPage:
    """Put what a designer wants to know into words.

    Args:
        study: The study.
        found: Bounce, levers and speeds of its machine.
    """
    return FrontPage(
        found.speed_rpm,
        tuple(_bounces(study, found)),
        _why(study),
        tuple(_line(study, item) for item in found.levers),
        unit_text(rebound(study.mechanism)),
        tuple(_fast(study, found)),
    )


def _bounces(study: PaperStudy, found: Designer) -> Iterator[str]:
    mechanism, here = study.mechanism, found.bounce
    stop = mechanism.stop(mechanism.transition_stop)
    size, unit = rebound(mechanism), unit_text(rebound(mechanism))
    first, second = (f"{size.text(value)} {unit}" for value in here.amplitudes)
    meets = f"the {stop.name} closes"
    if stop.contact is not None:
        meets = f"the lips meet at {digits(MM_PER_M * stop.lever * -here.approach_rate)} mm/s"
        first += f" ({digits(UM_PER_M * stop.lever * here.amplitudes[0])} µm at the lips)"
    times = [REBOUND_TIME.phrase(value) for value in here.times_s]
    yield (
        f"At {found.speed_rpm:g} r/min {meets} and the {stop.name} bounces open: first by {first} "
        f"for {times[0]}, then by {second} for {times[1]}, and so on."
    )
    yield (
        f"It is at rest {TIME.phrase(here.duration_s)} after the first touch, which is "
        f"{found.index_units:.2f} of the {INDEX_PER_TURN:g} index units of a turn; only then does "
        f"it clamp, with {digits(here.clamping_force_N)} {force_unit(mechanism, stop)} in the mean."
    )


def _why(study: PaperStudy) -> str:
    mechanism = study.mechanism
    stop = mechanism.stop(mechanism.transition_stop)
    return (
        f"An impact gives back {100.0 * stop.restitution:g} % of the rate at which the {stop.name} "
        f"closes (restitution {stop.restitution:g}), and it stays open until the closing force has "
        "used that up. It bounces less where it closes more slowly, is pressed harder or gives "
        "back less."
    )


def _line(study: PaperStudy, lever: Lever) -> LeverLine:
    size, number = rebound(study.mechanism), named(lever.path)
    old, new = (f"{number.value(value):.4g}" for value in (lever.old, lever.new))
    before, after = lever.before, lever.after
    return LeverLine(
        change_words(lever),
        f"{old} → {new} {number.unit}".rstrip(),
        f"{size.text(before.amplitudes[0])} → {size.text(after.amplitudes[0])}",
        _percent(lever.amplitude_change),
        f"{TIME.text(before.duration_s)} → {TIME.text(after.duration_s)}",
        _percent(lever.duration_change),
        _percent(lever.clamping_change),
        f"--set {lever.path}={lever.new:.6g}",
    )


def change_words(lever: Lever) -> str:
    """What is changed and by how much, in words.

    Args:
        lever: The change.
    """
    grows = lever.new > lever.old
    amount = _ONE.get(lever.unit, lever.unit)
    table, name, *last = lever.path.split(".")
    if table == "points" and last and last[0] in _WAYS:
        words = name.replace("_", " ")
        pin = words if words.endswith((" pin", " pivot", " shaft", " axis")) else f"pin {words}"
        return f"{pin} {amount} {_WAYS[last[0]][0 if grows else 1]}"
    return f"{label(lever.path)} {amount} {'more' if grows else 'less'}"


def _fast(study: PaperStudy, found: Designer) -> Iterator[str]:
    limit, jaw = found.fast.limit, study.mechanism.transition_stop
    if limit is None:
        yield f"That is not known, since its turns cannot be tabulated: {found.fast.why_not}."
    else:
        low, high = (f"{value:,.0f}" for value in limit.speed_rpm[[0, -1]])
        yield f"Speeds from {low} to {high} r/min were followed."
        if rests := where(limit.settled, Verdict.YES):
            yield f"The {jaw} is at rest before it opens again {rests}."
        if restless := where(limit.settled, Verdict.NO):
            yield f"It still bounces when it opens {restless}."
        speed, margin = found.fast.margin(found.speed_rpm) or (math.nan, math.nan)
        if math.isfinite(margin):
            yield f"At {speed:.4g} r/min it holds for {margin:.1f} index units between the two."
        if single := where(limit.single, Verdict.YES):
            yield f"Each turn is like the one before {single}."
        if others := where(limit.single, Verdict.NO):
            yield f"Turns differ from the one before {others}."
        if limit.lost:
            yield limit.lost
    stop = study.phase_one
    threshold = stop.threshold_rpm(stop.preload)
    if math.isfinite(threshold):
        yield (
            f"With the {jaw} open, the {stop.stop} leaves its stop from {threshold:,.0f} r/min on."
        )


def _percent(change: float) -> str:
    return f"{round(100.0 * change, 1) + 0.0:+.1f} %"
