"""What bounces, and the numbers of a machine that calm it most.

Each number is changed by one unit, both ways, and the bounce of the changed machine is computed:
old and new values are those of two machines and not of a tangent.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

from ..errors import InputError, NipperError, SimulationError
from ..given import number
from ..hybrid import FASTEST_RPM, Case, Solution, Window, simulate
from ..hybrid.result.quantities import coordinate_unit
from ..hybrid.result.turns import reported_turn
from ..mechanism import Mechanism, changed, layout_of, numbers_of
from ..terms import named, parameter_shown
from ..tolerances.study import NO_EFFECT, STUDY_TOLERANCE
from ..units import MM_PER_M
from .identify.problem.targets import Condition, transition_quantities

_MOST = 3
_TURNS = 20
# A unit of length is 1 mm, of small machines a power of ten mm below this share of the reach.
_SHARE = 0.01
# Words for a number of a point that grows, and that falls.
_WAYS = {
    "x_mm": ("forward", "backward"),
    "z_mm": ("upward", "downward"),
    "radius_mm": ("farther from its shaft", "nearer to its shaft"),
    "angle_deg": ("counter-clockwise about its shaft", "clockwise about its shaft"),
}


class _Kind(NamedTuple):
    """A kind of number: what counts as one of it near zero, and what it may be."""

    ending: str
    amount: float
    unit: str
    low: float = -math.inf
    high: float = math.inf


# The first ending that fits; what is below its amount is changed by that amount, not by percent.
_KINDS = (
    _Kind("restitution", 0.01, "0.01", 0.0, 1.0),
    _Kind("_N_per_m", 10.0, "10 N/m", 0.0),
    _Kind("_N_m_per_rad", 0.01, "0.01 N m/rad", 0.0),
    _Kind("_N_s_per_m", 0.1, "0.1 N s/m", 0.0),
    _Kind("_N_m_s_per_rad", 1e-3, "0.001 N m s/rad", 0.0),
    _Kind("_N_m", 0.01, "0.01 N m"),
    _Kind("_N", 1.0, "1 N"),
    _Kind("_kg_m2", 1e-7, "1e-7 kg m2", 0.0),
    _Kind("_kg", 1e-4, "0.1 g", 0.0),
    _Kind("", 0.01, "0.01"),
)
_NOT_NEGATIVE = ("radius_mm", "free_length_mm")
# Tables whose numbers a designer sets; the cylinder's are settings. Of these numbers a bounce with
# held drives knows nothing, and places of shafts go with their points.
_TABLES = ("drives", "springs", "dampers", "forces", "stops")
_UNSEEN = (
    "crank_axis_mm", "guide_axis_mm", "reflected_inertia_kg_m2", "reflected_mass_kg",
    "shaft_damping_ratio", "shaft_frequency_hz",
)  # fmt: skip


@dataclass(frozen=True)
class Bounce:
    """How a machine bounces at one speed.

    Attributes:
        amplitude: Largest gap of the first rebound, without transition of any in a turn [rad or m].
        duration_s: Time from the first collision to rest [s]; None without transition.
        clamped_time_s: Time of a turn in which the stop holds [s]; None where no turn was asked for
            or can be followed.
    """

    amplitude: float
    duration_s: float | None
    clamped_time_s: float | None = None


@dataclass(frozen=True)
class Lever:
    """One number of the machine, changed by one unit so that the first rebound is lower.

    Attributes:
        path: The number.
        unit: What it is changed by: "1 mm", "1 deg", "1 %" of it, or an amount near zero.
        old: Its value.
        new: Its value after the change.
        before: Bounce of the machine as it is.
        after: Bounce of the changed machine.
    """

    path: str
    unit: str
    old: float
    new: float
    before: Bounce
    after: Bounce

    @property
    def amplitude_change(self) -> float:
        """Relative change of the first rebound's amplitude."""
        return self.after.amplitude / self.before.amplitude - 1.0

    @property
    def duration_change(self) -> float | None:
        """Relative change of the time to rest; None without transition."""
        if self.after.duration_s is None or self.before.duration_s is None:
            return None
        return self.after.duration_s / self.before.duration_s - 1.0

    @property
    def setting(self) -> str:
        """What ``--set`` takes."""
        return f"{self.path}={self.new:.9g}"

    def __str__(self) -> str:
        """What is changed, and by how much."""
        grows = self.new > self.old
        table, name, *last = self.path.split(".")
        if table == "points" and last and last[0] in _WAYS:
            words = name.replace("_", " ")
            pin = words if words.endswith((" pin", " pivot", " shaft", " axis")) else f"pin {words}"
            return f"{pin} {self.unit} {_WAYS[last[0]][0 if grows else 1]}"
        return f"{parameter_shown(self.path).words} {self.unit} {'more' if grows else 'less'}"

    @property
    def values(self) -> str:
        """Old and new value in the unit that people read."""
        shown = named(self.path)
        old, new = (f"{shown.value(value):.4g}" for value in (self.old, self.new))
        return f"{old} to {new} {shown.unit}".rstrip()


@dataclass(frozen=True, kw_only=True)
class Levers:
    """What bounces in a machine at one speed, and what calms it.

    Attributes:
        mechanism: The machine.
        speed_rpm: Cylinder speed [r/min].
        premise_holds: Whether the machine arrives as a transition assumes; where it does not, or
            has no transition, all bounces are those of turns.
        approach_rate: Rate of the gap before the first collision [rad/s or m/s].
        separation_rate: Rate after it.
        bounce: How it bounces.
        found: The strongest levers, the best first; none if nothing calms the bounce.
        tried: Changed machines that were computed.
    """

    mechanism: Mechanism
    speed_rpm: float
    premise_holds: bool | None
    approach_rate: float
    separation_rate: float
    bounce: Bounce
    found: tuple[Lever, ...]
    tried: int

    @property
    def stop(self) -> str:
        """Name of the stop that bounces."""
        return self.mechanism.transition_stop

    @property
    def unit(self) -> str:
        """Unit of its coordinate, rad or m."""
        return coordinate_unit(self.mechanism, self.mechanism.stop(self.stop).index)

    def record(self) -> dict[str, Any]:
        """The report as plain data, in SI units but for the numbers of the model."""
        return {
            "model": self.mechanism.name,
            "stop": self.stop,
            "speed_rpm": self.speed_rpm,
            "premise_holds": self.premise_holds,
            "approach_rate": self.approach_rate,
            "separation_rate": self.separation_rate,
            **_record(self.bounce),
            "tried": self.tried,
            "levers": [
                {"path": item.path, "unit": item.unit, "old": item.old, "new": item.new,
                 **_record(item.after)}
                for item in self.found
            ],
        }  # fmt: skip


def levers(
    mechanism: Mechanism,
    speed_rpm: float | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> Levers:
    """Find the numbers of a machine that lower its first rebound most, one of each part.

    Left out are the speed and the timing of the cylinder, which are settings; shafts in the frame,
    on which the rest of a machine stands; and how the mass of a link is spread, which no single
    measure of a part sets. A change that makes no machine is passed over.

    Args:
        speed_rpm: Cylinder speed [r/min]; the rated one by default.
        progress: Called with (numbers done, numbers in all).

    Raises:
        InputError: The machine has no stop or does not bounce, or the speed cannot be used.
        SimulationError: The machine cannot be simulated.
    """
    rated = mechanism.cylinder.rated_speed_rpm
    speed = number("speed_rpm", rated if speed_rpm is None else speed_rpm, 0.0, FASTEST_RPM,
                   open_low=True)  # fmt: skip
    run, bounce_of = _asked(mechanism, speed)
    here = bounce_of(mechanism)
    stop = mechanism.transition_stop
    first = next((hit for hit in run.collisions if hit.stop == stop), None)
    if first is None or not here.amplitude > 0.0:
        message = f"{mechanism.name} at {speed:g} r/min: stop {stop} does not bounce, so that "
        message += "nothing calms it"
        raise InputError(message, speed_rpm=speed)
    paths = every_path(mechanism)
    best: dict[str, Lever] = {}
    tried = 0
    for place, (path, value) in enumerate(zip(paths, numbers_of(mechanism, paths), strict=True)):
        for unit, new in _steps(path, value, mechanism.reach_m):
            try:
                after = bounce_of(changed(mechanism, {path: new}))
            except NipperError:
                continue
            tried += 1
            if after.clamped_time_s == 0.0 != here.clamped_time_s:
                # A stop that is never shut is not calmed.
                continue
            part, lever = path.rpartition(".")[0], Lever(path, unit, value, new, here, after)
            known = best.get(part, lever)
            best[part] = lever if lever.amplitude_change <= known.amplitude_change else known
        if progress is not None:
            progress(place + 1, len(paths))
    ranked = sorted(best.values(), key=lambda item: item.amplitude_change)
    chosen = [item for item in ranked[:_MOST] if item.amplitude_change < -NO_EFFECT]
    held = _with_turn(here, mechanism, speed)
    return Levers(
        mechanism=mechanism,
        speed_rpm=speed,
        premise_holds=run.premise_holds,
        approach_rate=first.approach_rate,
        separation_rate=first.separation_rate,
        bounce=held,
        found=tuple(_judged(item, held, mechanism, speed) for item in chosen),
        tried=tried,
    )


def every_path(mechanism: Mechanism) -> tuple[str, ...]:
    """Paths of the numbers that a designer can set and a bounce can depend on."""
    layout = layout_of(mechanism)
    paths: list[str] = []
    for table in _TABLES:
        paths.extend(_numbers(mechanism.description.get(table), table))
    driven = {mechanism.joints[drive.index].name for drive in mechanism.drives}
    for name, pin in layout.meeting.items():
        # A closure is one pin with two names; the second one is used.
        if (len(pin) > 1 and name != pin[-1]) or name not in layout.carried_by:
            continue
        crank = len(pin) > 1 and layout.carried_by[name] in driven
        axes = ("radius_mm", "angle_deg") if crank else ("x_mm", "z_mm")
        paths.extend(f"points.{name}.{axis}" for axis in axes)
    return (*paths, *(f"links.{link}.mass_kg" for link in mechanism.inertias))


def _numbers(value: object, path: str) -> Iterator[str]:
    """Paths of the numbers below a path of the document."""
    if isinstance(value, Mapping):
        for key, part in value.items():
            yield from _numbers(part, f"{path}.{key}")
    elif isinstance(value, int | float) and not isinstance(value, bool):
        yield from [path] * (path.rsplit(".", 1)[-1] not in _UNSEEN)


def _steps(path: str, value: float, reach_m: float) -> Sequence[tuple[str, float]]:
    """One unit less and one more: in words, and the values."""
    if path.endswith(("_mm", "_deg")):
        ending = path.rpartition("_")[2]
        amount = 1.0
        if ending == "mm":
            amount = min(10.0 ** math.floor(math.log10(_SHARE * MM_PER_M * reach_m)), 1.0)
        low = 0.0 if path.endswith(_NOT_NEGATIVE) else -math.inf
        kind = _Kind(ending, amount, f"{amount:g} {ending}", low)
    else:
        kind = next(kind for kind in _KINDS if path.endswith(kind.ending))
        if abs(value) >= kind.amount:
            kind = kind._replace(amount=0.01 * abs(value), unit="1 %")
    new = (value - kind.amount, value + kind.amount)
    return [(kind.unit, item) for item in new if kind.low <= item <= kind.high]


def _asked(mechanism: Mechanism, speed: float) -> tuple[Solution, Callable[[Mechanism], Bounce]]:
    """A run with the first collision, and how the bounce of a changed machine is found.

    In a transition; in that of a turn where the machine does not arrive as a transition assumes;
    and in whole turns where it has none in its touch configuration.
    """
    mechanism.stop(mechanism.transition_stop)
    try:
        run = simulate(mechanism, Case(speed_rpm=speed))
    except InputError:
        run = simulate(mechanism, Case(speed_rpm=speed, window=Window.CYCLE))
        return run, lambda other: _with_turn(Bounce(0.0, None), other, speed, only=True)
    true = run.premise_holds is False

    def bounce_of(other: Mechanism) -> Bounce:
        told = transition_quantities(other, Condition(speed), STUDY_TOLERANCE, None, true=true)
        return Bounce(told["rebound_amplitude_1"], told["duration_s"])

    return run, bounce_of


def _with_turn(bounce: Bounce, mechanism: Mechanism, speed: float, *, only: bool = False) -> Bounce:
    """A bounce with how long the stop holds in a turn.

    Args:
        only: Whether the bounce is that of the turn, too.
    """
    case = Case(speed_rpm=speed, window=Window.CYCLE, cycles=_TURNS)
    try:
        run = simulate(mechanism, case)
        turn = reported_turn(run, least_force=0.0)
    except (SimulationError, InputError):
        if only:
            raise
        return bounce
    amplitude = bounce.amplitude
    if only:
        # Without drives it comes to rest for good, and later turns have no rebound.
        hits = (hit for hit in run.collisions if hit.stop == mechanism.transition_stop)
        highest = (hit.rebound_amplitude or 0.0 for hit in hits)
        amplitude = turn.largest_gap or max(highest, default=0.0)
    return Bounce(amplitude, bounce.duration_s, turn.clamped_time)


def _judged(lever: Lever, here: Bounce, mechanism: Mechanism, speed: float) -> Lever:
    """A lever with how long the stop holds before and after."""
    other = changed(mechanism, {lever.path: lever.new})
    after = _with_turn(lever.after, other, speed)
    return replace(lever, before=here, after=after)


def _record(bounce: Bounce) -> dict[str, float | None]:
    return {
        "rebound_amplitude_1": bounce.amplitude,
        "duration_s": bounce.duration_s,
        "clamped_time_s": bounce.clamped_time_s,
    }
