"""Closures, mobility and redundancy in the touch configuration."""

import numpy as np
import pinocchio as pin

from nipper_pin import Mechanism, load
from nipper_pin.mechanism import joint_placements
from nipper_pin.mechanism.build.closing import closure_gaps
from nipper_pin.mechanism.build.touch_checks import closure_jacobian, dependent_rows
from nipper_pin.mechanism.files import parse_xml
from nipper_pin.mechanism.files.urdf import check_urdf


def gaps_at(mechanism: Mechanism, q: np.ndarray) -> np.ndarray:
    """Closure gaps at any configuration, through Pinocchio's own kinematics."""
    model, data = mechanism.model, mechanism.model.createData()
    pin.framesForwardKinematics(model, data, q)

    def place(frame: str) -> np.ndarray:
        return data.oMf[model.getFrameId(frame, pin.FrameType.BODY)].translation[[0, 2]].copy()

    return np.concatenate(
        [place(item.frame_b) - place(item.frame_a) for item in mechanism.closures]
    )


def test_closures_meet_to_round_off() -> None:
    mechanism = load()
    gaps = closure_gaps(mechanism.closures, mechanism.model, joint_placements(mechanism.model))
    assert gaps.shape == (2, 2)
    assert np.abs(gaps).max() < 1e-15


def test_jacobian_agrees_with_differences(tmp_path) -> None:  # type: ignore[no-untyped-def]
    mechanism = load()
    urdf = check_urdf(parse_xml(mechanism.urdf, "urdf"), "urdf", tmp_path)
    jacobian = closure_jacobian(
        mechanism.closures,
        mechanism.joints,
        urdf,
        mechanism.model,
        joint_placements(mechanism.model),
    )
    step = 1e-5
    for column in range(7):
        shift = step * np.eye(7)[column]
        difference = (gaps_at(mechanism, shift) - gaps_at(mechanism, -shift)) / (2.0 * step)
        np.testing.assert_allclose(jacobian[:, column], difference, rtol=0.0, atol=1e-9)


def test_dependent_rows() -> None:
    rows = np.array([[1.0, 0.0, 0.0], [0.0, 1e-6, 0.0], [2.0, 0.0, 0.0]])
    assert dependent_rows(rows, ["a", "b", "c"]) == ["a", "c"]
    assert dependent_rows(rows[:2], ["a", "b"]) == []
    assert dependent_rows(np.zeros((0, 3)), []) == []
    assert dependent_rows(np.zeros((1, 3)), ["zero"]) == ["zero"]
