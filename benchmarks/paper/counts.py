"""Number of collisions of a transition, by the threshold below which they do not count.

With a constant restitution the bounces are a geometric series without end. The published study
stops at a separation rate that it does not print, so its numbers of collisions say as much about
that threshold as about the machine.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nipper_pin.arrays import FloatArray

from .published import Published
from .studies import Studies, Study

# Above the highest there is one collision whatever the restitution, below the lowest the numbers
# only go on as they have begun.
LOWEST, HIGHEST = 1e-5, 10.0
_PER_DECADE = 100
Interval = tuple[float, float]


@dataclass(frozen=True)
class Counts:
    """Numbers of collisions against the threshold.

    A count stops at the first collision after which the jaw separates slower than the threshold;
    that collision is counted, its rebound is not.

    Attributes:
        thresholds: Separation rates at which the count stops [rad/s], shape (K,); by them and by
            restitution, stiffness or speed the numbers of collisions.
        matches: Intervals of thresholds, (low, high], for which a published statement comes out.
            That collisions grow *to* the published number of times is another reading of the words,
            if not of the other numbers beside them; rebounds are one less than the collisions.
        time_increase: Increase of the transition time with the restitution if the transition ends
            at the last collision that is counted, shape (K,) [-].
        largest_increase: Largest increase of the collisions with the restitution.
    """

    thresholds: FloatArray
    restitution: NDArray[np.int64]
    stiffness: NDArray[np.int64]
    speed: NDArray[np.int64]
    matches: dict[str, tuple[Interval, ...]]
    time_increase: FloatArray
    largest_increase: float

    def record(self) -> dict[str, Any]:
        """Return the answers as plain data."""
        decades = np.logspace(-4.0, 0.0, 9)
        places = np.searchsorted(self.thresholds, decades * (1.0 - 1e-9))
        return {
            "threshold_rad_s": self.thresholds[places].tolist(),
            "by_restitution": self.restitution[places].tolist(),
            "by_stiffness": self.stiffness[places].tolist(),
            "by_speed": self.speed[places].tolist(),
            **{key: [list(item) for item in found] for key, found in self.matches.items()},
            "transition_time_increase": [
                None if np.isnan(value) else float(value) for value in self.time_increase[places]
            ],
            "largest_increase_of_collisions": self.largest_increase,
        }


def collision_counts(studies: Studies, conditions: Published) -> Counts:
    """Count collisions for all thresholds, and find those with the published increase."""
    decades = np.log10(HIGHEST / LOWEST)
    thresholds = np.logspace(np.log10(LOWEST), np.log10(HIGHEST), round(decades * _PER_DECADE) + 1)
    rates = np.concatenate([studies.restitution.rates.ravel(), studies.stiffness.rates.ravel()])
    # Thresholds at which a count changes, and the ends of the range.
    edges = np.unique([LOWEST, *rates[(rates > LOWEST) & (rates < HIGHEST)], HIGHEST])
    middles = np.sqrt(edges[:-1] * edges[1:])
    by_restitution = counted(studies.restitution.rates, middles)
    few, many = by_restitution[:, 0], by_restitution[:, -1]
    increase = np.nan if conditions.count_increase is None else conditions.count_increase
    rebounds = (few > 1) & (many - 1 == (1.0 + increase) * (few - 1))
    same = np.ptp(counted(studies.stiffness.rates, middles), axis=1) == 0
    right = {
        "collisions_grow_as_published": many == (1.0 + increase) * few,
        "rebounds_grow_as_published": rebounds,
        "collisions_grow_to_the_published_multiple": many == increase * few,
        "unchanged_by_stiffness": same,
        "rebounds_as_published_and_unchanged_by_stiffness": rebounds & same,
    }
    return Counts(
        thresholds,
        counted(studies.restitution.rates, thresholds),
        counted(studies.stiffness.rates, thresholds),
        counted(studies.speed.rates, thresholds),
        {key: _intervals(edges, places) for key, places in right.items()},
        _time_increase(studies.restitution, thresholds),
        float((many / few).max() - 1.0),
    )


def counted(rates: FloatArray, thresholds: FloatArray) -> NDArray[np.int64]:
    """Collisions until the first separation slower than a threshold, shape (K, n).

    The rates of n cases fall, and are NaN beyond the last, shape (n, most) [rad/s].
    """
    faster = rates[None] >= thresholds[:, None, None]
    return np.asarray(1 + faster.sum(axis=2), dtype=np.int64)


def _time_increase(study: Study, thresholds: FloatArray) -> FloatArray:
    """Increase of the time of the last counted collision; NaN where that is the first one."""
    last = counted(study.rates, thresholds) - 1
    times = study.bounces.time
    first_case, last_case = times[0][last[:, 0]], times[-1][last[:, -1]]
    increase = np.full(len(thresholds), np.nan)
    moved = first_case > 0.0
    increase[moved] = last_case[moved] / first_case[moved] - 1.0
    return increase


def _intervals(edges: FloatArray, right: NDArray[np.bool_]) -> tuple[Interval, ...]:
    """Adjoining stretches between edges in which something is right, joined."""
    changes = np.flatnonzero(np.diff([False, *right, False]))
    return tuple((float(low), float(high)) for low, high in edges[changes].reshape(-1, 2))
