"""Loading by name, by folder and from plain data; overrides."""

import json
import math
import os
from pathlib import Path

import numpy as np
import pytest

from nipper_pin import Mechanism, UnknownNameError, load
from nipper_pin.mechanism import find_model, from_sources


def same(one: Mechanism, other: Mechanism) -> None:
    for name in ("joints", "closures", "drives", "springs", "phases", "cylinder", "description",
                 "urdf", "model"):  # fmt: skip
        assert getattr(one, name) == getattr(other, name)
    for first, second in zip(one.stops, other.stops, strict=True):
        for name in ("name", "index", "restitution", "lever"):
            assert getattr(first, name) == getattr(second, name)


def test_the_machine(e62: Mechanism) -> None:
    assert (e62.name, e62.model.name, e62.degrees_of_freedom) == ("e62", "e62", 3)
    assert [(joint.name, joint.index) for joint in e62.joints] == [
        ("pendulum_shaft", 0), ("nipper_pivot", 1), ("jaw", 2), ("rod_pin", 3), ("steeve", 4),
        ("rocker_pin", 5), ("tension_shaft", 6),
    ]  # fmt: skip
    assert e62.joints[e62.stop("steeve").index].kind == "prismatic"
    assert e62.springs[0].stiffness == 9000.0
    assert e62.springs[0].preload == pytest.approx(0.011)
    assert [drive.name for drive in e62.drives] == ["pendulum", "tension"]
    np.testing.assert_array_equal(e62.model.gravity.linear, [0.0, 0.0, -9.81])
    assert e62.phase_of(frozenset({"jaw"})) is e62.phase(2)


def test_index_scale() -> None:
    mechanism = load()
    cylinder = mechanism.cylinder
    assert cylinder.sense == -1
    assert cylinder.index_from_angle(cylinder.angle_at_touch_rad) == pytest.approx(34.05, abs=0.01)
    assert cylinder.index_from_angle(cylinder.reference_angle_rad) == pytest.approx(24.0)
    # Foremost at 24: there the pendulum shaft is furthest clockwise.
    angles = np.linspace(0.0, math.tau, 4001)
    lowest = angles[np.argmin(mechanism.drives[0].law.evaluate(angles)[0])]
    assert cylinder.index_from_angle(float(lowest)) == pytest.approx(24.0, abs=0.01)
    touch = np.array([cylinder.angle_at_touch_rad])
    for drive in mechanism.drives:
        assert drive.law.evaluate(touch)[0][0] - drive.law_at_touch == 0.0


def test_works_from_any_directory(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    same(load("e62"), load(find_model("e62")))
    assert os.listdir(tmp_path) == []


def test_rebuilt_from_plain_data() -> None:
    mechanism = load(overrides={"links.rocker.mass_kg": 0.7, "stops.jaw.restitution": 0.1})
    plain = json.loads(json.dumps(mechanism.description))
    again = from_sources(mechanism.name, mechanism.urdf, plain, mechanism.mesh_folder)
    same(mechanism, again)
    assert again.stop("jaw").restitution == 0.1


def test_overrides_of_the_document() -> None:
    """Texts of a command, lists, and what numpy made; the description holds plain Python."""
    mechanism = load(
        overrides={
            "stops.jaw.restitution": np.float64(0.05),
            "springs.steeve.stiffness_N_per_m": np.int64(11000),
            "drives.pendulum.crank_axis_mm[0]": "0.5",
            "drives.pendulum.guide_axis_mm": "[-190, -20.0]",
            "title": "another",
            "initial_phase": "2",
        }
    )
    assert mechanism.stop("jaw").restitution == 0.05
    assert mechanism.springs[0].stiffness == 11000.0
    assert (mechanism.title, mechanism.initial_phase) == ("another", 2)
    drive = mechanism.description["drives"]["pendulum"]  # type: ignore[index]
    assert drive["crank_axis_mm"] == [0.5, 0.0]
    assert drive["guide_axis_mm"] == [-190, -20.0]
    assert type(mechanism.description["stops"]["jaw"]["restitution"]) is float  # type: ignore[index]
    assert load().stop("jaw").restitution == 0.2


def test_shortcuts_lead_somewhere() -> None:
    mechanism = load()
    assert set(mechanism.shortcuts) == {"restitution", "stiffness", "preload"}
    for path in mechanism.shortcuts.values():
        load(overrides={path: "0.5"})


def test_overrides_of_a_link() -> None:
    mechanism = load(
        overrides={"links.top_nipper.mass_kg": "1.5", "links.top_nipper.inertia_kg_m2": 0.002}
    )
    joint = mechanism.model.getJointId("jaw")
    original = load().model.inertias[joint]
    assert mechanism.model.inertias[joint].mass == 1.5
    assert mechanism.model.inertias[joint].inertia[1, 1] == 0.002
    np.testing.assert_array_equal(mechanism.model.inertias[joint].lever, original.lever)
    assert "never the\n  maker's data" in mechanism.urdf


def test_names_that_a_mechanism_has_not(e62: Mechanism) -> None:
    for item in e62.stops:
        assert e62.stop(item.name) is item
    with pytest.raises(UnknownNameError, match="jam") as caught:
        e62.stop("jam")
    assert all(item.name in caught.value.message for item in e62.stops)
    for phase in e62.phases:
        assert e62.phase(phase.number) is phase
        assert e62.phase_of(phase.closed) is phase
    assert e62.phase_of(frozenset({"nothing"})) is None
    with pytest.raises(UnknownNameError) as caught:
        e62.phase(99)
    assert "99" in caught.value.message
    assert all(str(phase.number) in caught.value.message for phase in e62.phases)
    assert e62.links == tuple(joint.child for joint in e62.joints)
