"""Energy balance of a run: what goes in through the drives and where it stays."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np

from ...arrays import FloatArray
from ...dynamics import ConstraintSet, System, drive_impulses
from ...tolerances.hybrid import ENERGY_AGREEMENT
from ..history import Event, Segment, found_after
from ..motion.panel import Panel, forces_at
from ..motion.residual_check import rows_met
from .trajectory import Trajectory

_GAUSS_POINTS = 16
_MOST_HALVINGS = 7


@dataclass(frozen=True)
class EnergyBalance:
    """Energies of a run [J].

    Attributes:
        drive_work: Work of the drives' torques between events.
        drive_impulse_work: Work of the held drives' impulses.
        spring_change: Growth of the energy stored in springs.
        kinetic_change: Growth of the kinetic energy (with the shafts' where these are free).
        impact_losses: Energy lost in collisions and at rests.
        dissipated: Energy that dampers turned into heat.
        kinetic_peak: Largest kinetic energy seen.
    """

    drive_work: float
    drive_impulse_work: float
    gravity_work: float
    spring_change: float
    kinetic_change: float
    impact_losses: float
    dissipated: float
    kinetic_peak: float

    @property
    def residual(self) -> float:
        """Residual of the balance [J]."""
        supplied = self.drive_work + self.drive_impulse_work + self.gravity_work
        stored = self.spring_change + self.kinetic_change
        return supplied - stored - self.impact_losses - self.dissipated

    @property
    def relative(self) -> float:
        """Size of the residual in units of the largest kinetic energy [-]."""
        return abs(self.residual) / self.kinetic_peak if self.kinetic_peak > 0.0 else 0.0


def energy_balance(
    system: System, segments: Sequence[Segment], events: Sequence[Event]
) -> EnergyBalance:
    """Integrate the power of drives and dampers by Gauss quadrature and balance it.

    Returns:
        The balance. Copies of a turn share their panels' arrays and are integrated once.
    """
    known: dict[tuple[int, int, float], tuple[float, float, float]] = {}
    work = heat = peak = 0.0
    length = segments[-1].t_end - segments[0].t_start if segments else 0.0
    for segment in segments:
        phase = system.constraint_set(segment.closed)
        for panel, begin, end in segment.pieces():
            place = segment.panels.index(panel)
            key = (segment.source, place, round((end - begin) / panel.h, 9))
            if key not in known:
                known[key] = _exchanged(system, phase, panel, begin, end, peak / length)
            work += known[key][0]
            heat += known[key][1]
            peak = max(peak, known[key][2])
    trajectory = Trajectory(system, segments)
    first, last = trajectory.span
    # A run may begin or end with a collision: its outer limits belong to the balance.
    if events and events[0].t == first:
        q0, v0 = events[0].q[None], events[0].v_before[None]
    else:
        motion = trajectory.evaluate(first)
        q0, v0 = motion.q, motion.v
    if events and found_after(events, events[-1]).t >= last:
        q1, v1 = events[-1].q[None], events[-1].v_after[None]
    else:
        motion = trajectory.evaluate(last, left=True)
        q1, v1 = motion.q, motion.v
    peak = max(peak, *_kinetic(system, np.vstack([q0, q1]), np.vstack([v0, v1])))
    impulse_work = {
        source: float(
            drive_impulses(system, event.q, event.delta, event.P_g) @ event.v_before[system.driven]
        )
        for source, event in {event.source: event for event in reversed(events)}.items()
    }
    return EnergyBalance(
        drive_work=work,
        drive_impulse_work=sum(impulse_work[event.source] for event in events),
        gravity_work=_change(-system.body.gravity_energy(q1), -system.body.gravity_energy(q0)),
        spring_change=_change(system.spring_energy(q1), system.spring_energy(q0)),
        kinetic_change=_change(_kinetic(system, q1, v1), _kinetic(system, q0, v0)),
        impact_losses=sum(event.energy_lost for event in events),
        dissipated=heat,
        kinetic_peak=float(peak),
    )


def _exchanged(
    system: System, phase: ConstraintSet, panel: Panel, begin: float, end: float, before: float
) -> tuple[float, float, float]:
    """Work of the drives, heat and largest kinetic energy from begin to end [s], all [J].

    Args:
        before: Largest kinetic energy before, by the length of the run [W].
    """
    # Forces bend at the rows of tables, and quadrature wants them smooth.
    met = panel.t + panel.h * rows_met(system, panel)
    inner = np.sort(met[(begin < met) & (met < end)])
    borders = np.concatenate([[begin], inner, [end]])
    for _ in range(_MOST_HALVINGS):
        work, heat, kinetic, missing = _by_gauss(system, phase, panel, borders)
        held = abs(work) + abs(heat) + kinetic
        allowed = ENERGY_AGREEMENT * max(held, before * (end - begin))
        if missing <= allowed or not system.mechanism.struts:
            break
        # Where points of a strut pass one another closely, its force is rougher than all motion.
        borders = np.sort(np.concatenate([borders, 0.5 * (borders[1:] + borders[:-1])]))
    return work, heat, kinetic


def _by_gauss(
    system: System, phase: ConstraintSet, panel: Panel, borders: FloatArray
) -> tuple[float, float, float, float]:
    """The same by Gauss quadrature between each two borders [s], and what it may miss [J]."""
    points, weights, last = _gauss()
    half = 0.5 * np.diff(borders)[:, None]
    t = (borders[:-1, None] + half * (points + 1.0)).ravel()
    q, v, _, forces = forces_at(system, phase, panel, t)
    works = half * np.einsum("ij,ij->i", forces.drive, v[:, system.driven]).reshape(len(half), -1)
    heats = half * system.dissipation(q, v).reshape(len(half), -1)
    # The last Legendre coefficients show what those that follow would be like.
    missing = _GAUSS_POINTS * (np.abs(works @ last).sum() + np.abs(heats @ last).sum())
    kinetic = float(np.max(_kinetic(system, q, v)))
    return float((works @ weights).sum()), float((heats @ weights).sum()), kinetic, float(missing)


@cache
def _gauss() -> tuple[FloatArray, FloatArray, FloatArray]:
    """Points and weights on [-1, 1], (N,), and values to the last two coefficients, (N, 2)."""
    points, weights = np.polynomial.legendre.leggauss(_GAUSS_POINTS)
    last = np.polynomial.legendre.legvander(points, _GAUSS_POINTS - 1)[:, -2:] * weights[:, None]
    return points, weights, last


def _kinetic(system: System, q: FloatArray, v: FloatArray) -> FloatArray:
    kinetic = system.body.kinetic_energy(q, v)
    if not system.held:
        kinetic = kinetic + 0.5 * v[:, system.driven] ** 2 @ system.inertia
    return np.asarray(kinetic)


def _change(end: FloatArray, start: FloatArray) -> float:
    return float(end[0] - start[0])
