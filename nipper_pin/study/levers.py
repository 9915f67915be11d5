"""Levers of a designer: the numbers of the nipper that change its first rebound most.

Sensitivities say which they are and in which sense each of them calms the bounce. What a change of
one unit does is found anew with the changed machine, so that old and new values are those of two
machines and not of a tangent.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from ..errors import InputError, SimulationError
from ..mechanism import Mechanism, changed, layout_of
from ..terms import named, parameter_shown
from ..tolerances.study import NO_EFFECT, STUDY_TOLERANCE
from .identify.problem.targets import Condition, transition_quantities
from .identify.problem.working_cycle import working_cycle
from .sensitivity import SPEED, Sensitivities, Sensitivity
from .steps import step_of

_MOST = 3
# Words for a number of a point that grows, and that falls.
_WAYS = {
    "x_mm": ("forward", "backward"),
    "z_mm": ("upward", "downward"),
    "radius_mm": ("farther from its shaft", "nearer to its shaft"),
    "angle_deg": ("counter-clockwise about its shaft", "clockwise about its shaft"),
}


@dataclass(frozen=True)
class Bounce:
    """How a machine bounces at one speed, and how hard it clamps.

    Attributes:
        amplitude: Amplitude of the first rebound [rad or m].
        duration_s: Time from the first collision to rest [s].
        clamping_force_N: Mean lip force over the middle half of the closed phase [N].
    """

    amplitude: float
    duration_s: float
    clamping_force_N: float


@dataclass(frozen=True)
class Lever:
    """One number of the machine, changed by one unit so that the first rebound is lower.

    Attributes:
        path: The number.
        unit: What it is changed by: "mm", "deg", "%" of it, or an amount where it is nearly zero.
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
    def duration_change(self) -> float:
        """Relative change of the time to rest."""
        return self.after.duration_s / self.before.duration_s - 1.0

    @property
    def clamping_change(self) -> float:
        """Relative change of the mean clamping force."""
        return self.after.clamping_force_N / self.before.clamping_force_N - 1.0

    @property
    def words(self) -> str:
        """What is changed, and by how much."""
        grows = self.new > self.old
        amount = {"mm": "1 mm", "deg": "1 degree", "%": "1 %"}.get(self.unit, self.unit)
        table, name, *last = self.path.split(".")
        if table == "points" and last and last[0] in _WAYS:
            words = name.replace("_", " ")
            pin = words if words.endswith((" pin", " pivot", " shaft", " axis")) else f"pin {words}"
            return f"{pin} {amount} {_WAYS[last[0]][0 if grows else 1]}"
        return f"{parameter_shown(self.path).words} {amount} {'more' if grows else 'less'}"

    def __str__(self) -> str:
        """What is changed, from which value to which, and what comes of it."""
        number = named(self.path)
        old, new = (f"{number.value(value):.4g}" for value in (self.old, self.new))
        return (
            f"{self.words} ({old} to {new} {number.unit}".rstrip()
            + f"): first rebound {_percent(self.amplitude_change)}, time to rest "
            f"{_percent(self.duration_change)}, clamping force {_percent(self.clamping_change)}"
        )


def levers(mechanism: Mechanism, found: Sensitivities) -> tuple[Lever, ...]:
    """The strongest levers of a machine, one of each pin, spring, drive, link or stop.

    Returns:
        At most three, the strongest first. A change by one unit that no machine can have, for
        example of a radius below zero, is passed over.

    Raises:
        InputError: The machine has no working cycle of two phases without freedom.
        SimulationError: The transition cannot be simulated.
    """
    before = _bounce(mechanism, found)
    chosen: list[Lever] = []
    parts: set[str] = set()
    for row in _by_strength(mechanism, found):
        part = row.path.rpartition(".")[0]
        if part in parts or len(chosen) == _MOST:
            continue
        new = row.value - (1.0 if row.per[0] > 0.0 else -1.0) * step_of(row.path, row.value).amount
        try:
            after = _bounce(changed(mechanism, {row.path: new}), found)
        except (InputError, SimulationError):
            continue
        parts.add(part)
        chosen.append(Lever(row.path, row.unit, row.value, new, before, after))
    return tuple(chosen)


def _bounce(mechanism: Mechanism, found: Sensitivities) -> Bounce:
    """How a machine bounces at the speed of sensitivities, in a turn where theirs are of turns."""
    true, condition = found.premise_holds is False, Condition(found.speed_rpm)
    told = transition_quantities(mechanism, condition, STUDY_TOLERANCE, None, true=true)
    clamping = working_cycle(mechanism, found.speed_rpm).clamping_force
    return Bounce(told["rebound_amplitude_1"], told["duration_s"], clamping)


def _percent(change: float) -> str:
    return f"{round(100.0 * change, 1) + 0.0:+.1f} %"


def _by_strength(mechanism: Mechanism, found: Sensitivities) -> Iterator[Sensitivity]:
    """Sensitivities to what a designer of the nipper can change, the strongest first.

    Left out are the speed and the timing of the cylinder, which are settings; shafts in the frame,
    on which the rest of the comber stands; and how the mass of a link is spread, which no single
    measure of a part sets.
    """
    places = layout_of(mechanism)
    for row in found.ranked("rebound_amplitude_1"):
        table, _, rest = row.path.partition(".")
        if row.path == SPEED or table == "cylinder" or row.doubtful or abs(row.per[0]) < NO_EFFECT:
            continue
        if table == "points" and places.carried_by(rest.partition(".")[0]) is None:
            continue
        if table == "links" and not rest.endswith(".mass_kg"):
            continue
        yield row
