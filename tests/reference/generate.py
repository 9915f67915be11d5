"""Write the reference of the planar nipper: ``e62_transition``, ``_cycle`` and ``_flights.json``.

Run from anywhere: ``python tests/reference/generate.py``. Every case is solved twice, with two
working precisions, two Taylor orders (hence other step sizes) and two ends of the bounce series;
the numbers that are written come from the finer solution, and the greatest difference between
the two is written with them.
"""

from __future__ import annotations

import argparse
import datetime
import json
import platform
import sys
import time
from pathlib import Path
from typing import Any

import mpmath

sys.path.insert(0, str(Path(__file__).resolve().parent))

from events import JAW, STEEVE, Phase, Settings, Trace, cycle, glued_stop_force, transition
from planar import PARAMETERS, Machine
from taylor import horner, safe_step, slope

COARSE = (40, Settings(order=38, tolerance="1e-32", shortest="1e-19"))
FINE = (60, Settings(order=58, tolerance="1e-50", shortest="1e-22"))
"""Decimal working digits and settings of the two solutions."""

DIGITS = 25
COMPARED_DIGITS = 38
RECORDED = 12
"""Collisions written of each bounce series."""

FLIGHTS, POINTS = 5, 33
"""Flights of the jaw that are written densely, and places of each."""

NEGLIGIBLE = 1e-24
"""A multiplier at its own zero and the gap of a closed stop are written as zero below this."""

TRANSITIONS: list[tuple[str, dict[str, str]]] = [
    ("450", {"speed_rpm": "450"}),
    ("550", {"speed_rpm": "550"}),
    ("650", {"speed_rpm": "650"}),
    ("650_e0.05", {"speed_rpm": "650", "jaw_restitution": "0.05"}),
    ("650_e0.25", {"speed_rpm": "650", "jaw_restitution": "0.25"}),
    ("650_e0.5", {"speed_rpm": "650", "jaw_restitution": "0.5"}),
    ("650_k7000", {"speed_rpm": "650", "stiffness_N_per_m": "7000"}),
    ("650_k11000", {"speed_rpm": "650", "stiffness_N_per_m": "11000"}),
]
CYCLES: list[tuple[str, dict[str, str]]] = [
    ("450", {"speed_rpm": "450"}),
    ("650", {"speed_rpm": "650"}),
]

UNITS = {
    "time_s": "from the first collision (transition) or from index 24 (cycle)",
    "cylinder_angle_rad": "of the crank pin, counter-clockwise from x; it falls with time",
    "index": "40 to a turn, 24 where the pendulum shaft has its least angle (nipper foremost)",
    "approach_rate, separation_rate": "of the stop's coordinate: jaw rad/s, steeve m/s; < 0 closes",
    "effective_inertia": "jaw A = d2T/dth'2 in kg m2; steeve A / (ds/dth)^2 in kg",
    "impulse": "effective inertia times change of rate: jaw N m s, steeve N s",
    "impulse_lip_N_s": "jaw impulse over the lever, normal to it",
    "energy_lost_J": "1/2 effective inertia * approach_rate^2 (1 - e^2), drives held",
    "rebound_amplitude, rebound_time_s": "greatest coordinate, and time, to the next collision",
    "th_rad, stroke_m": "jaw angle and steeve stroke, both zero at touch, both >= 0",
    "force": "multiplier of the closed stop, > 0 presses: steeve N; jaw N m about the jaw pivot",
}


def text(x: Any, zero_below: float = 0.0) -> str | None:
    """Decimal string of a number, long enough for the comparison."""
    if x is None:
        return None
    if abs(x) <= zero_below:
        return "0.0"
    return str(mpmath.nstr(x, COMPARED_DIGITS, min_fixed=-3, max_fixed=6))


def shorten(data: Any) -> Any:
    """The same data with every decimal string rounded to the written digits."""
    if isinstance(data, dict):
        return {k: shorten(v) for k, v in data.items()}
    if isinstance(data, list):
        return [shorten(v) for v in data]
    if isinstance(data, str) and len(data) > DIGITS:
        return mpmath.nstr(mpmath.mpf(data), DIGITS, min_fixed=-3, max_fixed=6)
    return data


def collisions(machine: Machine, trace: Trace) -> list[dict[str, Any]]:
    """The first collisions of every bounce series of a trace."""
    rows: list[dict[str, Any]] = []
    ends = [last for _, _, last in trace.rests]
    series = 0
    in_series = 0
    for c in trace.collisions:
        if series < len(ends) and c.time > ends[series]:
            series, in_series = series + 1, 0
        in_series += 1
        if in_series > RECORDED:
            continue
        row = {
            "number": in_series,
            "series": series + 1,
            "stop": c.stop,
            "time_s": text(c.time),
            "cylinder_angle_rad": text(c.psi),
            "index": text(machine.index(c.psi)),
            "approach_rate": text(c.approach_rate),
            "separation_rate": text(c.separation_rate),
            "effective_inertia": text(c.effective_inertia),
            "impulse": text(c.impulse),
            "energy_lost_J": text(c.energy_lost),
            "rebound_amplitude": text(c.rebound_amplitude),
            "rebound_time_s": text(c.rebound_time),
            "th_rad": text(c.th),
            "th_rate_before": text(c.th_rate_before),
            "th_rate_after": text(c.th_rate_after),
            "stroke_m": text(c.stroke),
            "stroke_rate_before": text(c.stroke_rate_before),
            "stroke_rate_after": text(c.stroke_rate_after),
        }
        if c.stop == JAW:
            row["impulse_lip_N_s"] = text(c.impulse / machine.lever)
        rows.append(row)
    return rows


def transition_case(machine: Machine, settings: Settings) -> dict[str, Any]:
    """One transition as plain data."""
    trace = transition(machine, settings)
    rest = trace.rests[0][1]
    first = trace.collisions[:2]
    share = sum(c.rebound_time for c in first if c.rebound_time is not None) / rest
    return {
        "rest_time_s": text(rest),
        "rest_index": text(machine.index(machine.psi_touch - machine.speed * rest)),
        "first_two_share": text(share),
        "energy_lost_total_J": text(sum(c.energy_lost for c in trace.collisions)),
        "collisions": collisions(machine, trace),
    }


def fractions() -> list[Any]:
    """Places within a flight: Chebyshev points of the second kind on [0, 1]."""
    return [(1 - mpmath.cospi(mpmath.mpf(k) / (POINTS - 1))) / 2 for k in range(POINTS)]


def first_flights(machine: Machine, settings: Settings) -> dict[str, Any]:
    """Gaps and rates of the jaw at the fractions of its first flights, as plain data.

    A comparison at equal fractions is not disturbed by shifted event times.
    """
    ctx, rows = machine.ctx, []
    tolerance = ctx.mpf(settings.tolerance)
    for hit in transition(machine, settings).collisions[:FLIGHTS]:
        length, th, rate, done = hit.rebound_time, ctx.zero, hit.separation_rate, ctx.zero
        places, gaps, rates = [length * sigma for sigma in fractions()], [th], [rate]
        while len(gaps) < POINTS:
            angle = machine.psi_touch - machine.speed * (hit.time + done)
            c = machine.flight(machine.frame(angle), th, rate).th.upto(settings.order)
            step = min(safe_step(c, tolerance, ctx), length - done)
            last = done + step >= length
            while len(gaps) < POINTS and (places[len(gaps)] <= done + step or last):
                tau = places[len(gaps)] - done
                gaps.append(horner(c, tau))
                rates.append(horner(slope(c), tau))
            th, rate, done = horner(c, step), horner(slope(c), step), done + step
        # The last point is a collision: its gap is zero, what is left is round-off.
        gaps[-1] = ctx.zero
        row: dict[str, Any] = {"stop": JAW, "start_s": text(hit.time), "duration_s": text(length)}
        row |= {"gap_rad": [text(x) for x in gaps], "rate_rad_s": [text(x) for x in rates]}
        rows.append(row)
    return {"flights": rows}


def samples(machine: Machine, phase: Phase) -> list[dict[str, Any]]:
    """Exact states and forces of a phase with a closed stop, at every whole index."""
    rows = []
    expand = machine.phase1 if phase.closed == STEEVE else machine.phase2
    per_index = 2 * machine.ctx.pi / 40
    for index in range(24, 65):
        moment = (index - 24) * per_index / machine.speed
        if not phase.start <= moment < phase.end:
            continue
        motion, force = expand(machine.frame(machine.psi_foremost() - machine.speed * moment))
        rows.append(
            {
                "index": index,
                "th_rad": text(motion.th[0], NEGLIGIBLE),
                "th_rate": text(motion.th[1], NEGLIGIBLE),
                "stroke_m": text(motion.stroke[0], NEGLIGIBLE),
                "stroke_rate": text(motion.stroke_rate[0], NEGLIGIBLE),
                "force": text(force[0]),
            }
        )
    return rows


def cycle_case(machine: Machine, settings: Settings) -> dict[str, Any]:
    """One working cycle as plain data."""
    trace = cycle(machine, settings)

    def index(moment: Any) -> str | None:
        if moment is None:
            return None
        return text(machine.index(machine.psi_foremost() - machine.speed * moment))

    phases = []
    for p in trace.phases:
        row: dict[str, Any] = {
            "closed": p.closed,
            "start_s": text(p.start),
            "start_index": index(p.start),
            "end_s": text(p.end),
            "end_index": index(p.end),
            "ended_by": p.ended_by,
        }
        if p.closed:
            row |= {
                "force_start": text(p.force_start, NEGLIGIBLE),
                "force_end": text(p.force_end, NEGLIGIBLE),
                "force_min": text(p.force_min, NEGLIGIBLE),
                "force_min_index": index(p.force_min_time),
                "force_max": text(p.force_max, NEGLIGIBLE),
                "force_max_index": index(p.force_max_time),
                "samples": samples(machine, p),
            }
        if p.closed == JAW:
            row["lip_force_min_N"] = text(p.force_min / machine.lever)
            row["lip_force_max_N"] = text(p.force_max / machine.lever)
        phases.append(row)
    glued = glued_stop_force(machine, settings)
    return {
        "steeve_leaves_stop_in_phase1": any(
            p.closed == STEEVE and p.ended_by == "release" for p in trace.phases
        ),
        "glued_stop_force_min_N": text(glued.force_min),
        "glued_stop_force_min_index": index(glued.force_min_time),
        "rests": [
            {"stop": stop, "time_s": text(rest), "index": index(rest)}
            for stop, rest, _ in trace.rests
        ],
        "energy_lost_total_J": text(sum(c.energy_lost for c in trace.collisions)),
        "phases": phases,
        "collisions": collisions(machine, trace),
    }


def difference(a: Any, b: Any, path: str = "") -> tuple[float, str]:
    """Greatest relative difference of the numbers in two solutions, and where it is.

    Raises:
        ValueError: the solutions differ in something that is not a number.
    """
    if isinstance(a, dict) and isinstance(b, dict) and a.keys() == b.keys():
        pairs = [difference(a[k], b[k], f"{path}.{k}") for k in a]
        return max(pairs, default=(0.0, path))
    if isinstance(a, list) and isinstance(b, list) and len(a) == len(b):
        pairs = [
            difference(x, y, f"{path}[{i}]") for i, (x, y) in enumerate(zip(a, b, strict=True))
        ]
        return max(pairs, default=(0.0, path))
    if a == b:
        return 0.0, path
    if isinstance(a, str) and isinstance(b, str):
        x, y = mpmath.mpf(a), mpmath.mpf(b)
        return float(abs(x - y) / max(abs(x), abs(y))), path
    message = f"{path}: {a!r} against {b!r}"
    raise ValueError(message)


def solve_twice(solve: Any, changes: dict[str, str]) -> tuple[dict[str, Any], float]:
    """Fine solution of a case and its greatest difference from the coarse one."""
    results = []
    for digits, settings in (COARSE, FINE):
        mpmath.mp.dps = digits
        results.append(solve(Machine(mpmath.mp, changes), settings))
    error, where = difference(*results)
    print(f"    greatest difference {error:.1e} at {where}", flush=True)
    return shorten(results[1]), error


def critical_speed(digits: int, settings: Settings) -> Any:
    """Least speed (r/min) at which the steeve stop force reaches zero in phase 1.

    The stop force is linear in the square of the speed at every cylinder angle.
    """
    mpmath.mp.dps = digits

    def least(square: Any) -> Any:
        speed = mpmath.nstr(mpmath.sqrt(square), digits)
        machine = Machine(mpmath.mp, {"speed_rpm": speed})
        return glued_stop_force(machine, settings).force_min

    a, b = mpmath.mpf(550) ** 2, mpmath.mpf(650) ** 2
    fa, fb = least(a), least(b)
    for _ in range(12):
        c = b - fb * (b - a) / (fb - fa)
        a, fa, b, fb = b, fb, c, least(c)
        if abs(b - a) < abs(b) * mpmath.mpf(10) ** -26:
            break
    return mpmath.sqrt(b)


def header(title: str) -> dict[str, Any]:
    """What is said about the origin of the numbers."""
    return {
        "title": title,
        "generator": "tests/reference/generate.py",
        "method": "closed-form planar geometry, one coordinate, Taylor series in time, Newton on "
        "the series for events, bounce series summed and closed by its geometric limit",
        "software": f"Python {platform.python_version()}, mpmath {mpmath.__version__}",
        "date": datetime.datetime.now(tz=datetime.UTC).date().isoformat(),
        "solutions": [
            {
                "working_digits": digits,
                "taylor_order": s.order,
                "step_tolerance": s.tolerance,
                "shortest_flight_s": s.shortest,
            }
            for digits, s in (COARSE, FINE)
        ],
        "written": f"the second solution, {DIGITS} digits",
        "parameters": PARAMETERS,
        "units": UNITS,
    }


def run(
    title: str, cases: list[tuple[str, dict[str, str]]], solve: Any
) -> tuple[dict[str, Any], float]:
    """Solve a list of cases."""
    data = header(title)
    worst = 0.0
    found = {}
    for name, changes in cases:
        print(f"{title}: {name}", flush=True)
        start = time.perf_counter()
        result, error = solve_twice(solve, changes)
        print(f"    {time.perf_counter() - start:.1f} s", flush=True)
        worst = max(worst, error)
        found[name] = {"changes": changes, "certified_error": f"{error:.1e}", **result}
    data["certified_error"] = f"{worst:.1e}"
    data["certified_by"] = (
        "greatest relative difference of any written number between the two solutions, compared "
        f"to {COMPARED_DIGITS} digits before rounding to {DIGITS}; both solutions use the same "
        "equations, so this is the numerical error only"
    )
    data["cases"] = found
    return data, worst


def main() -> None:
    """Solve everything and write the files."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=Path(__file__).resolve().parent)
    out = parser.parse_args().out
    start = time.perf_counter()
    data, worst_transition = run("E62 transition", TRANSITIONS, transition_case)
    mpmath.mp.dps = FINE[0]
    data["jaw_lever_m"] = shorten(text(Machine(mpmath.mp).lever))
    (out / "e62_transition.json").write_text(json.dumps(data, indent=1) + "\n")
    data, worst_cycle = run("E62 working cycle", CYCLES, cycle_case)
    print("critical speed", flush=True)
    coarse, fine = critical_speed(*COARSE), critical_speed(*FINE)
    error = abs(coarse - fine) / fine
    print(f"    {mpmath.nstr(fine, 15)} r/min, difference {mpmath.nstr(error, 2)}", flush=True)
    mpmath.mp.dps = FINE[0]
    machine = Machine(mpmath.mp)
    data["jaw_lever_m"] = shorten(text(machine.lever))
    data["touch_index"] = shorten(text(machine.index(machine.psi_touch)))
    data["speed_where_stop_force_reaches_zero_rpm"] = shorten(text(fine))
    data["speed_where_stop_force_reaches_zero_error"] = mpmath.nstr(error, 2)
    (out / "e62_cycle.json").write_text(json.dumps(data, indent=1) + "\n")
    flights, error = solve_twice(first_flights, {"speed_rpm": "650"})
    data = {
        "title": "E62 transition, dense motion of the first flights",
        "generator": "tests/reference/generate.py",
        "case": "650",
        "certified_error": f"{error:.1e}",
        "fractions": [shorten(text(x)) for x in fractions()],
        **flights,
    }
    (out / "e62_flights.json").write_text(json.dumps(data, indent=1) + "\n")
    print(f"worst {max(worst_transition, worst_cycle):.1e}, {time.perf_counter() - start:.0f} s")


if __name__ == "__main__":
    main()
