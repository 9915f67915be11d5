"""A box that falls on the floor, with a mass that a spring presses against its lid.

The floor stops the box and not the mass, which leaves the lid, comes back and throws the box up
again: two stops that keep throwing each other open. With a constant force of the spring every
flight is a parabola, so that the motion can be followed from event to event without integration.
"""

from __future__ import annotations

from typing import Any

from mpmath import mp, mpf, sqrt
from small_machines import link, machine, slide

from nipper_pin import Mechanism

GRAVITY, DROP = 9.81, 0.01
Numbers = tuple[float, float, float, float, float]
"""Mass of the box, of the mass in it [kg], restitution of the floor, of the lid, force [N]."""


def lid_box(numbers: Numbers, stiffness: float = 0.0) -> Mechanism:
    """Build the box; it starts at rest, 10 mm above the floor.

    Args:
        numbers: What it consists of.
        stiffness: By which the spring's force falls as the mass comes up to the lid [N/m]; without
            it, the force is a level table.
    """
    box, mass, floor, lid, force = numbers
    spring: dict[str, Any] = {
        "joint": "inner", "coordinate_mm": [-1000.0, 1000.0], "force_N": [-force, -force]
    }  # fmt: skip
    if stiffness:
        spring = {
            "joint": "inner",
            "stiffness_N_per_m": stiffness,
            "preload_length_mm": -1e3 * force / stiffness,
        }
    return machine(
        [
            link("box", box),
            slide("height", "frame", "box", (0.0, 1.0)),
            link("mass", mass),
            slide("inner", "box", "mass", (0.0, 1.0)),
        ],
        2,
        gravity=GRAVITY,
        stops={
            "lid": {"joint": "inner", "restitution": lid, "side": "upper"},
            "floor": {"joint": "height", "restitution": floor, "at_mm": -1e3 * DROP},
        },
        springs={"spring": spring},
        phases=[
            {"number": 1, "name": "falling", "closed": ["lid"]},
            {"number": 2, "name": "bouncing", "closed": []},
            {"number": 3, "name": "at rest", "closed": ["floor", "lid"]},
        ],
    )


def followed(numbers: Numbers, least: str = "1e-14", inner: str = "1e-30") -> float:
    """Time at which box and mass are at rest [s], from event to event in 60 digits.

    No limit is taken: every bounce is followed, until a rate falls below ``inner`` of the largest
    one; and until all of them are below ``least`` of the first, an error of that share of the time.

    Args:
        numbers: What the box consists of; the spring's force is constant.
        least: Rate that ends the motion, as a share of the first one.
        inner: Rate at which a stop is taken to be at rest, as a share of the other one.
    """
    with mp.workdps(60):
        box, mass, floor, lid, force = (mpf(str(number)) for number in numbers)
        gravity, drop = mpf(str(GRAVITY)), mpf(str(DROP))
        restitution = floor, lid
        # Rates of the gaps below and at the lid by impulses at the floor and at the lid.
        A = ((1 / box, 1 / box), (1 / box, 1 / box + 1 / mass))
        free = (-gravity - force / box, -force / box - force / mass)
        closing = {0: (mpf(0), gravity - force / mass), 1: (-gravity, mpf(0))}
        t = sqrt(2 * drop / gravity)
        gap, rate, hit = [mpf(0), mpf(0)], [-gravity * t, mpf(0)], 0
        first = -rate[0]
        while True:
            rate = _after(A, gap, rate, restitution)
            largest = max(*(abs(item) for item in rate), *(sqrt(abs(item)) for item in gap))
            if largest < mpf(least) * first:
                return float(t)
            closed = [i for i in (0, 1) if gap[i] == 0 and abs(rate[i]) <= mpf(inner) * largest]
            for i in closed:
                rate[i] = mpf(0)
            a = closing[closed[0]] if closed else free
            lengths = {i: _back(gap[i], rate[i], a[i]) for i in (0, 1) if i not in closed}
            hit = min(lengths, key=lambda i: lengths[i])
            for i in lengths:
                gap[i] += (rate[i] + a[i] * lengths[hit] / 2) * lengths[hit]
                rate[i] += a[i] * lengths[hit]
            gap[hit] = mpf(0)
            t += lengths[hit]


def _after(A: Any, gap: list[Any], rate: list[Any], restitution: tuple[Any, Any]) -> list[Any]:
    """Rates after a collision: complementarity of impulses and xi, by trying all sets."""
    touching = [i for i in (0, 1) if gap[i] == 0]
    wanted = [-restitution[i] * rate[i] for i in (0, 1)]
    for chosen in ((0,), (1,), (0, 1)):
        if not set(chosen) <= set(touching):
            continue
        P, jump = [mpf(0), mpf(0)], [wanted[i] - rate[i] for i in (0, 1)]
        if len(chosen) == 1:
            P[chosen[0]] = jump[chosen[0]] / A[chosen[0]][chosen[0]]
        else:
            determinant = A[0][0] * A[1][1] - A[0][1] ** 2
            P[0] = (A[1][1] * jump[0] - A[0][1] * jump[1]) / determinant
            P[1] = (A[0][0] * jump[1] - A[0][1] * jump[0]) / determinant
        after = [rate[i] + A[i][0] * P[0] + A[i][1] * P[1] for i in (0, 1)]
        if min(P) >= 0 and all(after[i] - wanted[i] >= -(mpf(10) ** -50) for i in touching):
            return after
    raise AssertionError(chosen)


def _back(gap: Any, rate: Any, a: Any) -> Any:
    """Time in which a gap that is pressed shut closes."""
    assert a < 0
    if gap == 0:
        return -2 * rate / a
    return (-rate - sqrt(rate * rate - 2 * a * gap)) / a
