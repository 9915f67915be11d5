"""Panels of a machine without force elements are not checked between their nodes.

What each check is for is tested in `tests/regression` (turns of dampers, forces between nodes), in
`test_laws_that_make_energy.py`, and for ends of tables in `test_springs_in_other_forms.py`.
"""

from __future__ import annotations

import pytest

from nipper_pin import Resolution, load
from nipper_pin.dynamics import ShaftMotion, System
from nipper_pin.hybrid.motion.panel_checks import panel_checks


@pytest.mark.parametrize("model", ["e62", "hanging_pendulum", "e62_offset_guide"])
def test_a_nipper_needs_none(model: str) -> None:
    """Linear springs on joints: the nodes show all that their forces do."""
    mechanism = load(model)
    system = System(mechanism, ShaftMotion(mechanism, 50.0, 0.0))
    assert panel_checks(system, Resolution()) == ()
