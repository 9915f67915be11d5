"""Derivative of impulses that pass from contact to contact, which carries stated errors on."""

from __future__ import annotations

import numpy as np
import pytest
from rows_of_balls import row

from nipper_pin.dynamics import ShaftMotion, System
from nipper_pin.hybrid.error_estimate.sequence_map import sequence_map


@pytest.mark.parametrize(("e", "f"), [(1.0, 1.0), (0.9, 0.8)])
def test_the_map_of_a_cannon_is_the_product_of_its_two_strikes(e: float, f: float) -> None:
    """Floor, then pair: both are linear in the rates of the gaps, and nothing depends on places.

    With 3 kg below 1 kg the floor changes the rates (w, r) to (-e w, r + (1 + e) w), the pair then
    to (-e w + (1 + f) r' / 4, -f r'). Impulses: 3 (1 + e) w of the lower ball and what it gets
    from the pair, whose reduced mass is 3/4 kg. Differences of linear functions are exact but for
    round-off by a step of 1e-6.
    """
    mechanism = row([3.0, 1.0], [e, f], wall=True, law="sequential")
    system = System(mechanism, ShaftMotion(mechanism, 1.0, 0.0))
    contacts = list(mechanism.stops)
    matrix, pushes = sequence_map(
        system, np.zeros(2), np.array([-1.0, 0.0]), contacts, contacts
    )  # fmt: skip
    floor = np.array([[-e, 0.0], [1.0 + e, 1.0]])
    pair = np.array([[1.0, (1.0 + f) / 4.0], [0.0, -f]])
    wanted = np.eye(4)
    wanted[2:, 2:] = pair @ floor
    assert matrix == pytest.approx(wanted, abs=1e-9)
    impulses = np.array([[-3.0 * (1.0 + e), 0.0], -(1.0 + f) * 0.75 * floor[1]])
    assert pushes[:, :2] == pytest.approx(np.zeros((2, 2)), abs=1e-9)
    assert pushes[:, 2:] == pytest.approx(impulses, abs=1e-9)
