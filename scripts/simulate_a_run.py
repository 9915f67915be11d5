"""Simulate the E62-class nipper through the Python API: one transition, one cycle, three questions.

Run: python scripts/simulate_a_run.py
"""

from __future__ import annotations

import math

import nipper_pin as nip


def main() -> nip.Solution:
    """Print how the jaw bounces, what the cycle looks like and how hard the jaw clamps."""
    mechanism = nip.load("e62")
    print(mechanism.title)

    # How does the jaw come to rest at 650 r/min?
    solution = nip.simulate(mechanism, nip.Case(speed_rpm=650.0))
    for hit in solution.collisions:
        print(
            f"collision {hit.number}: {1e3 * hit.t:8.5f} ms  {hit.approach_rate:10.5f} rad/s  "
            f"{hit.impulse:.3e} N s  rebound {math.degrees(hit.rebound_amplitude or 0.0):.2e} deg"
        )
    transition = solution.transitions[0]
    print(f"at rest after {1e3 * transition.duration:.6f} ms: {solution.outcome.value}")

    # What happens in a whole turn?
    cycle = nip.simulate(mechanism, nip.Case(speed_rpm=650.0, window=nip.Window.CYCLE))
    index = mechanism.cylinder.index_from_angle
    for phase in cycle.phases:
        begin, end = (float(cycle.shaft.angle(t)) for t in (phase.t_start, phase.t_end))
        print(f"phase {phase.number}: index {index(begin):6.3f} to {index(end):6.3f}")

    # How hard is the cotton clamped while the jaw is closed?
    closed = next(phase for phase in cycle.phases if phase.closed == {"jaw"})
    middle = 0.5 * (closed.t_start + closed.t_end)
    force = cycle.trajectory.reactions(middle).contacts["jaw"][0]
    print(f"clamping force in the middle of phase 2: {force:.2f} N")
    print(
        f"energy balance {cycle.checks.energy_balance:.1e}, closure {cycle.checks.closure_m:.1e} m"
    )
    return solution


if __name__ == "__main__":
    main()
