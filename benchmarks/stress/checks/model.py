"""Check that the built machine is the one that its texts describe."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from math import pi
from typing import Any

import numpy as np

from nipper_pin.hybrid import Solution
from nipper_pin.mechanism import Mechanism

from ...tolerances import EPS, SAME_MODEL
from ..mechanics.planar_tree import PlanarTree
from ..observations import beyond, samples

_STATES = 4


def built(solution: Solution) -> Iterator[str]:
    """Masses, places, weight, springs, stops and speed are those of the texts."""
    mechanism, body = solution.mechanism, solution.system.body
    tree = PlanarTree.of(mechanism)
    carried = tree.masses @ tree.moved[:-1]
    states = [q for _, panel, _ in samples(solution) for q in (panel.q[0], panel.q[-1])]
    for q in states[:: max(len(states) // _STATES, 1)]:
        told, found = tree.mass_matrix(q), body.mass_matrix(q)
        # Light links hang on heavy ones.
        heavy = np.sqrt(np.outer(*[np.diag(told)] * 2))
        off = np.abs(found - told) / np.maximum(heavy, 1e-300)
        yield from beyond(
            "mass matrix is not that of the text [share]", float(off.max()), SAME_MODEL
        )
        still = np.zeros((1, len(q)))
        weight = body.inverse_dynamics(q[None], still, still)[0]
        off = np.abs(weight - tree.inverse_dynamics(q, still[0], still[0]))
        # At least the sum of m g times the levers, also where these cancel (Cauchy and Schwarz).
        off /= np.maximum(tree.gravity * np.sqrt(carried * np.diag(told)), 1e-300)
        yield from beyond("weight is not that of the text [share]", float(off.max()), SAME_MODEL)
    period = 60.0 / solution.case.speed_rpm
    yield from beyond("period is not that of the speed [share]",
                       abs(solution.shaft.period / period - 1.0), 8.0 * EPS)  # fmt: skip
    told_numbers, found_numbers = _told(mechanism), _found(mechanism)
    if set(told_numbers) != set(found_numbers):
        yield f"other elements than in the text: {sorted(set(told_numbers) ^ set(found_numbers))}"
    for name in told_numbers.keys() & found_numbers.keys():
        one, other = (np.array(item[name]) for item in (told_numbers, found_numbers))
        off = np.abs(one - other) - 8.0 * EPS * np.abs(one)
        yield from beyond(f"{name} is not that of the text", float(off.max(initial=0.0)), 0.0)


def _told(mechanism: Mechanism) -> dict[str, tuple[float, ...]]:
    """Numbers of elements and stops from the document, in SI units."""
    document: Mapping[str, Any] = mechanism.description
    told: dict[str, tuple[float, ...]] = {}
    for name, item in document.get("springs", {}).items():
        where = f"spring {name}"
        if "frame_a" in item:
            told[where] = (item["stiffness_N_per_m"], item["free_length_mm"] / 1e3)
        elif "force_N" in item:
            told[where] = (*(x / 1e3 for x in item["coordinate_mm"]), *item["force_N"])
        elif "torque_N_m" in item:
            turned = (x * pi / 180.0 for x in item["coordinate_deg"])
            told[where] = (*turned, *item["torque_N_m"])
        elif "preload_deg" in item:
            told[where] = (item["stiffness_N_m_per_rad"], item["preload_deg"] * pi / 180.0)
        else:
            told[where] = (item["stiffness_N_per_m"], item["preload_length_mm"] / 1e3)
    for name, item in document.get("dampers", {}).items():
        (value,) = (item[key] for key in item if key.startswith("damping"))
        told[f"damper {name}"] = (value,)
    for name, item in document.get("stops", {}).items():
        at = item.get("at_deg", 0.0) * pi / 180.0 + item.get("at_mm", 0.0) / 1e3
        sense = {"lower": 1.0, "upper": -1.0}[item.get("side", "lower")]
        told[f"stop {name}"] = (item["restitution"], at, sense)
    for name, item in document.get("drives", {}).items():
        inertia = sum(item[key] for key in item if key.startswith("reflected"))
        elastic = (item.get(f"shaft_{key}", 0.0) for key in ("frequency_hz", "damping_ratio"))
        told[f"drive {name}"] = (inertia, *elastic)
    return told


def _found(mechanism: Mechanism) -> dict[str, tuple[float, ...]]:
    """The same of the machine that was built."""
    found: dict[str, tuple[float, ...]] = {}
    for spring in mechanism.springs:
        found[f"spring {spring.name}"] = (spring.stiffness, spring.preload)
    for table in mechanism.tabulated_springs:
        rows = table.characteristic
        found[f"spring {table.name}"] = (*rows.coordinate, *rows.force)
    for damper in mechanism.dampers:
        found[f"damper {damper.name}"] = (damper.damping,)
    for strut in mechanism.struts:
        numbers = (strut.stiffness, strut.free_length)
        found[f"{strut.kind} {strut.name}"] = (
            numbers if strut.kind == "spring" else (strut.damping,)
        )
    for stop in mechanism.stops:
        found[f"stop {stop.name}"] = (stop.restitution, stop.at, stop.sense)
    for drive in mechanism.drives:
        numbers = (drive.reflected_inertia, drive.shaft_frequency_hz)
        found[f"drive {drive.name}"] = (*numbers, drive.shaft_damping_ratio)
    return found
