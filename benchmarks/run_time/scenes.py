"""Mechanisms generated in code, for questions that one model cannot answer.

* A mass that bounces on a rising table: as many collisions as the restitution allows, in closed
  form; the comber's jaw comes to no rest in a turn if its restitution is large.
* A chain of N four-bars, the planar benchmark of Gonzalez, Dopico, Lugris and Cuadrado (A
  benchmarking system for MBS simulation software, Multibody Syst. Dyn. 16, 2006; IFToMM library of
  computational benchmark problems, "N four-bar mechanism"): all links 1 m and 1 kg, one degree of
  freedom whatever N. There the chain falls freely through the configuration in which all links
  are in line and the freedom is not one; here its first crank is driven and swings about the
  vertical, so that cost and not a singularity is what is measured.
"""

from __future__ import annotations

import math

from nipper_pin.mechanism import Mechanism
from nipper_pin.units import MM_PER_M

from ..stress.machines import small_machines
from ..stress.machines.parts import Source, description, frame, hinge, link, robot

TABLE_SPEED_M_S = 0.06
_GRAVITY = 9.81
_SWING_RAD = 0.5


def bouncing_mass(restitution: float) -> Mechanism:
    """Build the bouncing mass of 0.7 kg; its table rises with ``TABLE_SPEED_M_S`` at 60 r/min."""
    rise = MM_PER_M * TABLE_SPEED_M_S
    return small_machines.bouncing_mass(0.7, rise, restitution, _GRAVITY).mechanism()


def bouncing_mass_rest(restitution: float) -> float:
    """Time from the first collision to rest, 2 e V / (g (1 - e)) [s]."""
    return 2.0 * restitution * TABLE_SPEED_M_S / (_GRAVITY * (1.0 - restitution))


def bouncing_mass_times(restitution: float, count: int) -> list[float]:
    """Times of the first collisions, 2 e V (1 - e^k) / (g (1 - e)) [s]."""
    rest = bouncing_mass_rest(restitution)
    # expm1 keeps the digits of late collisions of a nearly elastic mass.
    return [-rest * math.expm1(k * math.log(restitution)) for k in range(count)]


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
