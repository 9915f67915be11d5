"""Found in URDF files as programs write them: joints that are parallel but for round-off.

Half a turn about y may be written as pi, p, pi, or as angles of five digits. With joints 1e-12 rad
apart every evaluation took 200 iterations and times were wrong by 2e-12; with 1e-8 rad, which was
read without a word, the jaw did not bounce: the pins pulled across the plane.
"""

from __future__ import annotations

import math
import re
import shutil
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from small_machines import hinge, link, machine, slide

from benchmarks.stress.checks.agreement import bits
from nipper_pin import Case, load, simulate
from nipper_pin.mechanism import find_model

CASE = Case(speed_rpm=650.0)


@pytest.mark.parametrize("tilt", ["1e-16", "1e-12", "1e-8", "2e-5"])
def test_joints_that_are_nearly_parallel_are_taken_to_be(tmp_path: Path, tilt: str) -> None:
    """Every joint of the E62 leans by as much: the run is the same to the last bit.

    At 2e-5 rad the lips of the jaw stood 1.7 um apart, which is refused, before.
    """
    folder = tmp_path / "e62"
    shutil.copytree(find_model("e62"), folder)
    urdf = folder / "e62.urdf"
    text = urdf.read_text()
    for joint in re.findall(r"<joint.*?</joint>", text, re.DOTALL):
        text = text.replace(joint, re.sub(r'rpy="0 (\S+) 0"', rf'rpy="{tilt} \1 0"', joint))
    assert text.count(tilt) > 10
    urdf.write_text(text)
    assert bits(simulate(load(folder), CASE)) == bits(simulate(load("e62"), CASE))


def test_half_a_turn_in_three_angles() -> None:
    """A turn by pi - p about y is pi, p, pi as well; sin pi is 1.2e-16, and not zero.

    A pendulum that hangs from the turned frame swings as the plain one does.
    """
    lean = 0.3
    ends = []
    for rpy in (f"0 {math.pi - lean!r} 0", f"{math.pi!r} {lean!r} {math.pi!r}"):
        turned = hinge("turn", "frame", "bob").replace("<origin ", f'<origin rpy="{rpy}" ')
        pendulum = machine([link("bob", 1.0, 0.01, (0.2, 0.0)), turned], 1, gravity=9.81)
        (placement,) = list(pendulum.model.jointPlacements)[1:]
        assert placement.rotation[1].tolist() == [0.0, 1.0, 0.0]
        ends.append(
            simulate(
                pendulum,
                Case(speed_rpm=60.0, window="cycle", start_index=0.0),  # type: ignore[arg-type]
            ).trajectory.evaluate(0.7)
        )
    assert abs(ends[0].q[0, 0]) > 0.1
    assert ends[1].q[0, 0] == pytest.approx(ends[0].q[0, 0], rel=1e-12)


def test_axes_are_put_into_the_plane() -> None:
    """A slide that leaves the plane by 1e-10 of its length slides in the plane."""
    sled = slide("x", "frame", "sled", axis=(0.6, 0.8)).replace("0.6 0 0.8", "0.6 1e-10 0.8")
    assert "1e-10" in sled
    cart = machine([link("sled"), sled], 1, gravity=9.81)
    data = cart.model.createData()
    pin.computeJointJacobians(cart.model, data, np.zeros(1))
    x, y, z = data.J.reshape(6, 1)[:3, 0]
    assert (x, z) == pytest.approx((0.6, 0.8), abs=1e-15)
    assert y == 0.0
