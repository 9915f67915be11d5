"""The tables of a run by columns: collisions, phases, velocities of links, and the motion.

CSV files and data frames are written from them, in SI units or in mm and degrees.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence

import numpy as np

from ...errors import UnknownNameError
from ...frames import Column
from ...units import DEG_PER_RAD, MM_PER_M
from .quantities import COLLISION, coordinate_unit, force_unit
from .simulated import Simulated

TABLES = ("collisions", "phases", "links", "motion")
"""The tables of a run."""
UNITS = ("SI", "mm")
"""SI units, or mm and degrees in place of m and rad; forces, times and energies are the same."""

_SAMPLES_PER_PHASE = 100
IN_MM = {
    f"{unit}{per}": (f"{people}{per}", factor)
    for unit, people, factor in (("rad", "deg", DEG_PER_RAD), ("m", "mm", MM_PER_M))
    for per in ("", "/s")
}
"""Unit of people and factor of each SI unit that "mm" changes."""


def columns(solution: Simulated, table: str, units: str = "SI") -> dict[str, Column]:
    """Columns of one of the :data:`TABLES` of a run, by names that end with their units.

    Raises:
        UnknownNameError: There is no such table, or no such units.
    """
    if table not in TABLES:
        raise UnknownNameError(kind="table", name=table, known=TABLES, where="to_frame")
    made = _Columns(known_units(units) == "mm")
    _FILLS[table](solution, made)
    return made.found


def known_units(units: str) -> str:
    """The name of units.

    Raises:
        UnknownNameError: There are no such units.
    """
    if units not in UNITS:
        raise UnknownNameError(kind="units", name=units, known=UNITS, where="to_frame")
    return units


class _Columns:
    """Columns that are added one after another."""

    def __init__(self, in_mm: bool) -> None:
        self._in_mm, self.found = in_mm, dict[str, Column]()

    def add(self, name: str, values: Column, units: str | Sequence[str] = "") -> None:
        """Add a column, by its name in SI units, with its SI unit or that of each row."""
        kinds = [units] if isinstance(units, str) else list(dict.fromkeys(units))
        if self._in_mm and any(kind in IN_MM for kind in kinds):
            factors = [IN_MM[kind][1] for kind in ([units] if isinstance(units, str) else units)]
            values = np.asarray(values, dtype=float) * (factors or 1.0)
            shown = [IN_MM[kind][0] for kind in kinds]
            if len(kinds) == 1:
                name = with_unit(name, kinds[0], shown[0])
            else:
                name += "_or".join(map(_ending, shown))
        self.found[name] = values


def with_unit(name: str, unit: str, shown: str) -> str:
    """The name of a column whose unit is shown as another one, which it then ends with.

    The number of a collision stands behind the unit: impulse_N_s_1.
    """
    found, times = re.subn(rf"{_ending(unit)}(?=(_\d+)?$)", _ending(shown), name)
    return found if times else name + _ending(shown)


def _ending(unit: str) -> str:
    """The unit at the end of a name."""
    return "_" + unit.replace("/", "_").replace(" ", "_")


def _collisions(solution: Simulated, table: _Columns) -> None:
    mechanism, hits = solution.mechanism, solution.collisions
    table.add("number", [hit.number for hit in hits])
    table.add("stop", [hit.stop for hit in hits])
    for item in COLLISION:
        if item.read is None or not any(item.fits(mechanism, s.name) for s in mechanism.stops):
            continue
        values = [
            item.read(solution, hit) if item.fits(mechanism, hit.stop) else None for hit in hits
        ]
        units: str | list[str] = item.term.unit
        if "{gap}" in item.term.unit:
            units = [item.unit_at(mechanism, hit.stop) for hit in hits]
        table.add(item.name, _numbers(values), units)


def _phases(solution: Simulated, table: _Columns) -> None:
    found = solution.phases
    table.add("phase", _numbers([item.number for item in found]))
    table.add("closed_stops", [" ".join(sorted(item.closed)) for item in found])
    table.add("t_start_s", _numbers([item.t_start for item in found]))
    table.add("t_end_s", _numbers([item.t_end for item in found]))
    table.add("start_index", _indices(solution, [item.t_start for item in found]))
    table.add("end_index", _indices(solution, [item.t_end for item in found]))


def _links(solution: Simulated, table: _Columns) -> None:
    hits = solution.collisions
    sides = [solution.link_velocities(hit.event) for hit in hits]
    links = solution.mechanism.links
    table.add("collision", [hit.number for hit in hits for _ in links])
    table.add("link", [link for _ in hits for link in links])
    for side, when in enumerate(("before", "after")):
        spin = [pair[side].angular for pair in sides]
        centroid = np.array([pair[side].centroid for pair in sides]).reshape(-1, 2)
        table.add(f"angular_{when}_rad_s", np.array(spin).ravel(), "rad/s")
        for place, axis in enumerate("xz"):
            table.add(f"centroid_{axis}_{when}_m_s", centroid[:, place], "m/s")


def _motion(solution: Simulated, table: _Columns) -> None:
    """Both limits of every event: from the right at the start of a segment, left at its end."""
    mechanism, trajectory = solution.mechanism, solution.trajectory
    parts = []
    for segment in solution.segments:
        if segment.t_end > segment.t_start:
            t = np.linspace(segment.t_start, segment.t_end, _SAMPLES_PER_PHASE)
            parts += [(t[:-1], False), (t[-1:], True)]
    motion = [trajectory.evaluate(t, left=left) for t, left in parts]
    forces = [trajectory.reactions(t, left=left) for t, left in parts]
    none = np.empty(0)
    times = np.concatenate([none, *(t for t, _ in parts)])
    table.add("t_s", times, "s")
    table.add("limit", ["left" if left else "right" for t, left in parts for _ in t])
    table.add("cylinder_angle_rad", solution.shaft.angle(times), "rad")
    table.add("index", _indices(solution, times))
    for kind, per in (("q", ""), ("v", "/s")):
        states = np.concatenate([none.reshape(0, len(mechanism.joints))]
                                + [getattr(item, kind) for item in motion])  # fmt: skip
        for place, joint in enumerate(mechanism.joints):
            unit = coordinate_unit(mechanism, joint.index) + per
            table.add(f"{joint.name}{'_rate' * bool(per)}{_ending(unit)}", states[:, place], unit)
    for stop in mechanism.stops:
        values = np.concatenate([none, *(item.contacts[stop.name] for item in forces)])
        unit = force_unit(mechanism, stop)
        table.add(f"{stop.name}_contact_{_force(unit)}", values, unit)
    for drive in mechanism.drives:
        values = np.concatenate([none, *(item.drives[drive.name] for item in forces)])
        unit = "N" if coordinate_unit(mechanism, drive.index) == "m" else "N m"
        table.add(f"{drive.name}_{_force(unit)}", values, unit)


_FILLS = dict(zip(TABLES, (_collisions, _phases, _links, _motion), strict=True))


def _force(unit: str) -> str:
    return "force_N" if unit == "N" else "torque_N_m"


def _indices(solution: Simulated, times: Iterable[float]) -> list[float]:
    cylinder, shaft = solution.mechanism.cylinder, solution.shaft
    return [cylinder.index_from_angle(float(shaft.angle(t))) for t in times]


def _numbers(values: list[float | int | None]) -> Column:
    """Numbers as an array, NaN for none; whole ones as they are."""
    if any(isinstance(value, int) for value in values):
        return values
    return np.array([np.nan if value is None else value for value in values], dtype=float)
