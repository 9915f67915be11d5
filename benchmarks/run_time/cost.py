"""Run time of the parts of a simulation, and its growth with the size of the problem."""

from __future__ import annotations

import json
import subprocess
import sys
import tracemalloc
from typing import Any

import numpy as np

from nipper_pin.dynamics.system import DriveMode
from nipper_pin.errors import SimulationError
from nipper_pin.hybrid.case import Case, Window
from nipper_pin.hybrid.simulate import simulate
from nipper_pin.mechanism import Mechanism
from nipper_pin.units import US_PER_MS

from .phase_cost import phase_cost, transition_parts
from .scenes import bouncing_mass, bouncing_mass_rest, bouncing_mass_times, four_bar_chain
from .timing import timed

Rows = list[dict[str, Any]]

RESTITUTIONS = (0.2, 0.5, 0.8, 0.9, 0.95)
TURNS, QUICK_TURNS = (1, 3, 10, 30, 100), (1, 3, 10)
CHAINS, QUICK_CHAINS = (1, 2, 5, 10, 20, 40), (1, 2, 5, 10)
_BUDGET_S, _QUICK_BUDGET_S = 5.0, 0.6


def costs(mechanism: Mechanism, *, quick: bool, repeats: int) -> dict[str, Any]:
    """Measure all costs; quick, smaller numbers of turns and links."""
    budget = _QUICK_BUDGET_S if quick else _BUDGET_S
    return {
        "phases": phase_cost(mechanism, 450.0, repeats),
        "parts": transition_parts(mechanism, 650.0, repeats),
        "collisions": collision_cost(repeats, budget),
        "turns": turn_cost(mechanism, QUICK_TURNS if quick else TURNS, repeats, budget),
        "links": link_cost(QUICK_CHAINS if quick else CHAINS, repeats, budget),
        "memory": memory(turns=10 if quick else 100),
    }


def collision_cost(repeats: int, budget_s: float) -> Rows:
    """Growth with the number of collisions: the bouncing mass, whose motion is known exactly."""
    rows = []
    for e in RESTITUTIONS:
        mechanism = bouncing_mass(e)
        case = Case(speed_rpm=60.0)
        timing = timed(lambda: simulate(mechanism, case), repeats, budget_s)  # noqa: B023
        solution = simulate(mechanism, case)
        times = np.array([item.t for item in solution.collisions])
        rest = bouncing_mass_rest(e)
        shift = np.abs(times - bouncing_mass_times(e, len(times))).max()
        rows.append(
            {
                "restitution": e,
                "collisions": len(times),
                "wall_ms": timing.median_ms,
                "fastest_ms": timing.fastest_ms,
                "ms_per_collision": timing.median_ms / len(times),
                "evaluations": solution.evaluations,
                "error_duration": abs(solution.transitions[0].duration / rest - 1.0),
                "error_times": float(shift / rest),
            }
        )
    return rows


def turn_cost(mechanism: Mechanism, turns: tuple[int, ...], repeats: int, budget_s: float) -> Rows:
    """Growth with the number of turns, with and without reuse of turns that repeat exactly."""
    rows = []
    for count in turns:
        row: dict[str, Any] = {"turns": count}
        for key, reuse in (("reuse_ms", True), ("no_reuse_ms", False)):
            case = Case(speed_rpm=650.0, window=Window.CYCLE, cycles=count, reuse_cycles=reuse)
            row[key] = timed(lambda: simulate(mechanism, case), repeats, budget_s).median_ms  # noqa: B023
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
            row[f"{drive.value}_ms"] = timing.median_ms
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
    return batch.median_ms / states


_MEMORY = """
import json, sys
{work}
try:
    with open("/proc/self/status") as status:
        peak = next(int(line.split()[1]) for line in status if line.startswith("VmHWM"))
except OSError:
    import resource
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
print(json.dumps(peak / 1024.0))
"""


def memory(turns: int) -> Rows:
    """Peak resident memory of fresh processes, and what Python itself holds while it computes."""
    start = "from nipper_pin import *\nm = load()\n"
    many = f"Case(speed_rpm=650.0, window='cycle', cycles={turns}, reuse_cycles=False)"
    works = {
        "interpreter": "",
        "import pinocchio": "import pinocchio",
        "import nipper_pin": "import nipper_pin",
        "one transition": f"{start}s = simulate(m, Case(speed_rpm=650.0))",
        "one turn": f"{start}s = simulate(m, Case(speed_rpm=650.0, window='cycle'))",
        f"{turns} turns, each computed": f"{start}s = simulate(m, {many})",
    }
    rows: Rows = [
        {"what": what, "peak_MB": json.loads(run_python(_MEMORY.format(work=work)))}
        for what, work in works.items()
    ]
    return rows + [
        {"what": f"Python objects of {what}", "peak_MB": _traced(case)}
        for what, case in (
            ("one transition", Case(speed_rpm=650.0)),
            ("one turn", Case(speed_rpm=650.0, window=Window.CYCLE)),
        )
    ]


def _traced(case: Case) -> float:
    """Peak of what Python allocates in one run beyond what was there before [MB]."""
    mechanism = certified_model()
    simulate(mechanism, case)
    tracemalloc.start()
    simulate(mechanism, case)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    return peak / 2.0**20


def certified_model() -> Mechanism:
    """Load the E62 with its own values."""
    from .certified import certified

    return certified().mechanism()


def run_python(code: str) -> str:
    """Run code in a fresh interpreter and return what it prints.

    Raises:
        SimulationError: It fails; the message holds what it said.
    """
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    if done.returncode != 0:
        last = done.stderr.strip().splitlines()[-1:] or ["no message"]
        message = f"a fresh interpreter could not run the measurement: {last[0]}"
        raise SimulationError(message, code=code, stderr=done.stderr)
    return done.stdout
