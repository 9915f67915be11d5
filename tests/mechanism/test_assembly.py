"""Closures, mobility and redundancy in the touch configuration."""

import numpy as np
import pinocchio as pin
import pytest

from nipper_pin.errors import AssemblyError, ModelError
from nipper_pin.mechanism import Mechanism, load
from nipper_pin.mechanism.build.closing import closure_gaps
from nipper_pin.mechanism.build.placements import joint_placements
from nipper_pin.mechanism.build.touch_checks import closure_jacobian, dependent_rows
from nipper_pin.mechanism.files.urdf import check_urdf, parse_xml

CLOSURE = '[closures.eccentric_pin]\nframe_a = "rod_head"\nframe_b = "eccentric_pin"\n'


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
        np.testing.assert_allclose(jacobian[:, column], difference, atol=1e-9)


def test_gap_is_named_in_millimetres(spoil) -> None:  # type: ignore[no-untyped-def]
    folder = spoil(urdf=(("-0.00498782025129913 0 0.00034", "-0.00798782025129913 0 0.00434"),))
    with pytest.raises(AssemblyError) as caught:
        load(folder)
    evidence = caught.value.evidence
    assert evidence["file"] == "e62.toml"
    assert evidence["key"] == "closures.eccentric_pin"
    assert evidence["value"] == ("a gap of 5 mm (x -3, z 4) from rod_head to eccentric_pin")
    assert "within 1e-06 mm" in evidence["allowed"]


def test_missing_closure(spoil) -> None:  # type: ignore[no-untyped-def]
    with pytest.raises(ModelError) as caught:
        load(spoil(toml=((CLOSURE, ""),)))
    assert caught.value.evidence["key"] == "degrees_of_freedom"
    assert caught.value.evidence["value"] == 3
    assert caught.value.evidence["allowed"].startswith("the model has 5: 7 tree joints less two")
    assert "rocker_axis" in caught.value.evidence["allowed"]


def test_wrong_degrees_of_freedom() -> None:
    with pytest.raises(ModelError, match=r"degrees_of_freedom = 2 .* the model has 3"):
        load(overrides={"degrees_of_freedom": 2})


def test_redundant_rows_are_named(spoil) -> None:  # type: ignore[no-untyped-def]
    twice = CLOSURE + CLOSURE.replace("closures.eccentric_pin", "closures.again")
    with pytest.raises(AssemblyError) as caught:
        load(spoil(toml=((CLOSURE, twice),)))
    assert caught.value.evidence["key"] == "closures"
    assert caught.value.evidence["value"] == [
        "eccentric_pin x",
        "eccentric_pin z",
        "again x",
        "again z",
    ]


def test_closure_within_one_link(spoil) -> None:  # type: ignore[no-untyped-def]
    """Both frames on the same body: a pin that restrains nothing."""
    folder = spoil(toml=(('frame_b = "cylinder_axis"', 'frame_b = "rocker_foot"'),))
    with pytest.raises(AssemblyError) as caught:
        load(folder)
    assert caught.value.evidence["value"] == ["rocker_axis x", "rocker_axis z"]


def test_drives_that_contradict_the_closures(spoil) -> None:  # type: ignore[no-untyped-def]
    folder = spoil(toml=(('joint = "tension_shaft"', 'joint = "nipper_pivot"'),))
    with pytest.raises(ModelError, match="independently of one another") as caught:
        load(folder)
    assert "drive tension" in caught.value.evidence["value"]
    assert "drive pendulum" in caught.value.evidence["value"]
    assert "rocker_axis x" in caught.value.evidence["value"]
    assert "eccentric_pin x" not in caught.value.evidence["value"]


def test_stops_that_contradict_the_drives(spoil) -> None:  # type: ignore[no-untyped-def]
    folder = spoil(toml=(('closed = ["jaw"]', 'closed = ["jaw", "steeve"]'),))
    with pytest.raises(ModelError, match="contradict one another") as caught:
        load(folder)
    assert caught.value.evidence["key"] == "phases[1].closed"
    assert "stop jaw" in caught.value.evidence["allowed"]


def test_dependent_rows() -> None:
    rows = np.array([[1.0, 0.0, 0.0], [0.0, 1e-6, 0.0], [2.0, 0.0, 0.0]])
    assert dependent_rows(rows, ["a", "b", "c"]) == ["a", "c"]
    assert dependent_rows(rows[:2], ["a", "b"]) == []
    assert dependent_rows(np.zeros((0, 3)), []) == []
    assert dependent_rows(np.zeros((1, 3)), ["zero"]) == ["zero"]
