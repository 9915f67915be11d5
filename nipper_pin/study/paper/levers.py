"""Levers of a designer: the numbers of the nipper that change its first rebound most.

Sensitivities say which they are and in which sense each of them calms the bounce. What a change of
one unit does is found anew with the changed machine, so that old and new values are those of two
machines and not of a tangent.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict, dataclass
from typing import Any

from ...errors import InputError, SimulationError
from ...mechanism import Mechanism
from ...tolerances.study import NO_EFFECT, STUDY_TOLERANCE
from ..identify.problem.geometry import Sources, layout
from ..identify.problem.parameters import with_values
from ..identify.problem.targets import Condition, transition_quantities
from ..identify.problem.working_cycle import working_cycle
from ..sensitivity import SPEED, Sensitivities, Sensitivity
from ..steps import step_of

LEVERS = 3


@dataclass(frozen=True)
class Bounce:
    """How a machine bounces at one speed, and how hard it clamps.

    Attributes:
        approach_rate: Rate of the gap before the first collision, negative [rad/s or m/s].
        amplitudes: Amplitudes of the first two rebounds [rad or m].
        times_s: Their times [s].
        duration_s: Time from the first collision to rest [s].
        clamping_force_N: Mean lip force over the middle half of the closed phase [N].
    """

    approach_rate: float
    amplitudes: tuple[float, float]
    times_s: tuple[float, float]
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
        return self.after.amplitudes[0] / self.before.amplitudes[0] - 1.0

    @property
    def duration_change(self) -> float:
        """Relative change of the time to rest."""
        return self.after.duration_s / self.before.duration_s - 1.0

    @property
    def clamping_change(self) -> float:
        """Relative change of the mean clamping force."""
        return self.after.clamping_force_N / self.before.clamping_force_N - 1.0

    def record(self) -> dict[str, Any]:
        """Return the lever as plain data, SI units but for the number itself."""
        return {
            "path": self.path,
            "unit": self.unit,
            "old": self.old,
            "new": self.new,
            "after": asdict(self.after),
        }


def bounce(mechanism: Mechanism, speed_rpm: float, *, true: bool) -> Bounce:
    """Find how a machine bounces at a speed.

    Args:
        mechanism: The machine.
        speed_rpm: Cylinder speed [r/min].
        true: Whether the transition is that of the turn, and not as assumed.

    Raises:
        InputError: The machine has no working cycle of two phases without freedom.
        SimulationError: The transition cannot be simulated, or does not come to rest.
    """
    found = transition_quantities(mechanism, Condition(speed_rpm), STUDY_TOLERANCE, None, true=true)
    return Bounce(
        found["approach_rate_1"],
        (found["rebound_amplitude_1"], found["rebound_amplitude_2"]),
        (found["rebound_time_s_1"], found["rebound_time_s_2"]),
        found["duration_s"],
        working_cycle(mechanism, speed_rpm).clamping_force,
    )


def levers(mechanism: Mechanism, found: Sensitivities, before: Bounce) -> tuple[Lever, ...]:
    """The strongest levers of a machine, one of each pin, spring, drive, link or stop.

    Args:
        mechanism: The machine.
        found: Its sensitivities.
        before: How it bounces at their speed.

    Returns:
        At most three, the strongest first. A change by one unit that no machine can have, for
        example of a radius below zero, is passed over.
    """
    sources = Sources.of(mechanism)
    chosen: list[Lever] = []
    parts: set[str] = set()
    for row in _by_strength(mechanism, found):
        part = row.path.rpartition(".")[0]
        if part in parts or len(chosen) == LEVERS:
            continue
        new = row.value - (1.0 if row.per[0] > 0.0 else -1.0) * step_of(row.path, row.value).amount
        try:
            changed = with_values(sources, {row.path: new}).build()
            after = bounce(changed, found.speed_rpm, true=found.premise_holds is False)
        except (InputError, SimulationError):
            continue
        parts.add(part)
        chosen.append(Lever(row.path, row.unit, row.value, new, before, after))
    return tuple(chosen)


def _by_strength(mechanism: Mechanism, found: Sensitivities) -> Iterator[Sensitivity]:
    """Sensitivities to what a designer of the nipper can change, the strongest first.

    Left out are the speed and the timing of the cylinder, which are settings; shafts in the frame,
    on which the rest of the comber stands; and how the mass of a link is spread, which no single
    measure of a part sets.
    """
    places = layout(Sources.of(mechanism))
    for row in found.ranked("rebound_amplitude_1"):
        table, _, rest = row.path.partition(".")
        if row.path == SPEED or table == "cylinder" or row.doubtful or abs(row.per[0]) < NO_EFFECT:
            continue
        if table == "points" and places.carried_by(rest.partition(".")[0]) is None:
            continue
        if table == "links" and not rest.endswith(".mass_kg"):
            continue
        yield row
