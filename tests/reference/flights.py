"""Write the dense reference of the first flights of the jaw at 650 r/min: ``e62_flights.json``.

Run from anywhere: ``python tests/reference/flights.py``. The flights between the collisions of
``e62_transition.json`` are expanded again and read at fixed fractions of each flight, so that a
comparison at equal fractions is not disturbed by shifted event times. As there, everything is
solved twice, with two precisions and two orders, and the greatest difference is written.
"""

from __future__ import annotations

import json
import time
from pathlib import Path
from typing import Any

import mpmath
from events import JAW, Settings, transition
from generate import COARSE, FINE, difference, shorten, text
from planar import Machine
from taylor import horner, safe_step, slope

CASE = {"speed_rpm": "650"}
FLIGHTS = 5
POINTS = 33


def fractions() -> list[Any]:
    """Places within a flight: Chebyshev points of the second kind on [0, 1]."""
    return [(1 - mpmath.cospi(mpmath.mpf(k) / (POINTS - 1))) / 2 for k in range(POINTS)]


def flight(machine: Machine, settings: Settings, start: Any, rate: Any, length: Any) -> Any:
    """Gaps and rates of the jaw at the fractions of one flight.

    Args:
        machine: the machine.
        settings: order and tolerance of the Taylor steps.
        start: time of the collision before it, s.
        rate: separation rate, rad/s.
        length: its duration, s.
    """
    ctx = machine.ctx
    tolerance = ctx.mpf(settings.tolerance)
    places = [length * sigma for sigma in fractions()]
    gaps, rates = [ctx.zero], [rate]
    done, th = ctx.zero, ctx.zero
    while len(gaps) < POINTS:
        angle = machine.psi_touch - machine.speed * (start + done)
        c = machine.flight(machine.frame(angle), th, rate).th.upto(settings.order)
        step = min(safe_step(c, tolerance, ctx), length - done)
        while len(gaps) < POINTS and (places[len(gaps)] <= done + step or done + step >= length):
            tau = places[len(gaps)] - done
            gaps.append(horner(c, tau))
            rates.append(horner(slope(c), tau))
        th, rate, done = horner(c, step), horner(slope(c), step), done + step
    # The last point is a collision: its gap is zero, what is left is round-off.
    gaps[-1] = ctx.zero
    return gaps, rates


def solve(digits: int, settings: Settings) -> list[dict[str, Any]]:
    """The first flights as plain data."""
    mpmath.mp.dps = digits
    machine = Machine(mpmath.mp, CASE)
    rows = []
    for collision in transition(machine, settings).collisions[:FLIGHTS]:
        length = collision.rebound_time
        gaps, rates = flight(machine, settings, collision.time, collision.separation_rate, length)
        rows.append(
            {
                "stop": JAW,
                "start_s": text(collision.time),
                "duration_s": text(length),
                "gap_rad": [text(x) for x in gaps],
                "rate_rad_s": [text(x) for x in rates],
            }
        )
    return rows


def main() -> None:
    """Solve twice and write the file."""
    begin = time.perf_counter()
    coarse, fine = solve(*COARSE), solve(*FINE)
    error, where = difference(coarse, fine)
    data = {
        "title": "E62 transition, dense motion of the first flights",
        "generator": "tests/reference/flights.py",
        "case": "650",
        "certified_error": f"{error:.1e}",
        "fractions": [shorten(text(x)) for x in fractions()],
        "flights": shorten(fine),
    }
    path = Path(__file__).resolve().parent / "e62_flights.json"
    path.write_text(json.dumps(data, indent=1) + "\n")
    print(f"greatest difference {error:.1e} at {where}, {time.perf_counter() - begin:.0f} s")


if __name__ == "__main__":
    main()
