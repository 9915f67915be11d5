"""Links that a closed stop holds still through the closures, in every kind of motion."""

from __future__ import annotations

import numpy as np
import pytest
from judged_runs import both, compare

from nipper_pin import Case, DriveMode, Mechanism, Outcome, Window, export, load, simulate
from nipper_pin.mechanism.skeleton import write_skeleton

ARM = 0.1
POINTER = f"""
  <link name="pointer">
    <inertial><origin xyz="0.05 0 0"/><mass value="0.1"/>
      <inertia ixx="1e-4" ixy="0" ixz="0" iyy="1e-4" iyz="0" izz="1e-4"/></inertial>
  </link>
  <joint name="pointer" type="continuous">
    <parent link="frame"/><child link="pointer"/>
    <origin xyz="-{ARM} 0 -0.132"/><axis xyz="0 -1 0"/>
  </joint>
</robot>"""
YOKE = """
[closures.yoke]
frame_a = "pointer"
frame_b = "ram_B"
slot_axis = "x"
block_mass_kg = 0.01
"""


@pytest.fixture(scope="module")
def press(tmp_path_factory: pytest.TempPathFactory) -> Mechanism:
    """The press with a pointer whose slot follows the ram; on the anvil ram and pointer stand."""
    home = tmp_path_factory.mktemp("locked")
    folder = export(load(write_skeleton(home / "drawn")), home / "press")
    urdf, toml = folder / "press.urdf", folder / "press.toml"
    urdf.write_text(urdf.read_text().replace("</robot>", POINTER))
    toml.write_text(toml.read_text() + YOKE)
    return load(folder)


@pytest.mark.sampled(2)
@pytest.mark.parametrize("speed", [30.0, 120.0, 480.0])
@pytest.mark.parametrize("drive", DriveMode)
def test_the_pointer_follows_the_ram(press: Mechanism, drive: DriveMode, speed: float) -> None:
    """Pointer and slide stand as the triangle of pivot, ram and arm says, in all phases.

    With the ram at height h over the anvil, tan(pointer) = h / arm and the slide has moved by
    sqrt(arm^2 + h^2) - arm; the bound is the round-off of the closures. Energy is balanced to the
    tolerance of the motion, so the pointer's inertia acts in collisions and flights.
    """
    solution = simulate(press, Case(speed_rpm=speed, window=Window.CYCLE, drive=drive))
    assert solution.outcome is Outcome.COMPLETED
    assert {"anvil"} in [set(part.closed) for part in solution.segments]
    state = solution.trajectory.evaluate(np.linspace(*solution.trajectory.span, 500))
    columns = {joint.name: joint.index for joint in press.joints}
    height, pointer = state.q[:, columns["height"]], state.q[:, columns["pointer"]]
    np.testing.assert_allclose(np.tan(pointer), height / ARM, rtol=0.0, atol=1e-13)
    slid = state.q[:, columns["yoke"]]
    np.testing.assert_allclose(np.abs(slid), np.hypot(ARM, height) - ARM, rtol=0.0, atol=1e-14)
    rates = state.v[:, columns["pointer"]] * (1.0 + (height / ARM) ** 2) * ARM
    scale = np.abs(state.v[:, columns["height"]]).max()
    np.testing.assert_allclose(rates, state.v[:, columns["height"]], rtol=0.0, atol=1e-12 * scale)
    assert solution.checks.energy_balance < 1e-10
    assert all(item.time < 1e-9 for item in solution.errors if np.isfinite(item.time))


def test_the_planar_solver_agrees(press: Mechanism) -> None:
    report = compare(both(press), 120.0)
    assert (report.verdict, report.events >= 10) == ("agree", True), report.line()
