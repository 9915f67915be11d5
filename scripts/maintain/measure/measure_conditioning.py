"""How much accuracy is lost near a dead centre, against the distance from it.

A four-bar whose coupler and rocker are (1 + d) times as long together as they need to be for its
crank to pass half a turn is followed through that place for d from 1e-1 down to 1e-14. Velocities
at half a turn are compared with the closed form in 50 digits (mpmath); the condition number of the
closures there is of order 1 / sqrt(d). What cannot be followed is refused, with the place.

    python scripts/maintain/measure/measure_conditioning.py [--out docs/images/conditioning.svg]
"""

from __future__ import annotations

import argparse
from math import inf

import matplotlib as mpl
import mpmath as mp  # type: ignore[import-untyped]
import numpy as np

from benchmarks.stress.machines.parts import Source
from benchmarks.stress.machines.small_machines import four_bar
from nipper_pin import Case, SimulationError, Window, simulate
from nipper_pin.dynamics import weakest
from nipper_pin.mechanism import from_sources

GROUND, CRANK = 0.10, 0.04
EPS = float(np.finfo(float).eps)


def machine(distance: float) -> Source:
    """The four-bar at this distance from its dead centre."""
    both = (GROUND + CRANK) * (1.0 + distance)
    return four_bar(GROUND, CRANK, 0.5 * both - 0.01, 0.5 * both + 0.01, (0.1, 0.2, 0.3))


def exact_rate(source: Source, crank: float, rate: float) -> float:
    """Rate of the rocker [rad/s] at a crank angle, from the lengths of the model's own frames."""
    text = source.urdf

    def place(joint: str) -> tuple[mp.mpf, mp.mpf]:
        part = text.split(f'joint name="{joint}"')[1].split('xyz="')[1].split('"')[0].split()
        return mp.mpf(float(part[0])), mp.mpf(float(part[2]))

    (ex, ez), (rx, rz) = place("coupler_end_fixed"), place("rocker_end_fixed")
    arm, ground = place("crank_pin")[0], place("rocker_axis")[0]
    coupler, rocker = mp.hypot(ex, ez), mp.hypot(rx, rz)
    angle = mp.mpf(crank)
    # Pin of the crank as seen from the rocker's axis; the triangle over it closes the loop.
    x, z = arm * mp.cos(angle) - ground, arm * mp.sin(angle)
    base = mp.hypot(x, z)
    cosine = (base**2 + rocker**2 - coupler**2) / (2 * base * rocker)
    direction_rate = (x * arm * mp.cos(angle) + z * arm * mp.sin(angle)) / base**2
    base_rate = (-x * arm * mp.sin(angle) + z * arm * mp.cos(angle)) / base
    cosine_rate = (base**2 - rocker**2 + coupler**2) / (2 * base**2 * rocker)
    opening_rate = -cosine_rate * base_rate / mp.sqrt(1 - cosine**2)
    return float(mp.mpf(rate) * (direction_rate - opening_rate))


def measure(distance: float) -> tuple[float, float, float, str]:
    """Condition, error of the rocker's rate, energy balance, and a word about the run."""
    source = machine(distance)
    mechanism = from_sources(source.name, source.urdf, source.description, source.folder)
    case = Case(speed_rpm=300.0, window=Window.CYCLE, start_index=0.0)
    try:
        solution = simulate(mechanism, case)
    except SimulationError as error:
        evidence = error.evidence
        word = f"refused at index {evidence['index']:.6f}, by {', '.join(evidence['joints'])}"
        return float(evidence["condition"]), inf, inf, word
    t = 0.5 * solution.shaft.period
    motion = solution.trajectory.evaluate(t)
    rocker = next(joint.index for joint in mechanism.joints if joint.name == "rocker_axis")
    _, jacobian = solution.system.body.closures(motion.q)
    exact = exact_rate(source, float(motion.q[0, 0]), float(motion.v[0, 0]))
    scale = float(np.abs(motion.v).max())
    off = abs(float(motion.v[0, rocker]) - exact) / scale
    balance = solution.checks.energy_balance
    return weakest(jacobian[0], [0])[0], off, balance, f"{solution.evaluations} evaluations"


def main() -> None:
    """Print the table and draw the plot."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", metavar="FILE", help="write the plot")
    options = parser.parse_args()
    mp.mp.dps = 50
    rows = [(10.0**-n, *measure(10.0**-n)) for n in range(1, 15)]
    print("distance  condition  error of rate  energy balance")
    for distance, condition, error, balance, word in rows:
        print(f"{distance:8.0e}  {condition:9.2e}  {error:13.1e}  {balance:14.1e}  {word}")
    if options.out is None:
        return
    mpl.use("Agg")
    # The same file whenever it is drawn: no date, no random names.
    mpl.rcParams["svg.hashsalt"] = "conditioning"
    import matplotlib.pyplot as plt

    passed = np.array([row[:4] for row in rows if row[2] < inf])
    refused = [row[0] for row in rows if row[2] == inf]
    figure, axes = plt.subplots(figsize=(6.4, 4.0), layout="constrained")
    axes.loglog(passed[:, 0], np.maximum(passed[:, 2], EPS), "o-", label="rate of the rocker")
    axes.loglog(passed[:, 0], np.maximum(passed[:, 3], EPS), "s-", label="energy balance")
    axes.loglog(
        passed[:, 0], EPS * passed[:, 1] ** 2, "--", label="round-off times condition squared"
    )
    if refused:
        axes.axvspan(min(refused) / 2.0, max(refused) * 2.0, alpha=0.15, label="refused")
    axes.set_xlabel("distance from the dead centre, relative")
    axes.set_ylabel("relative error")
    axes.legend()
    figure.savefig(options.out, metadata={"Date": None})


if __name__ == "__main__":
    main()
