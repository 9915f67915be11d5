"""The published ratios beside ours."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

from nipper_pin.errors import InputError

from .published import Published
from .studies import Studies, Study

NEAR, FAR = 0.04, 0.10


@dataclass(frozen=True)
class Ratio:
    """One ratio as published, and ours; its name is that of study and quantity."""

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

    Raises:
        InputError: A ratio was published that no study gives.
    """
    ours = ratio_values(studies)
    unknown = sorted(conditions.ratios.keys() - ours.keys())
    if unknown:
        message = f"no study gives {', '.join(unknown)}; known: {', '.join(ours)}"
        raise InputError(message, unknown=unknown)
    return tuple(Ratio(name, value, ours[name]) for name, value in conditions.ratios.items())


def agreement(items: Sequence[Ratio]) -> dict[str, int]:
    """Number of ratios, and of those that deviate by no more than 4 and 10 %."""
    near, far = (sum(abs(i.relative_deviation) <= most for i in items) for most in (NEAR, FAR))
    return {"of": len(items), "within_4_percent": near, "within_10_percent": far}


def ratio_values(studies: Studies) -> dict[str, float]:
    """Ratios of our transitions by name: last case by the first one, minus one; and shares."""
    speed, durations = studies.speed, studies.restitution.table.duration
    shares = zip(speed.values, speed.table.first_two_share, strict=True)
    return {
        **_changes(speed, "amplitude_increase", speed.amplitudes),
        **{f"speed.first_two_share_{value:g}": float(share) for value, share in shares},
        **_changes(studies.restitution, "amplitude_increase", studies.restitution.amplitudes),
        "restitution.transition_time_increase": float(durations[-1] / durations[0] - 1.0),
        **_changes(studies.stiffness, "amplitude_change", studies.stiffness.amplitudes),
        **_changes(studies.stiffness, "time_change", studies.stiffness.times),
    }


def _changes(study: Study, quantity: str, values: Any) -> dict[str, float]:
    """Changes of two rebounds, shape (n, 2), from the first case to the last."""
    return {
        f"{study.name}.{rebound}_rebound_{quantity}": float(column[-1] / column[0] - 1.0)
        for rebound, column in zip(("first", "second"), values.T, strict=True)
    }
