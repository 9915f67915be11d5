"""What a designer wants to know first: what bounces, three levers, how fast the machine runs."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from ...errors import InputError, SimulationError
from ...mechanism import INDEX_PER_TURN, Mechanism
from ...units import S_PER_MIN
from ..sensitivity import Sensitivities
from ..speed_limit import SpeedLimit, speed_limit
from .levers import Bounce, Lever, bounce, levers

# In rated speeds; among the speeds of this grid are the rated one and the study's common one.
_SLOWEST, _FASTEST, _SPEEDS = 0.5, 4.0, 253


@dataclass(frozen=True)
class HowFast:
    """How fast the machine can run.

    Attributes:
        limit: Its turns by cylinder speed; None if they cannot be followed.
        why_not: Why they cannot be.
    """

    limit: SpeedLimit | None
    why_not: str = ""

    def margin(self, speed_rpm: float) -> tuple[float, float] | None:
        """Computed speed nearest to one [r/min], and indices from rest to opening there."""
        if self.limit is None:
            return None
        near = int(abs(self.limit.speed_rpm - speed_rpm).argmin())
        return float(self.limit.speed_rpm[near]), float(self.limit.margin[near])


@dataclass(frozen=True)
class Designer:
    """What a designer wants to know first.

    Attributes:
        speed_rpm: Cylinder speed of bounce and levers [r/min].
        bounce: How the machine bounces.
        levers: What changes the first rebound most, the strongest first.
        fast: How fast the machine can run.
    """

    speed_rpm: float
    bounce: Bounce
    levers: tuple[Lever, ...]
    fast: HowFast

    @property
    def index_units(self) -> float:
        """Time to rest in units of the comber's index, 40 to a turn."""
        return self.bounce.duration_s * self.speed_rpm / S_PER_MIN * INDEX_PER_TURN

    def record(self) -> dict[str, Any]:
        """Return it as plain data; of the turns the two limits alone."""
        limit = self.fast.limit
        return {
            "speed_rpm": self.speed_rpm,
            "levers": [item.record() for item in self.levers],
            "settles_rpm": None if limit is None else limit.settles_rpm,
            "repeats_rpm": None if limit is None else limit.repeats_rpm,
            "turns_not_followed": self.fast.why_not,
        }


def how_fast(mechanism: Mechanism) -> HowFast:
    """Follow turns from half the rated speed to four times that, or say why that is impossible.

    Args:
        mechanism: The machine.
    """
    rated = mechanism.cylinder.rated_speed_rpm
    try:
        found = speed_limit(
            mechanism, low_rpm=_SLOWEST * rated, high_rpm=_FASTEST * rated, speeds=_SPEEDS
        )
    except (InputError, SimulationError) as error:
        why = error.message.removeprefix(f"{mechanism.name}: ")
        return HowFast(None, why.removesuffix("; use the direct engine"))
    return HowFast(found)


def designer(mechanism: Mechanism, found: Sensitivities, fast: HowFast) -> Designer:
    """Find bounce and levers at the speed of the sensitivities.

    Args:
        mechanism: The machine.
        found: Its sensitivities.
        fast: How fast it can run.

    Raises:
        InputError: The machine has no working cycle of two phases without freedom.
        SimulationError: The transition cannot be simulated.
    """
    here = bounce(mechanism, found.speed_rpm, true=found.premise_holds is False)
    return Designer(found.speed_rpm, here, levers(mechanism, found, here), fast)
