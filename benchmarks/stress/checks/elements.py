"""Checks of springs and dampers, recomputed from places, rates and tables."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from nipper_pin.arrays import FloatArray
from nipper_pin.hybrid.result.solution import Solution
from nipper_pin.mechanism import Strut

from ...tolerances import EPS, POWER, TABLE_LEFT
from ..mechanics.planar_tree import PlanarTree
from ..observations import beyond, samples


def elements(solution: Solution) -> Iterator[str]:
    """Check the power of springs and dampers against places and rates of their points.

    Places and rates of points come from the text of the model, where the engine has Jacobians.
    Tables stay between their rows and their ends.
    """
    mechanism, system = solution.mechanism, solution.system
    tree, reach_m = PlanarTree.of(mechanism), system.body.reach_m
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
                length, rate, error = _line(tree, reach_m, strut, q, v)
                tension = strut.stiffness * (length - strut.free_length) + strut.damping * rate
                terms.append(-(tension - strut.damping * rate) * rate)
                lost.append(strut.damping * rate**2)
                unsure += (abs(tension) + strut.damping * (abs(rate) + error)) * error
                unsure += 64.0 * EPS * reach_m * strut.stiffness * abs(rate)
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


def _line(
    tree: PlanarTree, reach_m: float, strut: Strut, q: FloatArray, v: FloatArray
) -> tuple[float, float, float]:
    """Distance of two points [m], its rate [m/s] and the round-off of that."""
    motion = tree.motion(q, v, np.zeros(len(q)))
    places, rates, _ = motion.points([tree.frames[strut.frame_a], tree.frames[strut.frame_b]])
    line, moving = places[1] - places[0], rates[1] - rates[0]
    length = float(np.abs(line))
    reach = reach_m + float(np.abs([places.real, places.imag]).max())
    fastest = float(np.abs(v).max()) * max(reach, 1.0)
    error = 64.0 * EPS * fastest * (1.0 + reach / max(length, EPS * reach))
    along = float((line.conjugate() * moving).real)
    return length, along / length if length else 0.0, error
