"""A solution as files: tables for other programs, dense motion, plots, and the case itself."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Sequence
from math import degrees
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import InputError
from ..hybrid.solution import Solution
from ..hybrid.storage import complete_file, save, save_case
from ..mechanism import Joint
from .plots import plot_solution

_SAMPLES_PER_PHASE = 100


def export(solution: Solution, folder: str | Path) -> list[Path]:
    """Write everything about a solution into a folder.

    Args:
        solution: The solution.
        folder: Folder, made if it does not exist; files of the same names are replaced.

    Returns:
        The files: collisions, phases, link velocities and motion as CSV, the solution itself, the
        case (``nipper-pin simulate --case`` repeats it) and plots.

    Raises:
        InputError: The folder cannot be written.
    """
    target = Path(folder)
    try:
        target.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        message = f"{target}: cannot be made a folder ({error.strerror})"
        raise InputError(message, folder=str(target)) from error
    return [
        _write(target / "collisions.csv", _COLLISION_HEADER, _collisions(solution)),
        _write(target / "phases.csv", _PHASE_HEADER, _phases(solution)),
        _write(target / "link_velocities.csv", _LINK_HEADER, _links(solution)),
        _write(target / "motion.csv", *_motion(solution)),
        save(solution, target / "solution.npz"),
        save_case(solution.mechanism, solution.case, target / "case.json"),
        *plot_solution(solution, target),
    ]


_COLLISION_HEADER = (
    "number", "stop", "time_s", "cylinder_angle_rad", "cylinder_angle_deg", "index",
    "approach_rate", "separation_rate", "impulse_N_s", "energy_lost_J", "rebound_amplitude",
    "rebound_time_s",
)  # fmt: skip
_PHASE_HEADER = ("phase", "closed_stops", "start_s", "end_s", "start_index", "end_index")
_LINK_HEADER = (
    "collision", "link",
    "angular_before_rad_s", "centroid_x_before_m_s", "centroid_z_before_m_s",
    "angular_after_rad_s", "centroid_x_after_m_s", "centroid_z_after_m_s",
)  # fmt: skip


def _collisions(solution: Solution) -> Iterable[Sequence[Any]]:
    for item in solution.collisions:
        yield (
            item.number, item.stop, item.t, item.cylinder_angle, degrees(item.cylinder_angle),
            item.index, item.approach_rate, item.separation_rate, item.impulse, item.energy_lost,
            item.rebound_amplitude, item.rebound_time,
        )  # fmt: skip


def _phases(solution: Solution) -> Iterable[Sequence[Any]]:
    for item in solution.phases:
        yield (
            item.number, " ".join(sorted(item.closed)), item.t_start, item.t_end,
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
    header = ["time_s", "limit", "cylinder_angle_rad", "cylinder_angle_deg", "index"]
    header += [f"{joint.name}_{_unit(joint)}" for joint in mechanism.joints]
    header += [f"{joint.name}_rate_{_unit(joint)}_s" for joint in mechanism.joints]
    header += [f"{stop.name}_contact_force_N" for stop in mechanism.stops]
    header += [f"{drive.name}_torque_N_m" for drive in mechanism.drives]

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


def _unit(joint: Joint) -> str:
    return "m" if joint.kind == "prismatic" else "rad"


def _index(solution: Solution, t: float) -> float:
    return solution.mechanism.cylinder.index_from_angle(float(solution.shaft.angle(t)))


def _write(path: Path, header: Sequence[str], rows: Iterable[Sequence[Any]]) -> Path:
    stream = io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerow(header)
    for row in rows:
        # repr of a Python float is the shortest text that reads back to the same float.
        writer.writerow([float(v) if isinstance(v, np.floating) else v for v in row])
    with complete_file(path) as partial:
        partial.write_text(stream.getvalue(), encoding="utf-8")
    return path
