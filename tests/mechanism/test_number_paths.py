"""Numbers by their paths: types that they take, places in lists, and what is named twice."""

from __future__ import annotations

from typing import Any

import numpy as np
import pinocchio as pin
import pytest

from nipper_pin import ModelError, UnknownNameError
from nipper_pin.mechanism.edit import number_at
from nipper_pin.mechanism.edit.overrides import by_path
from nipper_pin.mechanism.edit.toml_paths import number_from, replace_value
from nipper_pin.mechanism.files import rotation_from_rpy
from nipper_pin.mechanism.files.urdf_values import placed


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        (7, "8", 8), (7, "8.5", 8.5), (7.0, "8", 8.0), (7, np.int64(3), 3),
        (7, np.float32(0.5), 0.5),
        ("a", "8", "8"), (True, "false", False), (True, False, False), ([1, 2], "[3, 4]", [3, 4]),
        ([1, 2], (3, 4), [3, 4]), (7, "x", None), ([1], "[", None), (7.0, True, True),
    ],
)  # fmt: skip
def test_values_take_the_type_of_what_they_replace(old: Any, new: Any, expected: Any) -> None:
    document: dict[str, object] = {"a": {"b": [old]}}
    if expected is None:
        with pytest.raises(ModelError) as caught:
            replace_value(document, "a.b[0]", new, "f")
        evidence = caught.value.evidence
        assert (evidence["file"], evidence["key"], evidence["value"]) == ("f", "a.b[0]", new)
        return
    replace_value(document, "a.b[0]", new, "f")
    (found,) = document["a"]["b"]  # type: ignore[index]
    assert found == expected
    assert type(found) is type(expected)


def test_numbers_by_path() -> None:
    """Places are written in one way; a truth value, a text and a table are no numbers."""
    document = {"a": {"b": [3, 4.5, True]}, "t": "x", "e": [],
                "drives": {"d": {"law": "cam", "joint": "j"}}}  # fmt: skip
    assert number_at(document, "a.b[1]", "f") == 4.5
    assert isinstance(number_at(document, "a.b[0]", "f"), float)
    assert number_at(document, "drives.d.dwell_deg", "f") == 0.0
    for path in ("a.b[2]", "t", "a.b", "a"):
        with pytest.raises(ModelError, match="the path of one number"):
            number_at(document, path, "f")
    for path, known in (("a.b[3]", r"\[0\] to \[2\]"), ("a.b[01]", r"\[0\] to \[2\]"),
                        ("e[0]", "none"), ("a.c", "b"), ("t.x", "none")):  # fmt: skip
        with pytest.raises(UnknownNameError, match=f"known: {known}"):
            number_at(document, path, "f")
    assert number_from("1e3", "p", "f") == number_from(1000, "p", "f") == 1000.0
    for value in (True, None, [1.0], "much"):
        with pytest.raises(ModelError) as caught:
            number_from(value, "p", "f")
        assert (caught.value.evidence["key"], caught.value.evidence["value"]) == ("p", value)


def test_shortcuts_and_paths_name_a_number_once() -> None:
    data = {"shortcuts": {"k": "springs.s.k"}, "gravity_m_s2": 1.0}
    assert by_path({"k": 3, "gravity_m_s2": 2}, data, "f") == {"springs.s.k": 3, "gravity_m_s2": 2}
    with pytest.raises(ModelError) as caught:
        by_path({"k": 3, "springs.s.k": 4}, data, "f")
    assert caught.value.evidence["key"] == "springs.s.k"
    assert "k = 3 gives the same one" in caught.value.evidence["allowed"]
    with pytest.raises(UnknownNameError, match="'q'; known: gravity_m_s2, k, links, points"):
        by_path({"q": 3}, data, "f")


def test_rotations() -> None:
    """Any three angles by Pinocchio, as a matrix and as a placement."""
    for angles in np.random.default_rng(5).uniform(-3.0, 3.0, (20, 3)):
        np.testing.assert_allclose(
            rotation_from_rpy(angles), pin.rpy.rpyToMatrix(*angles), rtol=0.0, atol=1e-14
        )
        np.testing.assert_allclose(
            placed(np.ones(3), angles).rotation, pin.rpy.rpyToMatrix(*angles), rtol=0.0, atol=1e-14
        )
