"""The tables of a run: collisions, phases, velocities of the links, and the motion."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Iterator, Sequence
from math import degrees
from typing import Any

import numpy as np

from ...hybrid import Collision, Solution
from ...hybrid.result.quantities import COLLISION, Quantity, coordinate_unit, force_unit

_SAMPLES_PER_PHASE = 100
_ANGLE = "cylinder_angle_rad"
_FORCE = {"N": "force_N", "N m": "torque_N_m"}
_FORCE_ON = {"m": "force_N", "rad": "torque_N_m"}

TABLES = ("collisions.csv", "phases.csv", "link_velocities.csv", "motion.csv")
"""Names of the tables."""


def tables(solution: Solution) -> Iterator[tuple[str, str]]:
    """Name and content of each table that :func:`export` writes."""
    yield TABLES[0], _csv(*_collisions(solution))
    yield TABLES[1], _csv(_PHASE_HEADER, _phases(solution))
    yield TABLES[2], _csv(_LINK_HEADER, _links(solution))
    yield TABLES[3], _csv(*_motion(solution))


_PHASE_HEADER = (
    "phase", "closed_stops", "t_start_s", "t_end_s", "start_index", "end_index",
)  # fmt: skip
_LINK_HEADER = (
    "collision", "link",
    "angular_before_rad_s", "centroid_x_before_m_s", "centroid_z_before_m_s",
    "angular_after_rad_s", "centroid_x_after_m_s", "centroid_z_after_m_s",
)  # fmt: skip


def _collisions(solution: Solution) -> tuple[list[str], Iterable[Sequence[Any]]]:
    mechanism = solution.mechanism
    kept = [
        item
        for item in COLLISION
        if item.read and any(item.fits(mechanism, stop.name) for stop in mechanism.stops)
    ]
    header = ["number", "stop"]
    for item in kept:
        header += [item.name, "cylinder_angle_deg"] if item.name == _ANGLE else [item.name]

    def cells(hit: Collision, item: Quantity[Collision]) -> list[Any]:
        value = None
        if item.read and item.fits(mechanism, hit.stop):
            value = item.read(solution, hit)
        return [value, degrees(hit.cylinder_angle)] if item.name == _ANGLE else [value]

    rows = (
        [hit.number, hit.stop, *(cell for item in kept for cell in cells(hit, item))]
        for hit in solution.collisions
    )
    return header, rows


def _phases(solution: Solution) -> Iterable[Sequence[Any]]:
    for item in solution.phases:
        yield (
            item.number, " ".join(sorted(item.closed)),
            item.t_start, item.t_end,
            _index(solution, item.t_start), _index(solution, item.t_end),
        )  # fmt: skip


def _links(solution: Solution) -> Iterable[Sequence[Any]]:
    for item in solution.collisions:
        before, after = solution.link_velocities(item.event)
        for row, link in enumerate(before.links):
            yield (
                item.number, link,
                before.angular[row], *before.centroid[row],
                after.angular[row], *after.centroid[row],
            )  # fmt: skip


def _motion(solution: Solution) -> tuple[list[str], Iterable[Sequence[Any]]]:
    mechanism, trajectory = solution.mechanism, solution.trajectory
    units = [coordinate_unit(mechanism, joint.index) for joint in mechanism.joints]
    header = ["t_s", "limit", "cylinder_angle_rad", "cylinder_angle_deg", "index"]
    header += [f"{joint.name}_{u}" for joint, u in zip(mechanism.joints, units, strict=True)]
    header += [f"{joint.name}_rate_{u}_s" for joint, u in zip(mechanism.joints, units, strict=True)]
    header += [
        f"{stop.name}_contact_{_FORCE[force_unit(mechanism, stop)]}" for stop in mechanism.stops
    ]
    header += [
        f"{drive.name}_{_FORCE_ON[coordinate_unit(mechanism, drive.index)]}"
        for drive in mechanism.drives
    ]

    def rows() -> Iterable[Sequence[Any]]:
        for segment in solution.segments:
            if segment.t_end <= segment.t_start:
                continue
            t = np.linspace(segment.t_start, segment.t_end, _SAMPLES_PER_PHASE)
            # Both limits of every event appear: right at the start of a segment, left at its end.
            for times, left in ((t[:-1], False), (t[-1:], True)):
                motion = trajectory.evaluate(times, left=left)
                forces = trajectory.reactions(times, left=left)
                for row, time in enumerate(times):
                    yield (
                        time, "left" if left else "right", motion.cylinder_angle[row],
                        degrees(motion.cylinder_angle[row]),
                        _index(solution, float(time)), *motion.q[row], *motion.v[row],
                        *(force[row] for force in forces.contacts.values()),
                        *(torque[row] for torque in forces.drives.values()),
                    )  # fmt: skip

    return header, rows()


def _index(solution: Solution, t: float) -> float:
    return solution.mechanism.cylinder.index_from_angle(float(solution.shaft.angle(t)))


def _csv(header: Sequence[str], rows: Iterable[Sequence[Any]]) -> str:
    stream = io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerow(header)
    for row in rows:
        # repr of a Python float is the shortest text that reads back to the same float.
        writer.writerow([float(v) if isinstance(v, np.floating) else v for v in row])
    return stream.getvalue()
