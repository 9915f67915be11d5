"""A follower just above the speed at which it jumps: a flight of next to no height.

"the motion cannot be resolved: the step falls to 6.7e-14 s", at most speeds up to 5e-7 above the
jump: a spring between two points asked more of accelerations than round-off leaves of them. And
where round-off had the last word on the acceleration at the release the flight was left out.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from driven_machines import GRAVITY, LAWS, Law, follower
from scipy.optimize import minimize_scalar

import nipper_pin as nip
from nipper_pin.arrays import FloatArray

MASS, STIFFNESS, PRELOAD, ECCENTRICITY = 0.8, 900.0, 0.012, 0.018
ECCENTRIC: Law = {"law": "fourier", "mean": 0.5, "cosine": [-0.5], "sine": [0.0]}
NEAR = np.geomspace(1e-12, 1e-5, 40)
# The fault was there at most of these.
FEW_OR_ALL = [NEAR[::6], pytest.param(NEAR, marks=pytest.mark.campaign)]


def _turn(mechanism: nip.Mechanism, rpm: float) -> nip.Solution:
    solution = nip.simulate(mechanism, nip.Case(speed_rpm=rpm, window=nip.Window.CYCLE))
    assert solution.outcome is nip.Outcome.COMPLETED
    return solution


def _flight(mechanism: nip.Mechanism, rpm: float) -> float:
    """Time from the first release to the landing [s]; the bounces after it end in a rest."""
    released, landed, *others = _turn(mechanism, rpm).events
    assert released.kind is nip.EventKind.RELEASE
    assert landed.kind is nip.EventKind.COLLISION
    assert others[-1].kind is nip.EventKind.REST
    return landed.t - released.t


@pytest.mark.parametrize("nears", FEW_OR_ALL, ids=["few", "all"])
@pytest.mark.parametrize("sprung", [True, False])
def test_a_follower_leaves_an_eccentric_for_as_long_as_its_force_tells(
    sprung: bool, nears: FloatArray
) -> None:
    """At w (1 + d) the force is m (c s^2 / 2 - 2 e w^2 d) about the top, c = e w^2 (w^2 - k/m).

    It is below zero up to a time T = sqrt(4 e w^2 d / c); what leaves at -T, lands at 3 T.
    """
    k = STIFFNESS if sprung else 0.0
    weight = MASS * GRAVITY + k * (PRELOAD + 2.0 * ECCENTRICITY)
    omega = math.sqrt(weight / (MASS * ECCENTRICITY))
    mechanism = follower(ECCENTRIC, sprung=sprung)
    for near in nears:
        below = (1.0 - near) * omega * 60.0 / math.tau
        assert not _turn(mechanism, below).events
        flight = _flight(mechanism, (1.0 + near) * omega * 60.0 / math.tau)
        expected = 8.0 * math.sqrt(near / (omega**2 - k / MASS))
        # The next term is of the order of the angle turned; round-off of a force of 64 m/s2 times
        # the mass is 1e-14 of it, beside the part d that is missing.
        allowed = omega * expected + 1e-14 / near
        assert flight == pytest.approx(expected, rel=allowed), near


def _jump_rpm(mechanism: nip.Mechanism, k: float) -> float:
    """Speed at which the least force of the cam is zero [r/min]."""
    law = mechanism.drives[0].law

    def square(psi: FloatArray | float) -> FloatArray:
        lift, _, bend = law.evaluate(np.asarray(psi))
        force = GRAVITY + k / MASS * (PRELOAD + lift)
        return np.divide(-force, bend, out=np.full_like(bend, math.inf), where=bend < 0.0)

    grid = np.linspace(0.0, math.tau, 20_001)
    place = grid[int(np.argmin(square(grid)))]
    bounds = place - 4e-4, place + 4e-4
    found = minimize_scalar(square, bounds=bounds, method="bounded", options={"xatol": 1e-14})
    # The least may lie where two pieces meet.
    least = min(float(found.fun), *square(np.array(law.knots_rad)))
    return math.sqrt(least) * 60.0 / math.tau


@pytest.mark.sampled(3)
@pytest.mark.parametrize("nears", FEW_OR_ALL, ids=["few", "all"])
@pytest.mark.parametrize("sprung", [True, False])
@pytest.mark.parametrize(
    "law", ["cycloidal, dwells", "modified_sine, dwells", "polynomial_4567, late", "12 rows"]
)
def test_flights_grow_with_the_root_of_what_the_force_lacks(
    law: str, sprung: bool, nears: FloatArray
) -> None:
    """Without a spring a modified sine has its least force where two of its pieces meet."""
    mechanism = follower(LAWS[law], sprung=sprung)
    rpm = _jump_rpm(mechanism, STIFFNESS if sprung else 0.0)
    for near in nears:
        assert not _turn(mechanism, rpm * (1.0 - near)).events
    flights = np.array([_flight(mechanism, rpm * (1.0 + near)) for near in nears])
    # The speed of the jump is known to some 1e-14, of which the least distance is 1e-12.
    np.testing.assert_allclose(
        flights / np.sqrt(nears), flights[-1] / math.sqrt(nears[-1]), rtol=0.02
    )
