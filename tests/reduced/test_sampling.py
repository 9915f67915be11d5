"""The sampled functions against Pinocchio's constrained dynamics, which uses no null direction."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.polynomial import chebyshev

from nipper_pin import Case, Mechanism, load, simulate
from nipper_pin.arrays import FloatArray
from nipper_pin.dynamics import ShaftMotion, System
from nipper_pin.reduced import ReducedModel, build, transition

MODELS = Path(__file__).parents[1] / "verification" / "models"


def functions(model: ReducedModel, u: float, x: float) -> FloatArray:
    """F0, F1, F2, Fg, F_k and F_k s_k by numpy's own evaluation of Chebyshev series."""
    width = model.travel_rad / model.cells
    cell = min(int(u / width), model.cells - 1)
    place = 2.0 * (u - cell * width) / width - 1.0
    across = (2.0 * x - model.gap_low - model.gap_max) / (model.gap_max - model.gap_low)
    return np.array([chebyshev.chebval2d(place, across, table[cell]) for table in model.equation])


@pytest.mark.parametrize("speed", [30.0, 47.0, 68.0])
def test_acceleration_of_a_flight(model: ReducedModel, e62: Mechanism, speed: float) -> None:
    """x'' of the tables is that of constrained dynamics at states of a real motion.

    The states come from a simulated transition, so psi, x and x' vary together, and the reference
    solves the whole system with closures; a wrong sign of any function shows at one of the speeds.
    The tables promise 1e-11 of x''.
    """
    solution = simulate(e62, Case(speed_rpm=speed * 30.0 / np.pi))
    times = np.linspace(0.0, 0.98 * solution.transitions[0].duration, 25)
    motion = solution.trajectory.evaluate(times)
    system = System(e62, ShaftMotion(e62, speed, e62.cylinder.angle_at_touch_rad))
    a = system.accelerations(
        system.shaft.driven(times), motion.q, motion.v, system.constraint_set(frozenset())
    )
    jaw = e62.stop("jaw").index
    for row, t in enumerate(times):
        x, v = motion.q[row, jaw], motion.v[row, jaw]
        f0, f1, f2, fg, unit, moved = functions(model, speed * t, x)
        found = f0 * speed**2 + f1 * speed * v + f2 * v**2 + fg
        found += model.stiffness[0] * (unit * model.preload[0] + moved)
        assert found == pytest.approx(a[row, jaw], rel=2e-11)


def test_stated_residual(model: ReducedModel, e62: Mechanism) -> None:
    """Off the grid no function errs by more than is stated, at points that the build has not seen.

    Points of a finer model are the truth: its tables have other nodes, and twice the degrees.
    """
    fine = build(e62, tolerance=1e-13, gap_max=1.01 * model.gap_max, travel_rad=2.2)
    random = np.random.default_rng(11)
    for u, x in zip(
        random.uniform(0.0, model.travel_rad, 200),
        random.uniform(model.gap_low, model.gap_max, 200),
        strict=True,
    ):
        error = np.abs(functions(model, u, x) - functions(fine, u, x))
        assert (error <= model.residual + fine.residual).all()
    # The bound says something: below the part of x'' that the tables are asked for.
    weights = np.array([68.0**2, 68.0 * 4.0, 4.0**2, 1.0, 9000.0 * 0.011, 9000.0])
    assert (model.residual * weights < 1e-8).all()


def test_spring_force_is_the_slope_of_its_stroke(model: ReducedModel) -> None:
    """C F_k = -ds/dx: the generalised force of a spring is minus the slope of its potential.

    F_k and C come from inverse dynamics, the stroke s from closing the loops, and the slope is the
    exact derivative of its series, so the functions share nothing but the mechanism.
    """
    span = model.gap_max - model.gap_low
    across = -(model.gap_low + model.gap_max) / span
    for cell in range(model.cells):
        for place in (-0.9, 0.1, 0.8):
            slope = chebyshev.chebder(model.gaps[0, cell], axis=1)
            slope_x = 2.0 / span * chebyshev.chebval2d(place, across, slope)
            inertia = chebyshev.chebval(place, model.inertia[cell])
            force = chebyshev.chebval2d(place, across, model.equation[4, cell])
            # A derivative of a series of degree n loses up to n^2 of its accuracy of 1e-11.
            assert force * inertia == pytest.approx(-slope_x, rel=1e-9)


def test_bouncing_mass() -> None:
    """A mass on a table that rises steadily: w_n = e^n w_0, T_n = 2 w_n / g, A_n = w_n^2 / (2 g).

    With constant gravity the closed form holds for every bounce, and rest comes at the sum of the
    series, 2 e w_0 / (g (1 - e)). Another gravity and restitution than the file's are asked for.
    """
    model = build(load(MODELS / "bouncing_mass"), travel_rad=3.0)
    w0, e, g = 1.5, 0.4, 12.0
    found = transition(model, speed_rpm=60.0, restitution=e, gravity=g, tolerance=1e-12)
    w = w0 * e ** np.arange(1, found.collisions + 1)
    np.testing.assert_allclose(found.separation_rate, w, rtol=1e-12)
    np.testing.assert_allclose(found.rebound_time, 2.0 * w / g, rtol=1e-12)
    np.testing.assert_allclose(found.rebound_amplitude, w**2 / (2.0 * g), rtol=1e-12)
    assert found.duration == pytest.approx(2.0 * e * w0 / (g * (1.0 - e)), rel=1e-12)


def test_upside_down_with_gravity_upwards_nothing_differs(tmp_path: Path) -> None:
    """Neither the motion nor what is stated of its errors: only signs change, and no rounding."""
    source, turned = MODELS / "bouncing_mass", tmp_path / "bouncing_mass"
    turned.mkdir()
    for file in source.iterdir():
        text = file.read_text(encoding="utf-8")
        if file.suffix == ".urdf":
            assert text.count('axis xyz="0 0 1"') == 3
            text = text.replace('axis xyz="0 0 1"', 'axis xyz="0 0 -1"')
        (turned / file.name).write_text(text, encoding="utf-8")
    up, down = (
        transition(
            build(load(folder), travel_rad=3.0, gap_max=0.05),
            speed_rpm=60.0, restitution=0.4, gravity=gravity, tolerance=1e-12,
        )
        for folder, gravity in ((source, 12.0), (turned, -12.0))
    )  # fmt: skip
    assert up.collisions == down.collisions
    for name in ("time", "rate", "impulse", "amplitude", "rebound"):
        stated = getattr(up, f"{name}_error")
        assert stated[1] > 0.0
        np.testing.assert_allclose(getattr(down, f"{name}_error"), stated, rtol=1e-6)
    assert down.duration == pytest.approx(up.duration, rel=1e-12)
    assert down.duration_error == pytest.approx(up.duration_error, rel=1e-6)


def test_same_model_every_time(model: ReducedModel, e62: Mechanism) -> None:
    """Building twice gives the same bits."""
    again = build(e62)
    for name in ("equation", "gaps", "inertia", "residual"):
        assert np.array_equal(getattr(again, name), getattr(model, name))
