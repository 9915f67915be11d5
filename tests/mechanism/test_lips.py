"""Lips of every pair of shapes, touching up to a misfit of the drawing, against statics.

A rod of 0.9 m and 2 kg, hinged at the origin, rests on a peg at 0.6875 m: the contact carries
m g (L/2) / x at x, the middle of what lies together, and all of m g if the rod is on a slide.
"""

import itertools
import math
import shutil
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pinocchio as pin
import pytest

import nipper_pin as nip

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


def words(values: object) -> str:
    """Numbers as a URDF has them."""
    return " ".join(repr(float(value) + 0.0) for value in np.asarray(values))


def draw(
    folder: Path, pair: tuple[str, str], joint: str, misfit: float, shift: float, frame: Frame
) -> Path:
    """A rod with its lip on a peg."""
    scale, side = frame.scale, frame.side
    plane = pin.rpy.rpyToMatrix(*frame.turn)
    elements = (2.0 * HALF * scale, HALF * scale, scale)

    def lip(kind: str, x: float, z: float, *, down: bool) -> str:
        element, turn, _ = SHAPES[kind]
        height = 0.0 if kind == "wedge" else HALF * scale
        turned = pin.rpy.rpyToMatrix(math.pi if down else 0.0, 0.0, 0.0) @ pin.rpy.rpyToMatrix(
            *turn
        )
        place = words(plane @ [x, 0.0, z - height if down else z + height])
        angles = words(pin.rpy.matrixToRpy(plane @ turned))
        name = "peg" if down else "pad"
        return (
            f'<collision name="{name}"><origin xyz="{place}" rpy="{angles}"/><geometry>'
            f"{element.format(*elements)}</geometry></collision>"
        )

    slides = joint == "slide"
    axis = words(plane @ ([0.0, 0.0, 1.0] if slides else [0.0, -side, 0.0]) + 0.0)
    kind = "prismatic" if slides else "continuous"
    limit = '<limit lower="-10" upper="10" effort="1" velocity="1"/>' if slides else ""
    centre = words(plane @ [0.5 * side * LENGTH * scale, 0.0, 0.0])
    inertia = " ".join(
        f'i{a}{b}="{0.1 * scale**2 if a == b else 0.0!r}"'
        for a, b in itertools.combinations_with_replacement("xyz", 2)
    )
    peg = lip(pair[0], side * PLACE * scale, 0.0, down=True)
    pad = lip(pair[1], side * (PLACE * scale + shift * scale), misfit, down=False)
    folder.mkdir(exist_ok=True)
    (folder / "rod.urdf").write_text(
        f'<robot name="rod"><link name="frame">{peg}</link><link name="rod"><inertial>'
        f'<origin xyz="{centre}"/><mass value="2"/><inertia {inertia}/></inertial>{pad}</link>'
        f'<joint name="j" type="{kind}"><parent link="frame"/><child link="rod"/>'
        f'<axis xyz="{axis}"/>{limit}</joint></robot>'
    )
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
    tried = [(frame, misfit) for frame in FRAMES[:1] for misfit in misfits]
    tried += [(frame, misfit) for frame in FRAMES for misfit in random.uniform(-9e-7, 9e-7, 2)]
    for frame, size in tried:
        misfit = float(size) * min(1.0, frame.scale)
        shift = 0.004 if flat and misfit else 0.0
        mechanism = nip.load(draw(tmp_path, pair, joint, misfit, shift, frame))
        contact = mechanism.stops[0].contact
        assert contact is not None
        right = 1.0 if joint == "slide" else middle(pair, shift) * frame.scale
        within = accuracy(pair, misfit, frame.scale)
        assert contact.lever_m == pytest.approx(right, rel=within), (frame, misfit)


@pytest.mark.parametrize("joint", ["hinge", "slide"])
@pytest.mark.parametrize(
    "pair", [("box", "box"), ("cube", "cube"), ("cube", "wedge"), ("along", "cube")], ids="-".join
)
@pytest.mark.parametrize("misfit", [-3e-7, 1e-10, 4e-7])
def test_lips_carry_the_weight(
    pair: tuple[str, str], joint: str, misfit: float, tmp_path: Path
) -> None:
    mechanism = nip.load(draw(tmp_path, pair, joint, misfit, 0.0, Frame()))
    case = nip.Case(speed_rpm=60.0, window=nip.Window.CYCLE)
    carried = nip.simulate(mechanism, case).trajectory.reactions(0.5).contacts["peg"]
    force = 2.0 * 9.81 * (1.0 if joint == "slide" else 0.5 * LENGTH / PLACE)
    assert carried == pytest.approx(force, rel=accuracy(pair, misfit, 1.0))


@pytest.mark.parametrize("kind", ["box", "cube", "upright"])
@pytest.mark.parametrize("misfit", [3e-4, 2e-6, -2e-6, -3e-4])
def test_lips_that_do_not_touch_say_their_gap(kind: str, misfit: float, tmp_path: Path) -> None:
    """Also of meshes that overlap; where they would touch is told."""
    folder = draw(tmp_path, (kind, kind), "slide", misfit, 0.0, Frame())
    with pytest.raises(nip.ModelError, match="must touch within") as caught:
        nip.load(folder)
    gap = float(caught.value.evidence["value"].rpartition(", ")[2].partition(" mm")[0])
    closing = float(caught.value.evidence["allowed"].rpartition("j = ")[2].partition(" mm")[0])
    assert gap == pytest.approx(1e3 * misfit, abs=1e-6)
    assert closing == pytest.approx(-1e3 * misfit, abs=1e-6)


def test_faces_that_are_not_parallel_touch_at_an_edge(tmp_path: Path) -> None:
    """Within the misfit of 1 um they are; a thousandth of a radian leaves the outer edge."""
    folder = draw(tmp_path, ("box", "box"), "hinge", 0.0, 0.0, Frame())
    urdf = folder / "rod.urdf"
    straight = urdf.read_text()
    pad = 'rpy="0.0 0.0 0.0"/><geometry><box'
    assert straight.count(pad) == 1

    def lever(angle: float, height: float) -> float:
        turned = straight.replace(pad, f'rpy="0.0 {angle!r} 0.0"/><geometry><box')
        urdf.write_text(turned.replace('0.0 0.01"', f'0.0 {0.01 + height!r}"'))
        contact = nip.load(folder).stops[0].contact
        assert contact is not None
        return contact.lever_m

    # Half the width of a lip, by the angle.
    assert lever(1e-5, 1e-7) == pytest.approx(PLACE, abs=1e-6)
    assert lever(1e-3, 1e-5) == pytest.approx(PLACE + HALF, abs=2e-5)


@pytest.mark.parametrize("kind", ["box", "cube"])
def test_what_opening_drives_together_is_refused(kind: str, tmp_path: Path) -> None:
    folder = draw(tmp_path, (kind, kind), "slide", -0.04, 0.0, Frame())
    with pytest.raises(nip.ModelError, match="growing"):
        nip.load(folder)
