"""True over stated error of the direct engine, for events of every certified transition."""

from __future__ import annotations

from dataclasses import dataclass

from nipper_pin.hybrid.case import Case, Resolution
from nipper_pin.hybrid.event import EventKind
from nipper_pin.hybrid.simulate import simulate

from .certified import certified, certified_names

STATED_TOLERANCES = (1e-4, 1e-6, 1e-8, 1e-10, 1e-12)


@dataclass(frozen=True)
class Stated:
    """How a run's own estimate of its errors compares with the truth.

    Attributes:
        case: Certified case.
        tolerance: What the run was asked for.
        times: Largest true over stated error of the collision times and of rest [-].
        impulses: Largest true over stated relative error of the impulses [-].
    """

    case: str
    tolerance: float
    times: float
    impulses: float


def true_over_stated() -> list[Stated]:
    """Compare stated errors with true ones; above 1 the truth is worse than stated."""
    found = []
    for name in certified_names():
        reference = certified(name)
        mechanism = reference.mechanism()
        for tolerance in STATED_TOLERANCES:
            resolution = Resolution(tolerance=tolerance)
            case = Case(speed_rpm=reference.speed_rpm, resolution=resolution)
            solution = simulate(mechanism, case)
            times, impulses = [0.0], [0.0]
            for event, error in zip(solution.events, solution.errors, strict=True):
                if event.kind is EventKind.REST:
                    times.append(abs(event.t - reference.transition_time) / error.time)
            rows = zip(solution.collisions, reference.times, reference.impulses, strict=False)
            for collision, t, impulse in rows:
                error = solution.errors[collision.event.number - 1]
                # The first collision is the start: its time is exact and stated so.
                if collision.number > 1:
                    times.append(abs(collision.t - t) / error.time)
                impulses.append(abs(collision.impulse / impulse - 1.0) / error.impulse)
            found.append(Stated(name, tolerance, float(max(times)), float(max(impulses))))
    return found
