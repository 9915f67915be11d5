"""One machine in every plane, with frames and axes of any sense: the same motion.

Rewriting rounds every placement once more, to a few eps of a metre or a radian. Along the runs here
that grows to 5e-14 of a rate; the bounds leave it a factor of twenty.
"""

from __future__ import annotations

import shutil
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from any_plane import Matrix, rewritten
from small_machines import frame, hinge, link, slide, sources

from nipper_pin import Case, Mechanism, Solution, Window, load, simulate
from nipper_pin.cli import main
from nipper_pin.mechanism import changed, from_sources, joint_placements, number_of
from nipper_pin.view.scene import Solid, solids
from nipper_pin.view.sketch import sketch

HINGES, SLIDES = ("pole_hinge", "arm_hinge"), ("rail",)
PARTS = [
    link("cart", 1.3, 0.02, (0.05, 0.03)), slide("rail", "frame", "cart", (0.8, 0.6), (0.1, 0.2)),
    link("pole", 0.7, 0.05, (0.02, 0.5)), hinge("pole_hinge", "cart", "pole", (0.03, -0.02)),
    link("arm", 0.4, 0.01, (0.1, 0.02)), hinge("arm_hinge", "pole", "arm", (0.1, 0.4)),
    frame("tip", "arm", (0.3, 0.1)),
]  # fmt: skip


def about_z(angle: float) -> Matrix:
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def about_x(angle: float) -> Matrix:
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]])


def tables(senses: dict[str, float], gravity: float) -> dict[str, Any]:
    """Tables of the machine in coordinates of the given senses."""
    rail, pole = senses.get("rail", 1.0), senses.get("pole_hinge", 1.0)
    return {
        "gravity": gravity,
        "stops": {
            "low": {"joint": "rail", "restitution": 0.6, "at_mm": -50.0 * rail,
                    "side": "lower" if rail > 0.0 else "upper"},
            "high": {"joint": "pole_hinge", "restitution": 0.5, "at_deg": 40.0 * pole,
                     "side": "upper" if pole > 0.0 else "lower"},
        },
        "springs": {
            "coil": {"joint": "pole_hinge", "stiffness_N_m_per_rad": 3.0,
                     "preload_deg": -20.0 * pole},
            "strut": {"frame_a": "frame", "frame_b": "tip", "stiffness_N_per_m": 30.0,
                      "free_length_mm": 500.0},
        },
        "dampers": {"oil": {"joint": "arm_hinge", "damping_N_m_s_per_rad": 0.01}},
        "initial": {"rail": {"at_mm": 20.0 * rail, "rate_mm_per_s": 100.0 * rail},
                    "pole_hinge": {"at_deg": 10.0 * pole}},
    }  # fmt: skip


@cache
def run(urdf: str, turned: tuple[str, ...], gravity: float) -> Solution:
    _, document = sources([], 3, **tables(dict.fromkeys(turned, -1.0), gravity))
    mechanism = from_sources("small", urdf, document, ".")
    return simulate(mechanism, Case(speed_rpm=60.0, window=Window.CYCLE))


def signs(mechanism: Mechanism, senses: dict[str, float]) -> Matrix:
    return np.array([senses.get(joint.name, 1.0) for joint in mechanism.joints])


# Rotation of the machine, part of gravity in its plane, words of the side view.
PLANES = {
    "x-z": (np.eye(3), 1.0, ""),
    "from behind": (about_z(np.pi), 1.0, ""),
    "y-z": (about_z(np.pi / 2), 1.0, "the plane of y and z of the URDF is the side view here"),
    "upright": (about_z(0.7), 1.0, "the plane of (0.764842, 0.644218, 0) and z of the URDF"),
    "tilted": (about_z(0.4) @ about_x(0.5), float(np.cos(0.5)), "0.877583 of gravity acts in it"),
    "flat": (about_x(-np.pi / 2), 0.0, "the plane of x and y of the URDF"),
}


@pytest.mark.sampled(7)
@pytest.mark.parametrize("plane", PLANES)
@pytest.mark.parametrize("turned", [(), HINGES, SLIDES, ("rail", "arm_hinge")], ids=str)
@pytest.mark.parametrize("frames", [False, True], ids=["frames turned", "frames at random"])
def test_a_machine_moves_alike_in_every_plane(
    plane: str, turned: tuple[str, ...], frames: bool
) -> None:
    turn, part, words = PLANES[plane]
    urdf, _ = sources(PARTS, 3)
    senses = dict.fromkeys(turned, -1.0)
    gravity = 9.81 / part if part else 9.81
    plain = run(urdf, (), 9.81 * (part > 0.0))
    changed = rewritten(urdf, turn, senses, np.random.default_rng(3) if frames else None)
    other = run(changed, turned, gravity)
    assert other.mechanism.gravity_m_s2 == pytest.approx(plain.mechanism.gravity_m_s2, rel=1e-15)
    clockwise = {name for name in HINGES if (name in turned) != (plane == "from behind")}
    said = other.mechanism.side_view
    assert words in said
    assert all((name in said) == (name in clockwise) for name in HINGES)
    assert bool(said) == bool(words or clockwise)
    sign = signs(plain.mechanism, senses)
    assert len(plain.events) == len(other.events) > 0
    for one, two in zip(plain.events, other.events, strict=True):
        assert (one.kind, one.stops) == (two.kind, two.stops)
        assert two.t == pytest.approx(one.t, abs=1e-12)
        np.testing.assert_allclose(two.q, sign * one.q, atol=1e-12)
        np.testing.assert_allclose(two.v_after, sign * one.v_after, atol=1e-12)
        for stop, impulse in one.P_N.items():
            assert two.P_N[stop] == pytest.approx(impulse, abs=1e-12)


COMBER = ("pendulum_shaft", "nipper_pivot", "jaw", "rod_pin", "rocker_pin", "tension_shaft")


@pytest.fixture(scope="module")
def comber(e62: Mechanism) -> Solution:
    return simulate(e62, Case(speed_rpm=650.0))


@pytest.mark.parametrize("turned", [(), COMBER, ("pendulum_shaft", "tension_shaft")], ids=str)
@pytest.mark.parametrize("plane", ["from behind", "y-z", "tilted"])
def test_a_comber_moves_alike_in_every_plane(
    plane: str, turned: tuple[str, ...], comber: Solution
) -> None:
    """Guide, gears, loops and lips: drives and stops of hinges that turn the other way."""
    turn, part, _ = PLANES[plane]
    plain = comber.mechanism
    document: dict[str, Any] = {**plain.description, "gravity_m_s2": float(9.81 / part)}
    senses = dict.fromkeys(turned, -1.0)
    if "jaw" in senses:
        stops = document["stops"]
        document["stops"] = {**stops, "jaw": {**stops["jaw"], "side": "upper"}}
    # From behind, x points the other way; the drawing of the drives stays in front.
    if plane == "from behind":
        turn = about_z(np.pi / 2)
    urdf = rewritten(plain.urdf, turn, senses, np.random.default_rng(5))
    other = from_sources("e62", urdf, document, plain.mesh_folder)
    for ours, theirs in zip(plain.stops, other.stops, strict=True):
        if ours.contact is not None and theirs.contact is not None:
            np.testing.assert_allclose(theirs.contact.point, ours.contact.point, atol=1e-9)
            np.testing.assert_allclose(theirs.contact.normal, ours.contact.normal, atol=1e-9)
    two = simulate(other, comber.case)
    sign = signs(plain, senses)
    assert len(comber.collisions) == len(two.collisions)
    # Closures are met to round-off of 0.3 m, and a transition multiplies it by its condition.
    for first, second in zip(comber.events, two.events, strict=True):
        assert second.t == pytest.approx(first.t, abs=1e-11)
        np.testing.assert_allclose(second.q, sign * first.q, atol=1e-11)
        np.testing.assert_allclose(second.v_after, sign * first.v_after, atol=1e-9)


def test_drawn_parts_and_dimensions_are_those_of_the_side_view() -> None:
    """Shapes stand where they stood; a pin, a centre of mass and an inertia go where they are told.

    Inertias across the plane stand at another letter of the file where its frames are others.
    """
    plain = load("e62")
    document = dict(plain.description)
    urdf = rewritten(plain.urdf, about_z(np.pi / 2), {}, None)
    other = from_sources("e62", urdf, document, plain.mesh_folder)
    for one, two in zip(solids(plain), solids(other), strict=True):
        assert (one.name, one.body) == (two.name, two.body)
        np.testing.assert_allclose(placed(other, two), placed(plain, one), atol=1e-12)
    values = {
        "points.rocker_pin.x_mm": 121.0,
        "links.rocker.inertia_kg_m2": 0.002,
        "links.rocker.com_x_mm": 80.0,
    }
    told = [changed(machine, values) for machine in (plain, other)]
    for path, value in values.items():
        assert [number_of(machine, path) for machine in told] == pytest.approx([value] * 2)
    for one, two in zip(*(machine.model.inertias for machine in told), strict=True):
        np.testing.assert_allclose(two.toDynamicParameters(), one.toDynamicParameters(), atol=1e-12)


def placed(mechanism: Mechanism, solid: Solid) -> Matrix:
    """World placement of a drawn part at q = 0, shape (4, 4)."""
    if solid.body < 0:
        return solid.placement
    joint = mechanism.model.getJointId(mechanism.joints[solid.body].name)
    found: Matrix = joint_placements(mechanism.model)[joint].homogeneous @ solid.placement
    return found


def test_a_turned_machine_is_drawn(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """As the other one: its places in the drawing, and the words of `check`."""
    plain = load("e62")
    turned = rewritten(plain.urdf, about_z(np.pi / 2), {}, np.random.default_rng(5))
    folder = tmp_path / "e62"
    shutil.copytree(plain.mesh_folder, folder)
    (folder / "e62.urdf").write_text(turned, encoding="utf-8")
    assert main(["check", str(folder), "--drawing", str(tmp_path / "drawing.svg")]) == 0
    said = " ".join(capsys.readouterr().out.split())
    assert "the plane of y and z of the URDF is the side view here" in said
    one, two = sketch(plain), sketch(load(folder))
    for first, second in zip(one.nodes, two.nodes, strict=True):
        assert first.name == second.name
        np.testing.assert_allclose(second.place, first.place, atol=1e-12)
