"""The contact of the lips against its construction."""

import math
from pathlib import Path

import numpy as np
import pytest
from small_machines import hinge, link, machine

from nipper_pin.errors import ModelError
from nipper_pin.mechanism import collision_model, load
from tests.refusals.bases import model

POINT = np.array([9.2e-3, 0.0, 65.5e-3])
PIVOT = np.array([-72.6e-3, 0.0, 101.9e-3])


def test_contact_is_where_it_was_built() -> None:
    contact = load().stop("jaw").contact
    assert contact is not None
    arm = POINT - PIVOT
    lever = float(np.linalg.norm(arm))
    np.testing.assert_allclose(contact.point, POINT, rtol=0.0, atol=1e-10)
    np.testing.assert_allclose(
        contact.normal, np.array([-arm[2], 0.0, arm[0]]) / lever, rtol=0.0, atol=1e-12
    )
    assert contact.lever_m == pytest.approx(lever, rel=1e-12)
    assert abs(contact.closing_coordinate) < 1e-11


def test_stop_along_its_joint_has_no_contact() -> None:
    stop = load().stop("steeve")
    assert stop.contact is None
    assert stop.lever == 1.0
    assert load().stop("jaw").lever == pytest.approx(0.0895332340530599, rel=1e-12)


@pytest.mark.parametrize("lift_mm", [0.01, -0.01, 0.3])
def test_lips_that_do_not_touch(tmp_path: Path, lift_mm: float) -> None:
    place, height = "0.082409829417841 0 ", -0.03502955916540127
    edits = f"{place}{height!r}", f"{place}{height + 1e-3 * lift_mm!r}"
    folder = model("e62", edits, tmp_path)
    with pytest.raises(ModelError) as caught:
        load(folder)
    evidence = caught.value.evidence
    assert evidence["file"] == "e62.toml"
    assert evidence["key"] == "stops.jaw.contact"
    gap_mm = lift_mm * math.cos(math.radians(23.9885))
    pair, _, apart = evidence["value"].rpartition(", ")
    assert pair == "bottom_lip and top_lip"
    assert float(apart.partition(" mm apart")[0]) == pytest.approx(gap_mm, rel=1e-4)
    closing = float(evidence["allowed"].rpartition("jaw = ")[2].removesuffix(" deg"))
    # The lever is the rate of the gap; a lift of a third of a millimetre bends it little.
    assert math.radians(closing) * 89.53 == pytest.approx(-gap_mm, rel=1e-2)


def test_contact_of_a_general_shape_is_close(tmp_path: Path) -> None:
    """A lip whose section is found by the general search, here a sphere of the same radius."""
    lip = '<cylinder radius="0.0015" length="0.19"/>'
    folder = model("e62", (lip, '<sphere radius="0.0015"/>'), tmp_path)
    contact = load(folder).stop("jaw").contact
    assert contact is not None
    np.testing.assert_allclose(contact.point, POINT, rtol=0.0, atol=1e-7)


def test_shapes_carry_their_names_and_links() -> None:
    mechanism = load()
    geometry, shapes = collision_model(mechanism)
    assert {item.name for item in geometry.geometryObjects} == {
        name for names in shapes.values() for name in names
    }
    assert shapes["frame"][0] == "cylinder_drum"
    assert shapes["rod_head"] == ()
    joint = geometry.geometryObjects[geometry.getGeometryId("top_lip")].parentJoint
    assert mechanism.model.names[joint] == "jaw"


@pytest.mark.parametrize(
    ("post", "hand", "wrong"),
    [
        ("arm", "tip", None),
        ("frame", "tip", ("lower", "peg of link post", "arm")),
        ("arm", "finger", ("upper", "pad of link hand", "tip")),
    ],
)
def test_lips_are_on_the_bodies_of_their_joint(
    post: str, hand: str, wrong: tuple[str, str, str] | None
) -> None:
    """Or on links fixed to them; a body that moves against both is refused, the right one named."""

    def ball(link_name: str, on: str, name: str, x: float, z: float) -> list[str]:
        return [
            f'<link name="{link_name}"><collision name="{name}"><origin xyz="{x!r} 0 {z!r}"/>'
            '<geometry><sphere radius="0.01"/></geometry></collision></link>',
            f'<joint name="{link_name}_fixed" type="fixed"><parent link="{on}"/>'
            f'<child link="{link_name}"/></joint>',
        ]

    parts = [
        *(link("arm"), hinge("arm", "frame", "arm")),
        *(link("tip"), hinge("tip", "arm", "tip")),
        *(link("finger"), hinge("finger", "tip", "finger")),
        *ball("post", post, "peg", 0.1, -0.01),
        *ball("hand", hand, "pad", 0.1, 0.01),
    ]
    contact = {"lower": "peg", "upper": "pad"}
    stops = {"s": {"joint": "tip", "restitution": 0.5, "contact": contact}}
    if wrong is None:
        found = machine(parts, 3, stops=stops).stops[0].contact
        assert found is not None
        assert found.lever_m == pytest.approx(0.1, rel=1e-12)
        return
    key, value, right = wrong
    with pytest.raises(ModelError, match=f"a lip on link {right},") as caught:
        machine(parts, 3, stops=stops)
    assert caught.value.evidence["key"] == f"stops.s.contact.{key}"
    assert caught.value.evidence["value"] == value
