"""Does a run pass its own checks? One that does not is refused, not printed."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from ...errors import SelfCheckError
from ...tolerances.hybrid import SELF_CHECK, SELF_CHECK_TOLERANCES, STORED_ENERGY

if TYPE_CHECKING:
    from .solution import Solution


def need_sound(solution: Solution) -> None:
    """Refuse a run whose closures gape, or whose energy comes from nowhere.

    The gap is compared with the reach of the mechanism, and the energy that is left over with the
    sum of all terms of the balance.

    Args:
        solution: The solution.

    Raises:
        SelfCheckError: A residual is not a number, or far above the tolerance of the run.
    """
    allowed = SELF_CHECK + SELF_CHECK_TOLERANCES * solution.case.resolution.tolerance
    for name, unit, found, most in _residuals(solution, allowed):
        if found <= most:
            continue
        message = (
            f"this run fails its own check: {name} {found:.2g} {unit}, and at most {most:.2g} "
            f"{unit} would be right; its numbers are not to be used: check the lengths and masses "
            "of the model, or report it with the model"
        )
        raise SelfCheckError(message, check=name, residual=found, tolerance=most)


def _residuals(solution: Solution, allowed: float) -> Iterator[tuple[str, str, float, float]]:
    """Name, unit, size and bound of each residual."""
    system, energy = solution.system, solution.energy
    yield "the closures gape by", "m", solution.checks.closure_m, allowed * system.body.reach_m
    terms = (
        energy.drive_work, energy.drive_impulse_work, energy.gravity_work, energy.spring_change,
        energy.kinetic_change, energy.impact_losses, energy.dissipated, energy.kinetic_peak,
    )  # fmt: skip
    stored = max(
        (float(abs(system.spring_energy(event.q[None])[0])) for event in solution.events),
        default=0.0,
    )
    most = allowed * sum(map(abs, terms)) + STORED_ENERGY * stored
    yield "the energy balance leaves over", "J", abs(energy.residual), most
