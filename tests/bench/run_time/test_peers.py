"""The peers of the benchmark solve the scene that they are compared on.

tests/reference holds the certified numbers; they come from a derivation in 60 digits that shares no
code with the peers, so a wrong equation, start, impact law or bookkeeping changes the first digits.
"""

from __future__ import annotations

import json
from dataclasses import astuple
from importlib import import_module
from pathlib import Path
from typing import Any

import pytest

from benchmarks.peers import Four, Setting
from benchmarks.peers.protocol import Bounces
from nipper_pin import Mechanism, load

SPEED_RPM = 650.0
CASES = json.loads(
    (Path(__file__).parents[2] / "reference" / "e62_transition.json").read_text(encoding="utf-8")
)["cases"]
ROOM = "benchmarks.peers"

# Module, the package it needs beside numba, one quick setting, and the error (worst of four) that
# docs/benchmark.md has, rounded up to a power of ten with at least a factor two to spare.
CLAIMS = [
    ("rk4", "numba", "100 us", 1e-8),
    ("rk4", "numba", "20 us", 1e-11),
    ("scipy_ivp", "scipy", "rtol 1e-9", 1e-8),
    ("scipy_ivp", "scipy", "rtol 1e-13", 1e-12),
    ("scipy_pinocchio", "scipy", "rtol 1e-9", 1e-8),
    ("scipy_pinocchio", "scipy", "rtol 1e-13", 1e-12),
    ("fixed_steps", "numba", "1 us, forward Euler", 1e-2),
    ("fixed_steps", "numba", "0.1 us, semi-implicit", 1e-3),
    ("mujoco_shell", "mujoco", "100 us", 1e-8),
]

# Packages of others warn of their own doings when they are imported.
pytestmark = pytest.mark.filterwarnings("ignore::DeprecationWarning")


def _peer(name: str, needs: str) -> Any:
    """A peer, where its package is installed."""
    pytest.importorskip("numba")
    pytest.importorskip(needs)
    return import_module(f"{ROOM}.{name}")


def _worst(four: Four, case: str = "650") -> float:
    """Largest relative error of the four numbers."""
    (first, second), rest = CASES[case]["collisions"][:2], CASES[case]["rest_time_s"]
    right = first["rebound_time_s"], second["rebound_time_s"], first["rebound_amplitude"], rest
    # Behind them stands the number of evaluations.
    return max(abs(f / float(r) - 1.0) for f, r in zip(astuple(four), right, strict=False))


@pytest.mark.sampled(3)
@pytest.mark.parametrize(("name", "needs", "label", "claim"), CLAIMS)
def test_a_peer_is_as_accurate_as_the_docs_say(
    e62: Mechanism, name: str, needs: str, label: str, claim: float
) -> None:
    """All four numbers, within the stated error.

    Not by accident: the claims are 1e-2 to 1e-12 of numbers that differ from each other by
    factors of 5 to 20, and of each peer all four have to agree.
    """
    peer = _peer(name, needs)
    setting = next(item for item in peer.SETTINGS if item.label == label)
    assert setting.quick
    four = peer.prepare(e62, SPEED_RPM)(setting)
    assert _worst(four) <= claim
    assert four.evaluations > 0


@pytest.mark.parametrize("case", [name for name in CASES if "e0.5" not in name])
def test_the_hand_derived_equation_agrees_with_the_reference(case: str) -> None:
    """RK4 with 10 us on the planar equation, for every speed, restitution and spring, to 1e-11.

    The method's own error there is below 2e-13 (it falls as the fourth power of the step, 6e-11 at
    50 us). Parameters come from the loaded model, so a number taken from the wrong link shows in
    some case even where another hides it.
    """
    rk4 = _peer("rk4", "numba")
    paths = {
        "jaw_restitution": "stops.jaw.restitution",
        "stiffness_N_per_m": "springs.steeve.stiffness_N_per_m",
    }
    changes = dict(CASES[case]["changes"])
    speed = float(changes.pop("speed_rpm"))
    model = load("e62", {paths[key]: value for key, value in changes.items()})
    four = rk4.prepare(model, speed)(Setting("", 1e-5))
    assert _worst(four, case) <= 1e-11


@pytest.mark.parametrize(("name", "coarse", "fine", "order"), [
    ("rk4", 1e-4, 5e-5, 4),
    ("fixed_steps", 1e-6, 1e-7, 1),
])  # fmt: skip
def test_fixed_steps_have_the_order_of_their_method(
    e62: Mechanism, name: str, coarse: float, fine: float, order: int
) -> None:
    """The worst error falls with the step by the order of the method, within a factor of two.

    An event located to a lower order, or an error in the equation, would level it off.
    """
    peer = _peer(name, "numba")
    run = peer.prepare(e62, SPEED_RPM)
    worst = [_worst(run(Setting("", step, method="forward"))) for step in (coarse, fine)]
    expected = (coarse / fine) ** order
    assert expected / 2.0 <= worst[0] / worst[1] <= expected * 2.0


def test_bounces_close_a_series_at_its_limit() -> None:
    """A ball on the ground: flights 2 w / g with w falling by e rest at 2 w_0 / (g (1 - e)).

    The limit is exact after the first two collisions, so any error of the bookkeeping shows.
    """
    g, e, w = 10.0, 0.5, 1.0
    bounces = Bounces(e, w, g, 1e-12)
    t, over, amplitude = 0.0, False, 0.5 * w * w / g
    bounces.amplitude = amplitude
    while not over:
        t, w = t + 2.0 * w / g, e * w
        over = bounces.add(t, w, g)
    four = bounces.four(7)
    assert four == Four(0.2, pytest.approx(0.1), amplitude, pytest.approx(0.4, rel=1e-12), 7)
