"""Growth of the run time with the number of turns and of links.

Links are those of a chain of N four-bars, the planar benchmark of Gonzalez, Dopico, Lugris and
Cuadrado (A benchmarking system for MBS simulation software, Multibody Syst. Dyn. 16, 2006; IFToMM
library of computational benchmark problems, "N four-bar mechanism"): all links 1 m and 1 kg, one
degree of freedom whatever N. There the chain falls freely through the configuration in which all
links are in line and the freedom is not one; here its first crank is driven and swings about the
vertical, so that cost and not a singularity is what is measured.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from nipper_pin.dynamics import DriveMode
from nipper_pin.hybrid import Case, Window, simulate
from nipper_pin.mechanism import Mechanism
from nipper_pin.units import US_PER_MS

from ..stress.machines.parts import Source, description, frame, hinge, link, robot
from .timing import timed

Rows = list[dict[str, Any]]

TURNS, QUICK_TURNS = (1, 3, 10, 30, 100), (1, 3, 10)
CHAINS, QUICK_CHAINS = (1, 2, 5, 10, 20, 40), (1, 2, 5, 10)
_BUDGET_S, _QUICK_BUDGET_S = 5.0, 0.6
_GRAVITY = 9.81
_SWING_RAD = 0.5


def costs(mechanism: Mechanism, *, quick: bool, repeats: int) -> dict[str, Any]:
    """Measure both; quick, up to smaller numbers of turns and links."""
    budget = _QUICK_BUDGET_S if quick else _BUDGET_S
    return {
        "turns": turn_cost(mechanism, QUICK_TURNS if quick else TURNS, repeats, budget),
        "links": link_cost(QUICK_CHAINS if quick else CHAINS, repeats, budget),
    }


def turn_cost(mechanism: Mechanism, turns: tuple[int, ...], repeats: int, budget_s: float) -> Rows:
    """Growth with the number of turns, with and without reuse of turns that repeat exactly."""
    rows = []
    for count in turns:
        row: dict[str, Any] = {"turns": count}
        for key, reuse in (("reuse_ms", True), ("no_reuse_ms", False)):
            case = Case(speed_rpm=650.0, window=Window.CYCLE, cycles=count, reuse_cycles=reuse)
            row[key] = timed(lambda: simulate(mechanism, case), repeats, budget_s).wall_ms  # noqa: B023
        rows.append(row)
    return rows


def link_cost(counts: tuple[int, ...], repeats: int, budget_s: float) -> Rows:
    """Growth with the number of links: chains of N four-bars over one turn of the drive.

    Held, the drive determines the motion and nothing is integrated; inertial, the crank's shaft
    has a degree of freedom, so that the same chain is integrated.
    """
    rows = []
    for count in counts:
        mechanism = four_bar_chain(count)
        row: dict[str, Any] = {
            "four_bars": count,
            "links": 2 * count + 1,
            "cut_pins": len(mechanism.closures),
        }
        for drive in DriveMode:
            case = Case(speed_rpm=60.0, window=Window.CYCLE, start_index=0.0, drive=drive)
            timing = timed(lambda: simulate(mechanism, case), repeats, budget_s)  # noqa: B023
            solution = simulate(mechanism, case)
            row[f"{drive.value}_ms"] = timing.wall_ms
            row[f"{drive.value}_evaluations"] = solution.evaluations
            row[f"{drive.value}_energy_balance"] = solution.checks.energy_balance
        row["evaluation_us"] = US_PER_MS * _evaluation_ms(mechanism)
        rows.append(row)
    return rows


def _evaluation_ms(mechanism: Mechanism, states: int = 200) -> float:
    """Wall time of one evaluation of the constrained accelerations [ms], median of five batches."""
    solution = simulate(mechanism, Case(speed_rpm=60.0, window=Window.CYCLE, start_index=0.0))
    system = solution.system
    times = np.linspace(*solution.trajectory.span, states)
    motion = solution.trajectory.evaluate(times)
    phase = system.constraint_set(frozenset())
    driven = system.shaft.driven(times)
    batch = timed(lambda: system.accelerations(driven, motion.q, motion.v, phase), 5)
    return batch.wall_ms / states


def four_bar_chain(count: int) -> Mechanism:
    """Build a chain of N four-bars: cranks 0 to N on the ground 1 m apart, couplers 1 to N on top.

    Crank 0 swings by 0.5 rad sin psi; with parallelograms all cranks do, and couplers stay level.
    """
    parts: list[str] = []
    closures = {}
    for number in range(count + 1):
        arm, after = f"arm_{number}", number + 1
        parts += [link(arm, 1.0, 1.0 / 12.0, (0.0, 0.5)),
                  hinge(f"crank_{number}", "frame", arm, (float(number), 0.0))]  # fmt: skip
        if number < count:
            coupler = f"coupler_{after}"
            parts += [link(coupler, 1.0, 1.0 / 12.0, (0.5, 0.0)),
                      hinge(f"pin_{after}", arm, coupler, (0.0, 1.0)),
                      frame(f"end_{after}", coupler, (1.0, 0.0))]  # fmt: skip
        if number > 0:
            parts.append(frame(f"tip_{number}", arm, (0.0, 1.0)))
            closures[f"pin_{number}"] = {"frame_a": f"end_{number}", "frame_b": f"tip_{number}"}
    texts = description(f"chain of {count} four-bars", 1, _GRAVITY)
    texts["drives"] = {
        "crank": {
            "joint": "crank_0", "law": "fourier", "sine_rad": [_SWING_RAD],
            "reflected_inertia_kg_m2": 10.0, "shaft_frequency_hz": 5.0, "shaft_damping_ratio": 0.7,
        }
    }  # fmt: skip
    texts["closures"] = closures
    texts["phases"] = [{"number": 1, "name": "swinging", "closed": []}]
    return Source("chain", robot("chain", parts), texts, ".").mechanism()
