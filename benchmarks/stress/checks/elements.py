"""Checks of springs and dampers, recomputed from places, rates and tables."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pinocchio as pin

from nipper_pin.arrays import FloatArray
from nipper_pin.dynamics.system import System
from nipper_pin.hybrid.result.solution import Solution
from nipper_pin.mechanism import Strut

from ...tolerances import EPS, POWER, TABLE_LEFT
from ..observations import beyond, samples


def elements(solution: Solution) -> Iterator[str]:
    """Check the power of springs and dampers against places and rates of their points.

    Places come from the placements of the links and rates from their angular and centroid
    velocities, where the engine has Jacobians. Tables stay between their rows and their ends.
    """
    mechanism, system = solution.mechanism, solution.system
    for segment, _, t in samples(solution):
        where = f"segment at {segment.t_start:.9g} s"
        motion = solution.trajectory.evaluate(t)
        for q, v in zip(motion.q, motion.v, strict=True):
            terms = [-s.stiffness * (s.preload + q[s.index]) * v[s.index]
                     for s in mechanism.springs]  # fmt: skip
            lost = [damper.damping * v[damper.index] ** 2 for damper in mechanism.dampers]
            # Where a spring is at its free length, preload and deflection make up for each other.
            full = sum(
                s.stiffness * (abs(s.preload) + abs(q[s.index])) * abs(v[s.index])
                for s in mechanism.springs
            )
            unsure = 8.0 * EPS * full
            for table in mechanism.tabulated_springs:
                x, rows = float(q[table.index]), table.characteristic
                force = float(rows.forces(np.array([x]))[0])
                terms.append(-force * v[table.index])
                yield from _between_rows(where, table.name, x, force, rows.coordinate, rows.force)
            for strut in mechanism.struts:
                length, rate, error = _line(system, strut, q, v)
                tension = strut.stiffness * (length - strut.free_length) + strut.damping * rate
                terms.append(-(tension - strut.damping * rate) * rate)
                lost.append(strut.damping * rate**2)
                unsure += (abs(tension) + strut.damping * (abs(rate) + error)) * error
                unsure += 64.0 * EPS * system.body.reach_m * strut.stiffness * abs(rate)
            power = float(system.applied_forces(q[None], v[None])[0] @ v)
            heat = float(system.dissipation(q[None], v[None])[0])
            size = sum(map(abs, terms)) + sum(lost)
            most = POWER * size + unsure
            yield from beyond(f"{where}: power of springs and dampers [W]",
                              abs(power - sum(terms) + sum(lost)), most)  # fmt: skip
            yield from beyond(f"{where}: power that dampers take [W]", abs(heat - sum(lost)),
                              POWER * sum(lost) + unsure)  # fmt: skip
            yield from beyond(f"{where}: power that dampers give [W]", -heat, 0.0)


def _between_rows(
    where: str,
    name: str,
    x: float,
    force: float,
    rows: tuple[float, ...],
    forces: tuple[float, ...],
) -> Iterator[str]:
    """A table is not left, and between two rows its force lies between theirs."""
    slack = TABLE_LEFT * (rows[-1] - rows[0])
    yield from beyond(f"{where}: {name} leaves its table by [rad or m]",
                      max(rows[0] - x, x - rows[-1]), slack)  # fmt: skip
    place = min(max(int(np.searchsorted(rows, x)), 1), len(rows) - 1)
    low, high = sorted(forces[place - 1 : place + 1])
    # Beyond its last row, by round-off, the cubic goes on.
    steepest = max(abs(np.diff(forces) / np.diff(rows)))
    most = POWER * max(map(abs, forces)) + 3.0 * steepest * max(rows[0] - x, x - rows[-1], 0.0)
    yield from beyond(f"{where}: {name} overshoots its rows by", max(low - force, force - high),
                      most)  # fmt: skip


def _line(system: System, strut: Strut, q: FloatArray, v: FloatArray) -> tuple[float, float, float]:
    """Distance of two points [m], its rate [m/s] and the round-off of that."""
    model = system.mechanism.model
    placements = system.body.placements(q)
    spin, centroid = system.body.link_velocities(q, v)
    places, rates = [], []
    names = [joint.name for joint in system.mechanism.joints]
    for name in (strut.frame_a, strut.frame_b):
        frame = model.frames[model.getFrameId(name, pin.FrameType.BODY)]
        local = frame.placement.translation
        if frame.parentJoint == 0:
            places.append(local[[0, 2]])
            rates.append(np.zeros(2))
            continue
        link = names.index(model.names[frame.parentJoint])
        point = placements[link].act(local)[[0, 2]]
        centre = placements[link].act(model.inertias[frame.parentJoint].lever)[[0, 2]]
        arm = point - centre
        places.append(point)
        rates.append(centroid[link] + spin[link] * np.array([-arm[1], arm[0]]))
    line, moving = places[1] - places[0], rates[1] - rates[0]
    length = float(np.hypot(*line))
    reach = system.body.reach_m + float(np.abs(places).max())
    fastest = float(np.abs(v).max()) * max(reach, 1.0)
    error = 64.0 * EPS * fastest * (1.0 + reach / max(length, EPS * reach))
    return length, float(line @ moving) / length if length else 0.0, error
