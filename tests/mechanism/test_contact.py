"""The contact of the lips against its construction."""

import math
from pathlib import Path

import numpy as np
import pytest
from small_machines import frame, hinge, link, machine, slide

from nipper_pin import Mechanism, ModelError, load
from nipper_pin.mechanism import collision_model
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


def ball(part: str, name: str, x: float, z: float = 0.0) -> str:
    """A link or a frame with a ball of 10 mm."""
    shape = (
        f'<collision name="{name}"><origin xyz="{x!r} 0 {z!r}"/><geometry><sphere radius="0.01"/>'
        "</geometry></collision></link>"
    )
    whole = part if "</link>" in part else part.replace("/>", "></link>", 1)
    return whole.replace("</link>", shape, 1)


@pytest.mark.parametrize(("side", "place"), [("lower", -40.0), ("upper", 40.0)])
def test_shapes_meet_where_the_stop_is(side: str, place: float) -> None:
    """Two balls of 10 mm, 60 mm apart, meet at 40 mm on either side; the lever is one, outwards.

    The contact point is the middle between their centres at that coordinate, and the normal points
    from the ball on the frame to the one that leaves it.
    """
    sense = 1.0 if side == "lower" else -1.0
    parts = [ball(frame("post", "frame"), "post_ball", -sense * 0.06),
             ball(link("cart"), "cart_ball", 0.0), slide("x", "frame", "cart")]  # fmt: skip

    def build(at: float) -> Mechanism:
        contact = {"lower": "post_ball", "upper": "cart_ball"}
        stop = {"joint": "x", "restitution": 0.5, "side": side, "at_mm": at, "contact": contact}
        return machine(parts, 1, stops={"touch": stop})

    contact = build(place).stops[0].contact
    assert contact is not None
    assert contact.closing_coordinate == pytest.approx(1e-3 * place, abs=1e-12)
    assert contact.point == pytest.approx([-sense * 0.05, 0.0, 0.0], abs=1e-9)
    assert contact.normal == pytest.approx([sense, 0.0, 0.0], abs=1e-9)
    assert contact.lever_m == pytest.approx(1.0, rel=1e-12)
    with pytest.raises(ModelError, match=r"10 mm apart at x = .*touch at x = -?40 mm"):
        build(0.75 * place)


@pytest.mark.parametrize(
    ("post", "hand", "key", "found", "right"),
    [("arm", "tip", "", "", ""), ("frame", "tip", "lower", "peg of link post", "arm"),
     ("arm", "finger", "upper", "pad of link hand", "tip")],
)  # fmt: skip
def test_lips_are_on_the_bodies_of_their_joint(
    post: str, hand: str, key: str, found: str, right: str
) -> None:
    """Or on links fixed to them; a body that moves against both is refused, the right one named."""
    parts = [link("arm"), hinge("arm", "frame", "arm"), link("tip"), hinge("tip", "arm", "tip"),
             link("finger"), hinge("finger", "tip", "finger"),
             ball(frame("post", post), "peg", 0.1, -0.01),
             ball(frame("hand", hand), "pad", 0.1, 0.01)]  # fmt: skip
    contact = {"lower": "peg", "upper": "pad"}
    stops = {"s": {"joint": "tip", "restitution": 0.5, "contact": contact}}
    if not key:
        assert machine(parts, 3, stops=stops).stops[0].lever == pytest.approx(0.1, rel=1e-12)
        return
    with pytest.raises(ModelError, match=f"a lip on link {right},") as caught:
        machine(parts, 3, stops=stops)
    evidence = caught.value.evidence
    assert (evidence["key"], evidence["value"]) == (f"stops.s.contact.{key}", found)
