"""Springs and dampers of every kind against closed forms.

No number comes from the package: forces are checked by differences of energies, motions by closed
solutions.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
import sprung
from sprung import GRAVITY, STIFFNESS

from nipper_pin import ElementError, Mechanism
from nipper_pin.dynamics import ShaftMotion, System

PRELOAD, DAMPING = 0.03, 1.3


def elements(kind: str, parts: int) -> str:
    """Springs and dampers of an oscillator, on its joint or between two points of its line.

    Args:
        kind: "slide", "hinge" or "line".
        parts: Number of springs, and of dampers; whatever it is they add up to the same.
    """
    joint = {"slide": 'joint = "x"\n', "hinge": 'joint = "turn"\n'}.get(kind, "")
    line = 'frame_a = "{}"\nframe_b = "{}"\n'
    found, left = [], (STIFFNESS, STIFFNESS * PRELOAD, DAMPING)
    for part in range(parts):
        # The first ones pull the other way, and the last one has what is then left.
        k, push, c = left if part == parts - 1 else (25.0 + part, -1.5 - part, 0.3 + 0.1 * part)
        left = (left[0] - k, left[1] - push, left[2] - c)
        spring = {
            "slide": f"stiffness_N_per_m = {k!r}\npreload_length_mm = {1e3 * push / k!r}",
            "hinge": f"stiffness_N_m_per_rad = {k!r}\npreload_deg = {math.degrees(push / k)!r}",
            "line": f"stiffness_N_per_m = {k!r}\nfree_length_mm = {1e3 * (0.4 - push / k)!r}",
        }[kind]
        unit = "N_m_s_per_rad" if kind == "hinge" else "N_s_per_m"
        found += [
            f"[springs.coil_{part}]\n{joint or line.format('wall', 'link_x')}{spring}\n",
            f"[dampers.oil_{part}]\n{joint or line.format('link_x', 'wall')}"
            f"damping_{unit} = {c!r}\n",
        ]
    return "".join(found)


@pytest.mark.parametrize("parts", [1, 2, 3])
@pytest.mark.parametrize("kind", ["slide", "hinge", "line"])
def test_damped_oscillator(kind: str, parts: int) -> None:
    """x + p = p exp(-d t) (cos w t + d / w sin w t): motion, decrement and heat, to 1e-11.

    Some twenty panels at 1e-12 each. With a damping off by a thousandth the last of five swings
    would be wrong by half a per cent of itself; the decrement alone would not notice a wrong start.
    """
    joint = sprung.HINGE if kind == "hinge" else sprung.SLIDE_X
    wall = {"wall": ("frame", -0.4, 0.0)}
    mechanism = sprung.machine([joint], elements(kind, parts), frames=wall)
    inertia = sprung.INERTIA if kind == "hinge" else sprung.MASS
    d = 0.5 * DAMPING / inertia
    square = STIFFNESS / inertia - d**2
    assert square > 0.0
    w = math.sqrt(square)
    period = math.tau / w
    solution = sprung.swing(mechanism, 5.0 * period)
    t = np.linspace(0.0, 5.0 * period, 101)
    x, v = sprung.moved(solution, t, joint[0])
    wave = PRELOAD * np.exp(-d * t)
    exact = wave * (np.cos(w * t) + d / w * np.sin(w * t))
    rate = -wave * (w + d**2 / w) * np.sin(w * t)
    assert np.abs(x + PRELOAD - exact).max() <= 1e-11 * PRELOAD
    assert np.abs(v - rate).max() <= 1e-11 * PRELOAD * w
    peaks = (x + PRELOAD)[::20]
    np.testing.assert_allclose(np.log(peaks[:-1] / peaks[1:]), d * period, rtol=1e-8)
    # All energy is the spring's at first; what is left of it is in spring and mass.
    left = 0.5 * STIFFNESS * exact[-1] ** 2 + 0.5 * inertia * rate[-1] ** 2
    lost = 0.5 * STIFFNESS * PRELOAD**2 - left
    assert solution.energy.dissipated == pytest.approx(lost, rel=1e-11)
    assert abs(solution.energy.residual) <= 1e-11 * lost


def test_spring_of_free_length_zero_passes_through_its_point() -> None:
    """A force proportional to the line has no singular point: x = a cos w t, to 1e-11.

    The mass passes the point four times. With a direction instead of the line as factor it would
    be refused there, as the next test shows.
    """
    frames = {"post": ("frame", 0.25, 0.0)}
    spring = f"""
[springs.band]
frame_a = "post"
frame_b = "link_x"
stiffness_N_per_m = {STIFFNESS}
free_length_mm = 0.0
"""
    w = math.sqrt(STIFFNESS / sprung.MASS)
    solution = sprung.swing(
        sprung.machine([sprung.SLIDE_X], spring, frames=frames), 4.0 * math.pi / w
    )
    t = np.linspace(*solution.trajectory.span, 81)
    x, _ = sprung.moved(solution, t, "x")
    assert np.abs(x - 0.25 * (1.0 - np.cos(w * t))).max() <= 1e-11 * 0.25


def test_points_that_come_to_coincide_are_refused() -> None:
    """One error that names the element and its frames, at the time of the meeting.

    Up to there x = a (1 - cos w t) with the stiffness of both springs; at the post the force of
    the rod would jump from 10 N one way to 10 N the other.
    """
    text = f"""
[springs.puller]
joint = "x"
stiffness_N_per_m = {STIFFNESS}
preload_length_mm = -150.0
[springs.rod]
frame_a = "post"
frame_b = "link_x"
stiffness_N_per_m = 200.0
free_length_mm = 50.0
"""
    frames = {"post": ("frame", 0.1, 0.0)}
    mechanism = sprung.machine([sprung.SLIDE_X], text, frames=frames)
    a, w = (0.15 * STIFFNESS + 10.0) / (STIFFNESS + 200.0), math.sqrt(290.0 / sprung.MASS)
    with pytest.raises(ElementError, match=r"spring rod: .*post and link_x coincide") as caught:
        sprung.swing(mechanism, 2.0)
    assert caught.value.evidence["element"] == "rod"
    assert caught.value.evidence["t"] == pytest.approx(math.acos(1.0 - 0.1 / a) / w, abs=1e-6)


def test_damper_between_points_that_coincide_is_refused() -> None:
    """Exactly at the meeting its force has no direction; a micrometre away it has."""
    text = """
[dampers.oil]
frame_a = "post"
frame_b = "link_x"
damping_N_s_per_m = 2.0
"""
    frames = {"post": ("frame", 0.25, 0.0)}
    mechanism = sprung.machine([sprung.SLIDE_X], text, frames=frames)
    system = System(mechanism, ShaftMotion(mechanism, 1.0, 0.0))
    place = next(joint.index for joint in mechanism.joints if joint.name == "x")
    q, v = np.zeros((2, 1, 2))
    q[0, place], v[0, place] = 0.25 - 1e-6, 3.0
    assert system.applied_forces(q, v)[0, place] == pytest.approx(-6.0, rel=1e-9)
    q[0, place] = 0.25
    with pytest.raises(ElementError, match=r"damper oil: .*post and link_x coincide"):
        system.applied_forces(q, v)


def elastic_pendulum(length: float, angle: float) -> Mechanism:
    """A mass with both slides on a spring of free length 0.3 m that hangs from a post."""
    frames = {"post": ("frame", -length * math.sin(angle), length * math.cos(angle))}
    spring = f"""
[springs.band]
frame_a = "post"
frame_b = "link_z"
stiffness_N_per_m = {STIFFNESS}
free_length_mm = 300.0
"""
    return sprung.machine([sprung.SLIDE_X, sprung.SLIDE_Z], spring, frames=frames, gravity=GRAVITY)


LENGTH = 0.3 + sprung.MASS * GRAVITY / STIFFNESS


def test_elastic_pendulum_keeps_its_energy() -> None:
    """From 50 degrees, stretched by 5 cm, over some ten swings: 1e-10 of what is exchanged.

    Spring and gravity exchange a joule and more while the mass swings all over the plane, so a
    force that is not the gradient of the energy by a billionth would show.
    """
    mechanism = elastic_pendulum(LENGTH + 0.05, math.radians(50.0))
    solution = sprung.swing(mechanism, 12.0)
    energy = solution.energy
    t = np.linspace(*solution.trajectory.span, 400)
    q = solution.trajectory.evaluate(t, left=True).q
    assert np.ptp(q[:, [j.index for j in mechanism.joints if j.name in "xz"]], axis=0).min() > 0.3
    spring = solution.system.spring_energy(q)
    assert np.ptp(spring) > 1.0
    assert abs(energy.residual) <= 1e-10 * np.ptp(spring)
    assert energy.dissipated == 0.0


def test_small_swings_of_the_elastic_pendulum() -> None:
    """Half a period pi sqrt(l / g) after a start at 1e-4 rad the mass is on the other side.

    The deviations are of the order of the angle squared, 1e-8, and so is the tolerance of 1e-6 of
    the swing (the spring's own swing has a frequency of its own and an amplitude of that order).
    """
    angle = 1e-4
    half = math.pi * math.sqrt(LENGTH / GRAVITY)
    solution = sprung.swing(elastic_pendulum(LENGTH, angle), half)
    t = np.linspace(0.0, half, 21)
    x, _ = sprung.moved(solution, t, "x")
    swung = LENGTH * math.sin(angle)
    assert np.abs(x - -swung * (1.0 - np.cos(np.pi * t / half))).max() <= 1e-6 * swung


def test_vertical_swings_of_the_elastic_pendulum() -> None:
    """Stretched by 5 cm it swings up and down with sqrt(k / m): z = a (1 - cos w t), to 1e-10."""
    w = math.sqrt(STIFFNESS / sprung.MASS)
    solution = sprung.swing(elastic_pendulum(LENGTH + 0.05, 0.0), 3.0 * math.tau / w)
    t = np.linspace(*solution.trajectory.span, 81)
    z, _ = sprung.moved(solution, t, "z")
    assert np.abs(z - 0.05 * (1.0 - np.cos(w * t))).max() <= 1e-10 * 0.05


def test_energy_of_everything_together(pendulum: Mechanism) -> None:
    """Two seconds of a double pendulum with all kinds at once: the balance closes to 1e-10.

    The heat is more than a fifth of what is exchanged, so the balance cannot close without it.
    """
    solution = sprung.swing(pendulum, 2.0)
    energy = solution.energy
    exchanged = abs(energy.gravity_work) + abs(energy.spring_change) + energy.dissipated
    assert energy.dissipated > 0.2 * exchanged
    assert abs(energy.residual) <= 1e-10 * exchanged


def test_hinges_bear_no_moment_but_that_of_their_own_elements(pendulum: Mechanism) -> None:
    """Forces between points pass the joints by: both springs and the damper are what is left."""
    solution = sprung.swing(pendulum, 0.5)
    t = np.array([0.1, 0.31, 0.44])
    joints = solution.trajectory.reactions(t).joints
    (turn, _), (lower, rate) = (sprung.moved(solution, t, joint) for joint in ("turn", "lower"))
    table = pendulum.tabulated_springs[0].characteristic
    expected = {
        "turn": 3.0 * (math.radians(20.0) + turn),
        "lower": table.forces(lower) + 0.2 * rate,
    }
    for joint, moment in expected.items():
        np.testing.assert_allclose(joints[joint][:, 2], -moment, rtol=0.0, atol=1e-10)
        assert np.abs(joints[joint][:, :2]).min() > 1.0
