"""Checks of springs and dampers: their power anew, and that tables are not left."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from nipper_pin.hybrid import Solution
from nipper_pin.mechanism import TabulatedSpring

from ...tolerances import EPS, POWER, TABLE_LEFT
from ..mechanics.equations import Equations
from ..observations import beyond, samples


def elements(solution: Solution) -> Iterator[str]:
    """Check the power of springs and dampers against the judge's own forces.

    Places and rates of points come from the text of the model, where the engine has Jacobians.
    Tables stay between their rows and their ends.
    """
    system, own = solution.system, Equations(solution).forces
    for segment, _, t in samples(solution):
        where = f"segment at {segment.t_start:.9g} s"
        motion = solution.trajectory.evaluate(t)
        for q, v in zip(motion.q, motion.v, strict=True):
            for table in solution.mechanism.tabulated_springs:
                yield from _between_rows(where, table, float(q[table.index]))
            force, size = own.of_elements(q, v)
            # What a damper does is what is left of the forces at rest.
            lost = float((own.of_elements(q, np.zeros_like(v))[0] - force) @ v)
            unsure = 64.0 * EPS * float(size @ np.abs(v))
            power = float(system.applied_forces(q[None], v[None])[0] @ v)
            heat = float(system.dissipation(q[None], v[None])[0])
            yield from beyond(f"{where}: power of springs and dampers [W]",
                              abs(power - float(force @ v)),
                              POWER * float(np.abs(force) @ np.abs(v)) + unsure)  # fmt: skip
            yield from beyond(f"{where}: power that dampers take [W]", abs(heat - lost),
                              POWER * abs(lost) + unsure)  # fmt: skip
            yield from beyond(f"{where}: power that dampers give [W]", -heat, 0.0)


def _between_rows(where: str, table: TabulatedSpring, x: float) -> Iterator[str]:
    """A table is not left, and between two rows its force lies between theirs."""
    rows, forces = table.characteristic.coordinate, table.characteristic.force
    force = float(table.characteristic.forces(np.array([x]))[0])
    slack = TABLE_LEFT * (rows[-1] - rows[0])
    yield from beyond(f"{where}: {table.name} leaves its table by [rad or m]",
                      max(rows[0] - x, x - rows[-1]), slack)  # fmt: skip
    place = min(max(int(np.searchsorted(rows, x)), 1), len(rows) - 1)
    low, high = sorted(forces[place - 1 : place + 1])
    # Beyond its last row, by round-off, the cubic goes on.
    steepest = max(abs(np.diff(forces) / np.diff(rows)))
    most = POWER * max(map(abs, forces)) + 3.0 * steepest * max(rows[0] - x, x - rows[-1], 0.0)
    yield from beyond(f"{where}: {table.name} overshoots its rows by",
                      max(low - force, force - high), most)  # fmt: skip
