"""The published ratios beside ours."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

from ...errors import InputError
from .published import Published
from .studies import Studies, Study


@dataclass(frozen=True)
class Ratio:
    """One published ratio and ours.

    Attributes:
        name: Study and quantity.
        published: What was published [-].
        ours: The same of our transitions [-].
    """

    name: str
    published: float
    ours: float

    @property
    def relative_deviation(self) -> float:
        """Ours by the published one, minus one [-]."""
        return self.ours / self.published - 1.0

    def record(self) -> dict[str, Any]:
        """Return the ratio as plain data."""
        return {**asdict(self), "relative_deviation": self.relative_deviation}


def ratios(studies: Studies, conditions: Published) -> tuple[Ratio, ...]:
    """Compare all published ratios, in their order.

    Args:
        studies: Our transitions.
        conditions: The published numbers.

    Raises:
        InputError: A ratio was published that no study gives.
    """
    ours = ratio_values(studies)
    unknown = sorted(conditions.ratios.keys() - ours.keys())
    if unknown:
        message = f"no study gives {', '.join(unknown)}; known: {', '.join(ours)}"
        raise InputError(message, unknown=unknown)
    return tuple(Ratio(name, value, ours[name]) for name, value in conditions.ratios.items())


def within(items: Sequence[Ratio], deviation: float) -> int:
    """Number of ratios that deviate by no more than this."""
    return sum(abs(item.relative_deviation) <= deviation for item in items)


def ratio_values(studies: Studies) -> dict[str, float]:
    """Ratios of our transitions by name: last case by the first one, minus one; and shares."""
    speed, restitution, stiffness = studies.speed, studies.restitution, studies.stiffness
    found = {
        "speed.first_rebound_amplitude_increase": _growth(speed, "amplitudes", 0),
        "speed.second_rebound_amplitude_increase": _growth(speed, "amplitudes", 1),
    }
    for value, share in zip(speed.values, speed.shares, strict=True):
        found[f"speed.first_two_share_{value:g}"] = float(share)
    durations = restitution.durations
    return found | {
        "restitution.first_rebound_amplitude_increase": _growth(restitution, "amplitudes", 0),
        "restitution.second_rebound_amplitude_increase": _growth(restitution, "amplitudes", 1),
        "restitution.transition_time_increase": float(durations[-1] / durations[0] - 1.0),
        "stiffness.first_rebound_amplitude_change": _growth(stiffness, "amplitudes", 0),
        "stiffness.second_rebound_amplitude_change": _growth(stiffness, "amplitudes", 1),
        "stiffness.first_rebound_time_change": _growth(stiffness, "times", 0),
        "stiffness.second_rebound_time_change": _growth(stiffness, "times", 1),
    }


def _growth(study: Study, quantity: str, rebound: int) -> float:
    column = getattr(study, quantity)[:, rebound]
    return float(column[-1] / column[0] - 1.0)
