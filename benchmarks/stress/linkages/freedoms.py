"""Freedoms of a random linkage: sprung rods, spring-held levers and boxes, and stops."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from nipper_pin.arrays import FloatArray
from nipper_pin.mechanism.drawing import Body, Part, Place, Slide, Spring, Stop, flap, telescope

from ..machines.draws import Generator, log, one_of, sign
from .dyads import Growing
from .motion import ANGLES, Output, Rod, unit

_SHARES = (0.03, 0.4)  # of the reach of a coordinate, from its end to where a stop is put


@dataclass(frozen=True)
class Struck:
    """A lower or an upper stop of an output, met at a place in ``ANGLES``.

    There the rod that moves it has to get longer, or shorter.
    """

    output: Output
    lower: bool
    contact: int
    longer: bool

    @property
    def gap(self) -> FloatArray:
        """Gap of the stop if nothing gave way, shape (angles,) [rad or mm]."""
        sense = 1.0 if self.lower else -1.0
        x = self.output.coordinate
        return np.asarray(sense * (x - x[self.contact]))


def struck(rng: Generator, output: Output, rod: Rod, step: int) -> Struck | None:
    """A stop that an output, moved by a rod, meets on its way, if the rod can give way there.

    The crank turns counter-clockwise if ``step`` is 1, clockwise if it is -1.
    """
    lower = bool(rng.random() < 0.5)
    x = output.coordinate if lower else -output.coordinate
    reach = float(x.max() - x.min())
    place = float(x.min()) + float(rng.uniform(*_SHARES)) * reach
    ahead = np.roll(x, -step)
    meets = np.flatnonzero((x >= place) & (ahead < place) & (np.abs(ahead - x) < 0.3 * reach))
    if not len(meets):
        return None
    contact = int(meets[0])
    held = rod.held(float(output.coordinate[contact]))
    beyond = x < x[contact]
    length = np.abs(held - rod.driving)[beyond] - rod.length
    worst = float(length[np.argmax(np.abs(length))])
    if (length * worst).min() < -1e-3 * worst**2:
        # It would have to give way in both directions.
        return None
    return Struck(output, lower, contact, worst > 0.0)


def rod_parts(rng: Generator, linkage: Growing, stop: Struck | None, name: str, force: float
              ) -> tuple[Part, ...]:  # fmt: skip
    """A rod as two halves on a spring with this preload [N]; a stop may make it give way."""
    preload = float(rng.uniform(5.0, 20.0))
    points = " ".join(linkage.on[name][:2])
    longer = bool(rng.random() < 0.5) if stop is None else stop.longer
    return telescope(
        name, points, 1e3 * force / preload, preload, longer=longer,
        density_kg_m=linkage.bodies[name], restitution=one_of(rng, 0.0, 0.2, rng.uniform(0.0, 0.6)),
    )  # fmt: skip


def lever_parts(rng: Generator, linkage: Growing, name: str, pull: float) -> tuple[Part, ...]:
    """A lever on one of the links, held by a spring against the first of two stops.

    It feels an acceleration ``pull`` [m/s2]; the linkage gets its end.
    """
    parent, point = linkage.moving(rng)
    end, length = f"{name}_end", linkage.size * float(rng.uniform(0.2, 0.8))
    lean = float(rng.uniform(0.0, 2.0 * np.pi))
    linkage.places[end] = linkage.places[point] + length * unit(lean + linkage.poses[parent].angle)
    density = log(rng, 0.1, 1.0)
    # Moment of its weight in that field, about its hinge [N m].
    moment = 0.5e-6 * density * length**2 * pull
    preload = float(rng.uniform(0.5, 20.0))
    stiffness = moment * float(rng.uniform(0.1, 1.5)) / np.radians(preload)
    return flap(
        name, parent, f"{point} {end}", float(stiffness), preload,
        sign(rng) * float(rng.uniform(3.0, 40.0)), density_kg_m=density,
        restitution=one_of(rng, 0.0, 0.3, rng.uniform(0.0, 0.7)),
    )  # fmt: skip


def box_parts(
    rng: Generator, linkage: Growing, name: str, pull: float
) -> tuple[tuple[Part, ...], bool]:
    """A box on a spring that slides on one of the links between two stops.

    It feels an acceleration ``pull`` [m/s2]. Told is, too, if its first stop is closed as drawn.
    """
    parent, point = linkage.moving(rng)
    lean = float(rng.uniform(0.0, 2.0 * np.pi))
    way: Place = float(np.cos(lean)), float(np.sin(lean))
    mass, gap = log(rng, 0.02, 1.0), log(rng, 2.0, 30.0)
    closed = bool(rng.random() < 0.6)
    below = 0.0 if closed else -gap * float(rng.uniform(0.2, 0.8))
    stiffness = 1e3 * mass * pull / gap * float(rng.uniform(0.1, 2.0))
    preload = gap * float(rng.uniform(0.1, 1.5)) if closed else 0.0
    restitution = one_of(rng, 0.0, 0.3, rng.uniform(0.0, 0.7))
    return (
        Body(name, point, mass_kg=mass),
        Slide(name, parent, name, point, way),
        Spring(name, stiffness, preload),
        Stop(name, "lower", below, restitution),
        Stop(name, "upper", below + gap, restitution, f"{name}_far"),
    ), closed


def open_at(stops: list[Struck]) -> int | None:
    """Place in ``ANGLES`` where the smallest gap is largest; None if too small everywhere."""
    if not stops:
        return 0
    shares = np.min([stop.gap / np.ptp(stop.output.coordinate) for stop in stops], axis=0)
    best = int(np.argmax(shares))
    return best if shares[best] > 0.05 else None


def furthest(linkage: Growing) -> float:
    """Largest second derivative of a point's place by the crank's angle [mm]."""
    step = float(ANGLES[1] - ANGLES[0])
    return max(
        float(np.abs(np.roll(x, 1) - 2.0 * x + np.roll(x, -1)).max())
        for x in linkage.places.values()
    ) / step**2  # fmt: skip
