"""Order of convergence of event times and impulses, measured across several impacts.

With N Chebyshev-Lobatto nodes on panels of equal length h, the accelerations are interpolated with
an error of the order h^N, whose factor is the node polynomial omega(s) = prod (s - s_i).

At the end of a panel the velocity is wrong by the integral of omega. For even N that integral is
not zero: h^(N+1) a panel. For odd N the node polynomial is odd about the middle of the panel and
its integral vanishes (as for Simpson's rule, N = 3): h^(N+2). The position is wrong by h^(N+2)
either way; errors of inner nodes reach the accelerations as h^(N+1) and the velocity as h^(N+2).
Adding up 1/h panels gives the global order

    N for even N,  N + 1 for odd N.

An event falls inside its last panel, where nothing vanishes: the dense velocity there is wrong by
h^(N+1) and the position by h^(N+2), but once an event, not once a panel. For even N that is of
higher order than the rest; for odd N it is of the same order, N + 1, through the rate at impact.
It does not spoil the order, but its factor depends on where in its panel the event falls. Many
panel lengths are therefore taken together, so that events fall everywhere.

Measured on the E62 transition at 650 r/min with e = 0.5, whose first two flights are the longest,
at the third collision, after two flights and two impacts, against the certified reference. The
error is the root mean square of the relative errors of its time and impulse over a band of panel
lengths. A slope within 0.3 tells the orders 3, 4, 5, 6 apart, and no constant error can imitate it:
the error falls by a factor of 50 at least, two decades for most. The range ends above 1e-13, where
the closing of the loops (to 4e-15 m, 1e-13 of the jaw's amplitude) takes over.
"""

from __future__ import annotations

import itertools
import json
from pathlib import Path

import numpy as np
import pytest

from nipper_pin import Case, EventKind, Mechanism, Resolution, load, simulate

REFERENCE = Path(__file__).parents[1] / "reference" / "e62_transition.json"
COLLISION = 3
BANDS = 5


@pytest.fixture(scope="module")
def mechanism() -> Mechanism:
    """The E62 with the longer flights of e = 0.5."""
    return load("e62", {"stops.jaw.restitution": 0.5})


@pytest.fixture(scope="module")
def reference() -> tuple[float, float]:
    """Time [s] and impulse [N m s] of the collision."""
    cases = json.loads(REFERENCE.read_text(encoding="utf-8"))["cases"]
    row = cases["650_e0.5"]["collisions"][COLLISION - 1]
    return float(row["time_s"]), float(row["impulse"])


def _errors(
    mechanism: Mechanism, reference: tuple[float, float], nodes: int, panels: int
) -> tuple[float, float]:
    """Relative errors of time and impulse with equal panels."""
    resolution = Resolution(adaptive=False, flight_nodes=nodes, panels_per_turn=panels)
    case = Case(speed_rpm=650.0, resolution=resolution, max_collisions=COLLISION)
    events = simulate(mechanism, case).events
    event = [item for item in events if item.kind is EventKind.COLLISION][COLLISION - 1]
    return event.t / reference[0] - 1.0, event.P_N["jaw"] / reference[1] - 1.0


# An odd number and an even one are quick.
@pytest.mark.sampled(2)
@pytest.mark.parametrize(
    ("nodes", "order", "fewest", "most", "lengths"),
    [(3, 4, 200, 1200, 8), (4, 4, 300, 1400, 8), (6, 6, 60, 150, 16), (5, 6, 60, 200, 16)],
)
def test_global_order(
    mechanism: Mechanism,
    reference: tuple[float, float],
    nodes: int,
    order: int,
    fewest: int,
    most: int,
    lengths: int,
) -> None:
    """The error of the third collision falls with the panel length to the power N or N + 1."""
    edges = np.geomspace(fewest, most, BANDS + 1)
    panels, errors = [], []
    for begin, end in itertools.pairwise(edges):
        band = np.unique(np.linspace(begin, end, lengths, endpoint=False).astype(int))
        found = [_errors(mechanism, reference, nodes, int(count)) for count in band]
        panels.append(np.log(band).mean())
        errors.append(np.sqrt(np.mean(np.square(found))))
    assert errors[-1] > 1e-13
    assert errors[0] > 50.0 * errors[-1]
    slope = -np.polyfit(panels, np.log(errors), 1)[0]
    assert slope == pytest.approx(order, abs=0.3)


def test_adaptive_panels_meet_the_tolerance_asked_for(
    mechanism: Mechanism, reference: tuple[float, float]
) -> None:
    """With adaptive panels the error follows the tolerance down to 1e-12.

    Two flights and impacts amplify the error of a panel a little: a factor of ten is allowed. That
    the loosest run is far less exact than the tightest shows that the tolerance does act.
    """
    errors = {}
    for tolerance in (1e-4, 1e-6, 1e-8, 1e-10, 1e-12):
        case = Case(speed_rpm=650.0, resolution=Resolution(tolerance=tolerance, flight_nodes=6))
        collision = simulate(mechanism, case).collisions[COLLISION - 1]
        errors[tolerance] = max(
            abs(collision.t / reference[0] - 1.0),
            abs(collision.event.P_N["jaw"] / reference[1] - 1.0),
        )
        assert errors[tolerance] <= 10.0 * tolerance
    assert errors[1e-4] > 1e3 * errors[1e-12]
