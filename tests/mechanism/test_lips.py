"""Lips of every pair of shapes, touching up to a misfit of the drawing: statics and geometry."""

from __future__ import annotations

import itertools
import math
import shutil
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pinocchio as pin
import pytest
from any_plane import rewritten
from scipy.spatial import ConvexHull
from small_machines import frame, hinge, link, machine, slide

import nipper_pin as nip
from nipper_pin import Mechanism, ModelError

STRANGERS = Path(__file__).parents[1] / "strangers"

PLACE, HALF, LENGTH = 0.6875, 0.01, 0.9

QUARTER = 0.5 * math.pi

# Of each shape: its element in units of the scale, its turn, and half the width of its face.
SHAPES = {
    "box": ('<box size="{0} {0} {0}"/>', (0.0, 0.0, 0.0), HALF),
    "across": ('<cylinder radius="{1}" length="{0}"/>', (QUARTER, 0.0, 0.0), 0.0),
    "along": ('<cylinder radius="{1}" length="{0}"/>', (0.0, QUARTER, 0.0), HALF),
    "upright": ('<cylinder radius="{1}" length="{0}"/>', (0.0, 0.0, 0.0), HALF),
    "sphere": ('<sphere radius="{1}"/>', (0.0, 0.0, 0.0), 0.0),
    "cube": ('<mesh filename="cube.stl" scale="{2} {2} {2}"/>', (0.0, 0.0, 0.0), HALF),
    "wedge": ('<mesh filename="wedge.stl" scale="{2} {2} {2}"/>', (0.0, 0.0, 0.0), 0.0),
}


class Frame(NamedTuple):
    """How a machine is drawn: its plane, on which side of the hinge the lips are, and its scale."""

    turn: tuple[float, float, float] = (0.0, 0.0, 0.0)
    side: float = 1.0
    scale: float = 1.0


FRAMES = (
    Frame(),
    Frame(turn=(0.0, 0.0, QUARTER)),
    Frame(turn=(0.0, 0.0, math.pi / 6.0), side=-1.0),
    Frame(side=-1.0, scale=1e-3),
    Frame(scale=100.0),
)


def draw(
    folder: Path, pair: tuple[str, str], joint: str, misfit: float, shift: float, frame: Frame,
    tilt: float = 0.0,
) -> Path:  # fmt: skip
    """A rod with its lip, which may be tilted, on a peg."""
    scale, side = frame.scale, frame.side

    sizes = 2.0 * HALF * scale, HALF * scale, scale

    def lip(name: str, kind: str, x: float, z: float, *, down: bool) -> str:
        element, turn, _ = SHAPES[kind]
        first = pin.rpy.rpyToMatrix(*((math.pi, 0.0, 0.0) if down else (0.0, tilt, 0.0)))
        angles = pin.rpy.matrixToRpy(first @ pin.rpy.rpyToMatrix(*turn))
        rpy = " ".join(repr(float(angle)) for angle in angles)
        height = 0.0 if kind == "wedge" else HALF * scale
        return (
            f'<collision name="{name}"><origin xyz="{x!r} 0 {z - height if down else z + height!r}"'
            f' rpy="{rpy}"/><geometry>{element.format(*sizes)}</geometry></collision></link>'
        )

    peg = lip("peg", pair[0], side * PLACE * scale, 0.0, down=True)
    pad = lip("pad", pair[1], side * (PLACE + shift) * scale, misfit, down=False)
    rod = link("rod", 2.0, 0.1 * scale**2, (0.5 * side * LENGTH * scale, 0.0))
    move = slide if joint == "slide" else hinge
    axis = ((0.0, 1.0),) if joint == "slide" else ()
    moves = move("j", "frame", "rod", *axis).replace("0 -1 0", f"0 {-side!r} 0")
    body = f"{rod.replace('</link>', pad)}{moves}"
    urdf = f'<robot name="rod"><link name="frame">{peg}{body}</robot>'
    folder.mkdir(exist_ok=True)
    (folder / "rod.urdf").write_text(rewritten(urdf, pin.rpy.rpyToMatrix(*frame.turn), {}))
    for name in ("cube.stl", "wedge.stl"):
        shutil.copy(STRANGERS / "lips_mesh_wedge" / name, folder)
    shutil.copy(STRANGERS / "lips_mesh_wedge/lips_mesh_wedge.toml", folder / "rod.toml")
    return folder


def middle(pair: tuple[str, str], shift: float) -> float:
    """Distance of the middle of what lies together from the hinge, at the scale of one [m]."""
    lower, upper = (SHAPES[kind][2] for kind in pair)
    return PLACE + 0.5 * (max(-lower, shift - upper) + min(lower, shift + upper))


def accuracy(pair: tuple[str, str], misfit: float, scale: float) -> float:
    """By the lever: the misfit, and what the search for nearest points leaves."""
    arm = PLACE * scale
    if "upright" in pair:
        # The end of a curved edge: across it, distances change by less than their round-off.
        return abs(misfit) / arm + 6e-6
    if pair == ("wedge", "wedge"):
        # Two edges have the normal in which they part, of an opening of 8 um: its angle is half
        # of that, and the lever goes by its cosine.
        return abs(misfit) / arm + 1e-9 + (8e-6 / arm) ** 2 / 8.0
    return abs(misfit) / arm + 1e-9


@pytest.mark.sampled(5)
@pytest.mark.parametrize("joint", ["hinge", "slide"])
@pytest.mark.parametrize("pair", list(itertools.product(SHAPES, repeat=2)), ids="-".join)
def test_lips_have_the_lever_of_what_lies_together(
    pair: tuple[str, str], joint: str, tmp_path: Path
) -> None:
    random = np.random.default_rng(list(map(ord, joint + "".join(pair))))
    flat = any(SHAPES[kind][2] for kind in pair)
    # A micrometre is refused beyond, so that the largest misfits leave room for their round-off.
    misfits = [0.0, 1e-10, -1e-10, 1e-9, -1e-9, 2e-7, -2e-7, 0.9e-6, -0.9e-6]
    tried = [(drawn, misfit) for drawn in FRAMES[:1] for misfit in misfits]
    tried += [(drawn, misfit) for drawn in FRAMES for misfit in random.uniform(-9e-7, 9e-7, 2)]
    for drawn, size in tried:
        misfit = float(size) * min(1.0, drawn.scale)
        shift = 0.004 if flat and misfit else 0.0
        found = nip.load(draw(tmp_path, pair, joint, misfit, shift, drawn)).stops[0].lever
        right = 1.0 if joint == "slide" else middle(pair, shift) * drawn.scale
        within = accuracy(pair, misfit, drawn.scale)
        assert found == pytest.approx(right, rel=within), (drawn, misfit)


@pytest.mark.parametrize("joint", ["slide", "hinge"])
@pytest.mark.parametrize("kind", ["box", "cube", "upright"])
@pytest.mark.parametrize("misfit", [3e-4, 2e-6, -2e-6, -3e-4])
def test_lips_that_do_not_touch_say_their_gap(
    kind: str, misfit: float, joint: str, tmp_path: Path
) -> None:
    """Also of meshes that overlap; where they would touch is told, of a hinge by its lever.

    A hinge that closes 0.3 mm over 0.6875 m tilts the lips, whose ends are 10 mm from the middle.
    """
    folder = draw(tmp_path, (kind, kind), joint, misfit, 0.0, Frame())
    with pytest.raises(nip.ModelError, match="must touch within") as caught:
        nip.load(folder)
    evidence = caught.value.evidence
    assert (evidence["file"], evidence["key"]) == ("rod.toml", "stops.peg.contact")
    pair, _, gap = evidence["value"].rpartition(", ")
    assert pair == "peg and pad"
    assert float(gap.partition(" mm")[0]) == pytest.approx(1e3 * misfit, abs=1e-6)
    closing, unit = evidence["allowed"].rpartition("j = ")[2].split()
    if joint == "slide":
        assert float(closing.removesuffix(unit)) == pytest.approx(-1e3 * misfit, abs=1e-6)
    else:
        way = math.radians(float(closing)) * PLACE
        assert way == pytest.approx(-misfit, rel=2.0 * HALF / PLACE, abs=1e-9)


def test_faces_that_are_not_parallel_touch_at_an_edge(tmp_path: Path) -> None:
    """Within the misfit of 1 um they are parallel, and at most up to a small angle."""

    def lever(tilt: float, scale: float) -> float:
        """By the scale, where the outer edges touch."""
        height = HALF * scale * tilt
        frame = Frame(scale=scale)
        folder = draw(tmp_path, ("box", "box"), "hinge", height, 0.0, frame, tilt)
        return nip.load(folder).stops[0].lever / scale

    # Half the width of a lip, by the angle; lips of two metres open by 20 um.
    assert lever(1e-5, 1.0) == pytest.approx(PLACE, abs=1e-6)
    assert lever(1e-3, 1.0) == pytest.approx(PLACE + HALF, abs=2e-5)
    assert lever(1e-5, 100.0) == pytest.approx(PLACE + HALF, abs=2e-7)


@pytest.mark.parametrize("slope", [5e-6, 5e-5])
def test_lips_lie_together_up_to_where_a_face_slopes_away(
    slope: float, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of lips of two metres flat from -0.1 to 0.5 m, so that their middle is 0.2 m further out.

    Beyond, the upper one rises by less than the angle up to which faces count as parallel, but by
    more than the gap that counts as none.
    """
    left, right = -0.1 * HALF, 0.5 * HALF
    profile = [
        (-HALF, HALF),
        (HALF, HALF),
        (left, -HALF),
        (right, -HALF),
        (-HALF, slope * (left + HALF) - HALF),
        (HALF, slope * (HALF - right) - HALF),
    ]
    corners = np.array([(x, y, z) for x, z in profile for y in (-HALF, HALF)])
    facet = "facet normal 0 0 0\nouter loop\n{}endloop\nendfacet\n"
    text = "".join(
        facet.format("".join(f"vertex {x!r} {y!r} {z!r}\n" for x, y, z in corners[three].tolist()))
        for three in ConvexHull(corners).simplices
    )
    (tmp_path / "roof.stl").write_text(f"solid roof\n{text}endsolid roof\n")
    mesh = '<mesh filename="roof.stl" scale="{2} {2} {2}"/>'
    monkeypatch.setitem(SHAPES, "roof", (mesh, (0.0, 0.0, 0.0), HALF))
    folder = draw(tmp_path, ("box", "roof"), "hinge", 0.0, 0.0, Frame(scale=100.0))
    lever = nip.load(folder).stops[0].lever / 100.0
    assert lever == pytest.approx(PLACE + 0.5 * (left + right), abs=1e-8)


@pytest.mark.parametrize("kind", ["box", "cube"])
def test_what_opening_drives_together_is_refused(kind: str, tmp_path: Path) -> None:
    folder = draw(tmp_path, (kind, kind), "slide", -0.04, 0.0, Frame())
    with pytest.raises(nip.ModelError, match="growing"):
        nip.load(folder)


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
