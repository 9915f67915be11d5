"""A small machine with stops on both sides and one element of every kind."""

from __future__ import annotations

import numpy as np

from benchmarks.stress.machines.chains import Chain
from benchmarks.stress.machines.parts import Source
from nipper_pin import Case, Window

CASE = Case(speed_rpm=90.0, window=Window.CYCLE, start_index=0.0, max_collisions=60)


def everything() -> Source:
    """A chain on a swinging base, with two stops on a hinge and one element of every kind."""
    rng = np.random.default_rng(5)
    machine = Chain()
    machine.add_base(rng, "swing")
    machine.add_link(rng, True, 1.0)
    machine.add_link(rng, False, 0.5)
    machine.stop("j0", "lower", -0.2, 0.6)
    machine.stop("j0", "upper", 0.1, 0.4)
    machine.stop("j1", "upper", 0.05, 0.5)
    machine.spring("coil", "j0", 4.0, 0.3)
    machine.table("cushion", "j1", ([-3.0, -0.1, 0.02, 3.0], [-90.0, -3.0, 1.0, 95.0]))
    machine.damper("oil", "j1", 0.8)
    machine.strut(rng, "strut", 40.0, 1.5, 0.3)
    return machine.source("everything", 9.81, [])
