"""The lips close up on the live page: where a style puts the outlines that are sent once."""

from __future__ import annotations

import re

import numpy as np
import pinocchio as pin
import pytest
from runs_shown import run_of
from small_machines import SHAFT, hinge, link, machine

pytest.importorskip("viser")

from nipper_pin import Mechanism, Solution
from nipper_pin.view.live.lips import Lips

MM, PIXELS = 1e3, (320.0, 180.0)


@pytest.fixture(scope="module")
def run() -> Solution:
    return run_of("transition")


def matrices(style: str) -> dict[int, tuple[np.ndarray, np.ndarray]]:
    """By link: matrix and shift of (x, z) [mm] in the link to pixels, as CSS defines them."""
    found = {}
    for body, numbers in re.findall(r"\.lips-(\d+) \{ transform: matrix\(([^)]*)\)", style):
        a, b, c, d, e, f = map(float, numbers.split(","))
        found[int(body)] = np.array([[a, c], [b, d]]), np.array([e, f])
    return found


def contact_in(mechanism: Mechanism) -> dict[str, np.ndarray]:
    """The contact point (x, z) [mm] in the frames of both lips, which meet there at zero."""
    model, data = mechanism.model, mechanism.model.createData()
    pin.forwardKinematics(model, data, np.zeros(model.nq))
    point = mechanism.stop("jaw").contact.point
    return {
        joint.child: MM * data.oMi[model.getJointId(joint.name)].actInv(point)[[0, 2]]
        for joint in mechanism.joints
    }


@pytest.mark.parametrize("larger", [1.0, 10.0])
def test_both_lips_stand_apart_by_the_gap(e62: Mechanism, run: Solution, larger: float) -> None:
    """The lower one in the middle, the upper one above it by lever times angle, to second order.

    Drawn at the wrong scale, mirrored or turned, the contact point of the upper lip would lie
    elsewhere: its place is computed by Pinocchio's own kinematics of another configuration.
    """
    first = run.collisions[0]
    q = run.trajectory.evaluate(first.t + 0.5 * first.rebound_time).q[0]
    angle = e62.stop("jaw").gap(q)
    style = Lips(e62).style(q, first.rebound_amplitude, larger)
    place = contact_in(e62)
    names = [joint.child for joint in e62.joints]
    at = {
        name: matrix @ place[name] + shift
        for name, (matrix, shift) in ((names[k], found) for k, found in matrices(style).items())
    }
    middle = 0.5 * np.array(PIXELS)
    assert at["bottom_nipper"] == pytest.approx(middle, abs=2e-3)
    high = {1.0: 12.0, 10.0: 25.0}[larger]
    scale = PIXELS[1] / high
    gap = MM * e62.stop("jaw").lever * angle
    up = middle[1] - at["top_nipper"][1]
    # The chord of a circle differs from its arc by angle / 2 of it.
    assert up == pytest.approx(scale * gap, rel=angle)
    assert abs(at["top_nipper"][0] - middle[0]) < 1.5 * angle * scale * gap + 2e-3
    for matrix, _ in matrices(style).values():
        # (x, z) to pixels, whose second axis points down: a rotation, mirrored.
        assert np.linalg.det(matrix) == pytest.approx(-(scale**2), rel=1e-4)


def test_closed_lips_meet_and_the_scale_is_told(e62: Mechanism) -> None:
    style = Lips(e62).style(np.zeros(e62.model.nv), 0.0, 1.0)
    place, names = contact_in(e62), [joint.child for joint in e62.joints]
    for body, (matrix, shift) in matrices(style).items():
        if names[body] in ("top_nipper", "bottom_nipper"):
            at = matrix @ place[names[body]] + shift
            assert at == pytest.approx(0.5 * np.array(PIXELS), abs=2e-3)
    assert 'content: "bar 2 mm; true"' in style
    bar = re.search(r"\.lips-bar \{[^}]*scale\(([\d.]+), 1\)", style)
    assert bar is not None
    assert float(bar[1]) == pytest.approx(2.0 * PIXELS[1] / 12.0, rel=1e-4)


@pytest.mark.parametrize(
    ("gap_mm", "larger", "high", "bar"),
    [(2.9, 1.0, 12.0, 2), (3.1, 1.0, 25.0, 5), (0.5, 20.0, 50.0, 10), (1000.0, 1.0, 250.0, 50)],
)
def test_the_view_holds_the_largest_rebound(
    e62: Mechanism, gap_mm: float, larger: float, high: float, bar: int
) -> None:
    angle = gap_mm / MM / e62.stop("jaw").lever
    style = Lips(e62).style(np.zeros(e62.model.nv), angle, larger)
    scale = np.sqrt(-np.linalg.det(matrices(style)[1][0]))
    assert scale == pytest.approx(PIXELS[1] / high, rel=1e-4)
    assert f"bar {bar} mm; {'true' if larger == 1.0 else f'rebounds x {larger:g}'}" in style


def test_outlines_are_those_of_the_meshes(e62: Mechanism) -> None:
    """Each link that is cut has its outline, inside of the box around its visuals."""
    html = Lips(e62).html
    names = [joint.child for joint in e62.joints]
    assert {"top_nipper", "bottom_nipper"} <= {
        names[int(k)] for k in re.findall(r'class="lips-(\d+)"', html)
    }
    for outline in re.findall(r' d="([^"]*)"', html):
        points = np.array([pair.split() for pair in re.findall(r"[ML]([-\d. ]+)", outline)], float)
        assert len(points) > 2
        assert np.abs(points).max() < MM * e62.reach_m


def test_a_stop_without_contact_point_has_no_close_up() -> None:
    parts = [
        link("crank", 2.0, 0.01, (0.01, 0.0)), hinge("shaft", "frame", "crank"),
        link("flap", 0.5, 0.01, (0.05, 0.0)), hinge("pin", "crank", "flap", (0.05, 0.1)),
    ]  # fmt: skip
    made = machine(
        parts, 2,
        drives={"shaft": {"joint": "shaft", "law": "constant_speed", "ratio": 1.0, **SHAFT}},
        stops={"flap": {"joint": "pin", "restitution": 0.3, "side": "lower", "at_deg": 0.0}},
        transition_stop="flap",
        phases=[{"number": 1, "name": "open", "closed": []}],
    )  # fmt: skip
    lips = Lips(made)
    assert lips.html == ""
    assert lips.style(np.zeros(2), 0.0, 1.0) == ""
