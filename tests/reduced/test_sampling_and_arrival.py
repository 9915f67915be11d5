"""From a mechanism to its tables: every number of a model by the direct engine, and refusals."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.polynomial import chebyshev
from snapshots import Words
from written_tables import bounded, functions_of, one_of, value, x_dd

from nipper_pin import (
    Case,
    DriveMode,
    InputError,
    Mechanism,
    Resolution,
    Solution,
    load,
    simulate,
)
from nipper_pin.arrays import FloatArray
from nipper_pin.dynamics import ShaftMotion, System
from nipper_pin.mechanism import Stop
from nipper_pin.reduced import (
    ReducedModel,
    build,
    reduced_model,
    transition,
    transitions,
    unfit,
)
from nipper_pin.reduced.kernels import layout
from nipper_pin.reduced.tables.functions import Sampler
from nipper_pin.reduced.turns.arcs import ContactArc
from nipper_pin.reduced.turns.charts import ChartSampler

MODELS = Path(__file__).parents[1] / "verification" / "models"
RPM = 450.0
SPEED = RPM * math.tau / 60.0


@pytest.fixture(scope="module")
def turn(e62: Mechanism) -> Solution:
    case = Case(speed_rpm=RPM, window="cycle", resolution=Resolution(tolerance=1e-12))
    return simulate(e62, case)


@pytest.fixture(scope="module")
def system(e62: Mechanism) -> System:
    return System(e62, ShaftMotion(e62, 1.0, e62.cylinder.angle_at_touch_rad))


def hits(turn: Solution, stop: str) -> Any:
    return next(item for item in turn.collisions if item.stop == stop)


def at_touch(system: System, stop: Stop) -> Sampler:
    return Sampler(system, stop, np.zeros(system.body.nv))


def travel_of(e62: Mechanism, angle: float) -> float:
    cylinder = e62.cylinder
    return float(cylinder.sense * (angle - cylinder.angle_at_touch_rad) % math.tau)


def test_every_number_of_a_model(model: ReducedModel, e62: Mechanism, turn: Solution) -> None:
    """Those of its mechanism, and rate and opening as a simulated turn has them."""
    jaw, numbers = e62.stop("jaw"), model.charts.numbers[0]
    approach = float(numbers[layout.ARRIVE])
    assert (model.name, model.stop, model.springs) == ("e62", "jaw", ("steeve",))
    assert model.touch_angle_rad == e62.cylinder.angle_at_touch_rad
    assert model.sense == -1
    assert model.charts.lever.tolist() == [stop.lever for stop in e62.stops]
    e_N = [stop.restitution for stop in e62.stops]
    assert model.numbers == pytest.approx([0.0, *e_N, 9000.0, 0.011], rel=1e-15)
    assert model.tolerance == 1e-11
    first = hits(turn, "jaw")
    assert approach * SPEED == pytest.approx(first.approach_rate, rel=1e-9)
    assert 0.0 < numbers[layout.ARRIVE_ERROR] < 1e-13
    opening = hits(turn, "steeve")
    assert model.travel_rad == pytest.approx(travel_of(e62, opening.cylinder_angle), abs=1e-12)
    assert -0.1 * model.gap_max < numbers[layout.LOW] < -0.05 * model.gap_max
    # Ballistic from half of the rate at one and a half times the rated speed, and a quarter more.
    rate = 0.5 * 1.5 * approach * SPEED
    fast = System(e62, ShaftMotion(e62, 1.5 * SPEED, e62.cylinder.angle_at_touch_rad))
    q = np.zeros((1, len(e62.joints)))
    sampler = at_touch(fast, e62.stop("jaw"))
    n, m = sampler.rates(np.zeros(1), q)
    a = fast.accelerations(
        fast.shaft.driven(np.zeros(1)), q, m - rate * n, fast.constraint_set(frozenset())
    )
    assert model.gap_max == pytest.approx(1.25 * rate**2 / (2.0 * -a[0, jaw.index]), rel=1e-6)


@pytest.mark.parametrize("waiting", [False, True])
def test_bounds_of_values_and_slopes(model: ReducedModel, waiting: bool) -> None:
    """By another grid: neither of them holds the very worst points, edges are on both."""
    charts = model.charts
    if waiting:
        assert model.arrival.charts is not None
        charts = one_of(model.arrival.charts, 1)
    assert charts.bounds.shape == (1, len(functions_of(charts)), layout.SIZES)
    residual, *found = charts.bounds[0].T
    for row, true in zip(found, bounded(charts).bounds[0].T[1:], strict=True):
        np.testing.assert_allclose(row, true, rtol=5e-2)
    assert (residual > 0.0).all()
    assert (residual < 1e-7 * charts.bounds[0, :, layout.BY_V]).all()
    assert 0.0 < charts.numbers[0, layout.INERTIA_ERROR] < 1e-7


def test_tables_between_opening_and_touch(
    model: ReducedModel, e62: Mechanism, system: System, turn: Solution
) -> None:
    """Where they begin, how far they reach, and the collision that throws the jaw open."""
    charts, steeve = model.arrival.charts, e62.stop("steeve")
    assert charts is not None
    (jaw_numbers, numbers), stops = charts.numbers, charts.stops
    opening = hits(turn, "steeve")
    at = travel_of(e62, opening.cylinder_angle)
    assert (model.arrival.why, model.arrival.asked) == ("", True)
    assert jaw_numbers[layout.TRAVEL_MOST] == numbers[layout.BEGIN] == pytest.approx(at, abs=1e-9)
    assert numbers[layout.TRAVEL_MOST] == pytest.approx(math.tau - at, abs=1e-9)
    rate = jaw_numbers[layout.ARRIVE] * SPEED
    assert rate == pytest.approx(opening.approach_rate, rel=1e-8)
    assert 0.0 < jaw_numbers[layout.ARRIVE_ERROR] < 1e-13
    wrong = numbers[layout.ARRIVE_ERROR]
    approach, rounded = model.charts.numbers[0, [layout.ARRIVE, layout.ARRIVE_ERROR]]
    assert abs(numbers[layout.ARRIVE] - approach) <= wrong + rounded
    assert 0.0 < rounded < wrong < 1e-12
    assert [e62.stops[place].name for place in stops[:, layout.OWN]] == ["jaw", "steeve"]
    assert stops[:, layout.AFTER].tolist() == [1, 0]
    assert charts.lever.tolist() == [stop.lever for stop in e62.stops]
    assert numbers[layout.LOW] == pytest.approx(-numbers[layout.HIGH] / 16.0)
    # As high as the steeve goes with the jaw in the touch configuration.
    n, _ = at_touch(system, e62.stop("jaw")).rates(np.zeros(1), np.zeros((1, len(e62.joints))))
    high = n[0, steeve.index] * model.gap_max
    assert numbers[layout.HIGH] == pytest.approx(high, rel=1e-12)
    assert numbers[layout.THROW] == pytest.approx(n[0, steeve.index], rel=1e-12)


@pytest.mark.parametrize("name", ["jaw", "steeve"])
@pytest.mark.parametrize("share", [0.03, 0.4, 0.77, 0.99])
def test_what_presses_the_stops(
    model: ReducedModel, e62: Mechanism, name: str, share: float
) -> None:
    """x'' at x = x' = 0 while the jaw clamps, y'' at y = y' = 0 while the steeve waits."""
    charts, place, speed = model.arrival.charts, int(name == "steeve"), 50.0
    assert charts is not None
    length = float(charts.numbers[place, layout.TRAVEL_MOST])
    begin = charts.numbers[place, layout.BEGIN] - math.tau * place
    fast = System(e62, ShaftMotion(e62, speed, e62.cylinder.angle_at_touch_rad))
    sampler = at_touch(fast, e62.stop(name))
    u = begin + share * length
    q = sampler.grid(np.array([u / speed]), np.zeros(1))[0]
    _, m = sampler.rates(np.array([u / speed]), q)
    a = fast.accelerations(
        fast.shaft.driven(np.array([u / speed])), q, m, fast.constraint_set(frozenset())
    )
    series, residual = charts.along[place], charts.bounds[place, :, layout.RESIDUAL]
    cells = share * length * float(charts.numbers[place, layout.PER_RAD])
    f = chebyshev.chebval(2.0 * (cells - int(cells)) - 1.0, series[int(cells)].T)
    found = f[0] * speed**2 + f[3] + 9000.0 * (0.011 * f[4] + f[5])
    assert found == pytest.approx(a[0, e62.stop(name).index], rel=1e-7)
    assert ((residual > 0.0) & (residual < 1e-7 * np.abs(f).max())).all()


def test_the_jaw_at_the_touch_by_the_steeve(model: ReducedModel, system: System) -> None:
    """Its coordinate and both derivatives, by differences of closed configurations."""
    assert model.arrival.charts is not None
    charts = one_of(model.arrival.charts, 1)
    high, travel = charts.numbers[0, [layout.HIGH, layout.TRAVEL_MOST]]
    steeve, jaw = (system.mechanism.stop(name) for name in ("steeve", "jaw"))
    sampler = at_touch(system, steeve)
    assert charts.gaps.shape[1] == 3
    assert (charts.gap_bounds < 1e-9).all()
    step = 1e-4
    for y in (0.0, 0.3 * high, 0.9 * high):
        x, by_y, by_u = (value(charts, table, travel, y) for table in charts.gaps[0])
        around = sampler.grid(np.zeros(1), np.array([y - step, y, y + step]))[0, :, jaw.index]
        assert x == pytest.approx(around[1], rel=1e-9, abs=1e-12)
        assert by_y == pytest.approx((around[2] - around[0]) / (2.0 * step), rel=1e-4)
        later, before = (
            sampler.grid(np.array([u]), np.array([y]))[0, 0, jaw.index] for u in (step, -step)
        )
        assert by_u == pytest.approx((later - before) / (2.0 * step), rel=1e-4, abs=1e-7)


def around_touch(e62: Mechanism) -> ChartSampler:
    """The arc of the jaw, of which the touch alone is known."""
    jaw, home = e62.stop("jaw"), np.zeros((1, len(e62.joints)))
    arc = ContactArc(jaw, 0.0, 0.0, jaw, np.zeros(1), home)
    return ChartSampler(e62, arc, e62.cylinder.angle_at_touch_rad, 0)


def test_weights_are_shares_of_the_acceleration(e62: Mechanism) -> None:
    """All terms of x'' at touch together have the size one; a slack spring counts for a hundredth.

    Half of the approach rate at one and a half times the rated speed.
    """
    speed = 1.5 * SPEED
    w = 0.5 * 0.25 * speed
    touch = around_touch(e62).along
    terms = np.array([speed**2, speed * w, w**2, 1.0, 9000.0 * 0.011, 9000.0])
    size = np.abs(terms * touch.equation[:, 0]).sum()
    weights, gap = around_touch(e62).weights(w), around_touch(e62).rebound(w)
    np.testing.assert_allclose(weights, terms / size, rtol=1e-12)
    assert gap == pytest.approx(-1.25 * 0.5 * w**2 / (terms @ touch.equation[:, 0]), rel=1e-12)
    loose = load("e62", {"springs.steeve.preload_length_mm": -11.0})
    np.testing.assert_allclose(around_touch(loose).weights(w), weights, rtol=1e-12)
    slack = load("e62", {"springs.steeve.preload_length_mm": 0.0, "cylinder.rated_speed_rpm": 1.0})
    weights = around_touch(slack).weights(w)
    assert weights[4] * abs(touch.equation[4, 0]) == pytest.approx(0.01, rel=1e-12)


def test_models_are_built_once(e62: Mechanism) -> None:
    """For held drives; with others there is none."""
    assert reduced_model(e62) is reduced_model(e62)
    with pytest.raises(InputError, match="held drives"):
        reduced_model(e62, DriveMode.INERTIAL)
    assert reduced_model(load("e62")) is not reduced_model(e62)


def test_a_domain_without_an_opening_is_a_quarter_of_a_turn() -> None:
    """A mass on a table that rises for ever."""
    model = build(load(MODELS / "bouncing_mass"))
    assert math.radians(90.0) <= model.travel_rad <= math.radians(100.0)
    assert not model.arrival.asked


def test_what_cannot_be_reduced(e62: Mechanism, words: Words) -> None:
    """Each for its reason: other elements and stops, or another number of freedoms in flight."""
    jaw, steeve, spring = e62.stop("jaw"), e62.stop("steeve"), e62.springs[0]
    assert unfit(e62) is None
    # In its third phase all stops are open.
    assert e62.phase(3).closed == frozenset()
    four_bar = load(MODELS / "four_bar")
    machines = {
        "no stop": replace(e62, transition_stop=""),
        "other stop": replace(e62, transition_stop="steeve"),
        "open phase": replace(e62, initial_phase=3),
        "no drives": replace(e62, drives=()),
        "upper stop": replace(e62, stops=(jaw, replace(steeve, sense=-1.0, contact=None))),
        "stop on a drive": replace(e62, stops=(replace(jaw, index=e62.drives[0].index), steeve)),
        "table": replace(e62, tabulated_springs=(replace(spring, name="A"),)),  # type: ignore[arg-type]
        "damper": replace(e62, dampers=(replace(spring, name="A"),)),  # type: ignore[arg-type]
    }
    said = [f"{name}: {unfit(machine)}" for name, machine in machines.items()]
    for machine, drive in ((four_bar, DriveMode.HELD), (e62, DriveMode.INERTIAL)):
        with pytest.raises(InputError) as caught:
            build(machine, drive=drive)
        said.append(str(caught.value))
    for key, values in (
        ("travel_rad", (0.0, -1.0, 6.29, 7.0, math.nan)),
        ("gap_max", (0.0, -0.1, math.inf)),
        ("tolerance", (0.9e-13, 1.1e-3, math.nan)),
    ):
        for wrong in values:
            with pytest.raises(InputError) as caught:
                build(e62, **{key: wrong})  # type: ignore[arg-type]
            found = caught.value.evidence
            assert (found["key"], repr(found["value"])) == (key, repr(wrong))
        said.append(str(caught.value))
    words("\n".join(said) + "\n")


def test_the_rest_of_the_turn_belongs_to_a_domain_that_is_given(
    e62: Mechanism, model: ReducedModel
) -> None:
    """It tells how the machine arrives, as where the domain is found, which ends at the opening."""
    for travel in (0.8 * model.travel_rad, model.travel_rad, 1.1 * model.travel_rad):
        given = build(e62, tolerance=1e-3, travel_rad=travel, gap_max=0.02)
        assert (given.arrival.why, given.arrival.asked) == ("", True)
        assert given.travel_rad == travel
        assert given.arrival.charts is not None
        opening = given.arrival.charts.numbers[0, layout.TRAVEL_MOST]
        assert opening == pytest.approx(model.travel_rad, rel=1e-12)
        assert transitions(given, speed_rpm=[450.0], restitution=0.05).premise.tolist() == [1]


def test_the_coarsest_and_the_longest_domain_can_be(e62: Mechanism) -> None:
    """At their limits tolerances are allowed; what is given is taken."""
    model = build(e62, tolerance=1e-3, travel_rad=1.0, gap_max=0.02)
    assert (model.tolerance, model.travel_rad, model.gap_max) == (1e-3, 1.0, 0.02)
    assert model.charts.numbers[0, layout.LOW] == -0.02 / 16.0
    steepest = bounded(model.charts).bounds[0, :, layout.BY_U]
    assert model.charts.bounds[0, :, layout.BY_U] == pytest.approx(steepest, rel=5e-2)


def test_a_machine_that_opens_at_its_touch_is_refused() -> None:
    """Run the other way round, the jaw moves away; a spring that pulls presses nothing shut."""
    back = load("e62", {"cylinder.direction": "counter-clockwise"})
    with pytest.raises(InputError, match="'jaw' is not closing in the touch configuration") as told:
        build(back)
    assert told.value.evidence["stop"] == "jaw"
    assert told.value.evidence["rate"] == pytest.approx(
        -build(load("e62")).charts.numbers[0, layout.ARRIVE]
    )
    with pytest.raises(InputError, match=r"not pressed shut .* at 1.5 times the rated") as told:
        build(load("e62", {"springs.steeve.preload_length_mm": -60.0}))
    assert told.value.evidence == {"stop": "jaw"}


# Sampled functions against Pinocchio's constrained dynamics, which uses no null direction.


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
        found = x_dd(model.charts, speed * t, x, v, speed, [(9000.0, 0.011)])
        assert found == pytest.approx(a[row, jaw], rel=2e-11)


def residual(model: ReducedModel) -> FloatArray:
    return np.asarray(model.charts.bounds[0, :, layout.RESIDUAL])


def test_stated_residual(model: ReducedModel, fine: ReducedModel) -> None:
    """Off the grid no function errs by more than is stated, at points that the build has not seen.

    Points of a finer model are the truth: its tables have other nodes, and twice the degrees.
    """
    random = np.random.default_rng(11)
    for u, x in zip(
        random.uniform(0.0, model.travel_rad, 200),
        random.uniform(model.charts.numbers[0, layout.LOW], model.gap_max, 200),
        strict=True,
    ):
        error = np.abs([
            value(model.charts, one, u, x) - value(fine.charts, other, u, x)
            for one, other in zip(*map(functions_of, (model.charts, fine.charts)), strict=True)
        ])  # fmt: skip
        assert (error <= residual(model) + residual(fine)).all()
    # The bound says something: below the part of x'' that the tables are asked for.
    weights = np.array([68.0**2, 68.0 * 4.0, 4.0**2, 1.0, 9000.0 * 0.011, 9000.0])
    assert (residual(model) * weights < 1e-8).all()


def test_spring_force_is_the_slope_of_its_stroke(model: ReducedModel) -> None:
    """C F_k = -ds/dx: the generalised force of a spring is minus the slope of its potential.

    F_k and C come from inverse dynamics, the stroke s from closing the loops, and the slope is the
    exact derivative of its series, so the functions share nothing but the mechanism.
    """
    low, high = model.charts.numbers[0, [layout.LOW, layout.HIGH]]
    span, across = high - low, -(low + high) / (high - low)
    for cell in range(model.charts.equation.shape[1]):
        for place in (-0.9, 0.1, 0.8):
            slope = chebyshev.chebder(model.charts.gaps[0, 0, cell], axis=1)
            slope_x = 2.0 / span * chebyshev.chebval2d(place, across, slope)
            inertia = chebyshev.chebval(place, model.charts.inertia[0, cell])
            force = chebyshev.chebval2d(place, across, model.charts.equation[0, cell, :, 4])
            # A derivative of a series of degree n loses up to n^2 of its accuracy of 1e-11.
            assert force * inertia == pytest.approx(-slope_x, rel=1e-9)


def test_bouncing_mass() -> None:
    """A mass on a table that rises steadily: w_n = e^n w_0, T_n = 2 w_n / g, A_n = w_n^2 / (2 g).

    With constant gravity the closed form holds for every bounce, and rest comes at the sum of the
    series, 2 e w_0 / (g (1 - e)). Another restitution than the file's is asked for.
    """
    w0, e, g = 1.5, 0.4, 12.0
    model = build(load(MODELS / "bouncing_mass", {"gravity_m_s2": g}), travel_rad=3.0)
    found = transition(model, speed_rpm=60.0, restitution=e, tolerance=1e-12)
    w = w0 * e ** np.arange(1, found.collisions + 1)
    np.testing.assert_allclose(found.separation_rate, w, rtol=1e-12)
    np.testing.assert_allclose(found.rebound_time, 2.0 * w / g, rtol=1e-12)
    np.testing.assert_allclose(found.rebound_amplitude, w**2 / (2.0 * g), rtol=1e-12)
    assert found.duration == pytest.approx(2.0 * e * w0 / (g * (1.0 - e)), rel=1e-12)


def test_same_model_every_time(model: ReducedModel, e62: Mechanism) -> None:
    """Building twice gives the same bits."""
    again = build(e62)
    for name, found in again.charts._asdict().items():
        assert np.array_equal(found, getattr(model.charts, name)), name
