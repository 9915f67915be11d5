"""Transitions of the reduced model against two solutions that share none of its compiled code.

The certified reference has its own derivation and integrator; the direct engine calls Pinocchio
at every node. Tolerances: the tables are accurate to 1e-11 of x'', flights to 1e-12 here, and a
time, a rate or an amplitude of a ballistic flight is proportional to a power -1 to 1 of x''.
Bounces amplify rates by less than 3, and late collisions lose digits of their rate as in the
direct engine (its test has the argument), so 1e-10 of the rates and 1e-11 of the rest is allowed.
Agreement to that many digits is no accident: a wrong function, sign or event changes the first
ones.
"""

from __future__ import annotations

import pickle
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from nipper_pin import Case, Mechanism, Resolution, load, simulate
from nipper_pin.reduced import ReducedModel, Status, build, transition, transitions

CASES = ["450", "550", "650", "650_e0.05", "650_e0.25", "650_e0.5", "650_k7000", "650_k11000"]
FINE = 1e-12
# Relative errors below this are luck, not accuracy.
LUCK = 16.0 * 2.220446049250313e-16
# Of rows of the reference: their names, and those of what is stated of their errors.
BOUNDS = {
    "time_s": ("time", "time_error"),
    "approach_rate": ("approach_rate", "rate_error"),
    "impulse_lip_N_s": ("impulse", "impulse_error"),
    "rebound_amplitude": ("rebound_amplitude", "amplitude_error"),
    "rebound_time_s": ("rebound_time", "rebound_error"),
}


def arguments(case: dict[str, Any]) -> dict[str, float]:
    changes = {key: float(value) for key, value in case["changes"].items()}
    names = {"jaw_restitution": "restitution", "stiffness_N_per_m": "stiffness"}
    return {names.get(key, key): value for key, value in changes.items()}


@pytest.mark.parametrize("name", CASES)
def test_certified_reference(model: ReducedModel, reference: dict[str, Any], name: str) -> None:
    """Collision times, rates, impulses, energies, rebounds and rest agree with the reference."""
    case = reference[name]
    found = transition(model, **arguments(case), tolerance=FINE)
    assert found.duration == pytest.approx(float(case["rest_time_s"]), rel=1e-11)
    assert found.engine == "reduced"
    count = min(found.collisions, len(case["collisions"]))
    assert count >= 5
    rows = case["collisions"][:count]
    for key, got, rel in (
        ("time_s", found.time, 1e-11),
        ("cylinder_angle_rad", found.cylinder_angle, 1e-11),
        ("approach_rate", found.approach_rate, 1e-10),
        ("separation_rate", found.separation_rate, 1e-10),
        ("impulse_lip_N_s", found.impulse, 1e-10),
        ("energy_lost_J", found.energy_lost, 2e-10),
        ("rebound_amplitude", found.rebound_amplitude, 2e-10),
        ("rebound_time_s", found.rebound_time, 1e-10),
    ):
        expected = np.array([float(row[key]) for row in rows])
        np.testing.assert_allclose(got[:count], expected, rtol=rel, atol=0.0, err_msg=key)


@pytest.mark.parametrize("tolerance", [1e-6, 1e-8, 1e-10, 1e-12])
@pytest.mark.parametrize("name", CASES)
def test_stated_bound(
    model: ReducedModel, reference: dict[str, Any], name: str, tolerance: float
) -> None:
    """No true error exceeds its bound, over six decades of tolerance, and no bound is empty.

    In no certified case is the bound a thousand times the true worst of four. A true error below 16
    units of round-off is luck: it counts as that. A single quantity may cross zero, the worst of
    four seldom does; measured ratios lie between 20 and 400.
    """
    case = reference[name]
    rows = case["collisions"]
    found = transition(model, **arguments(case), tolerance=tolerance)
    count = min(found.collisions, len(rows))
    for key, (name, stated) in BOUNDS.items():
        got, bound = getattr(found, name), getattr(found, stated)
        expected = np.array([float(row[key]) for row in rows[:count]])
        # Numbers of the reference are rounded to doubles: half a unit in the last place.
        error = np.abs(got[:count] - expected) - 2e-16 * np.abs(expected)
        assert (error <= bound[:count]).all(), key
    rest = float(case["rest_time_s"])
    assert abs(found.duration - rest) <= found.duration_error
    worst = max(
        abs(found.duration / rest - 1.0),
        abs(found.rebound_amplitude[0] / float(rows[0]["rebound_amplitude"]) - 1.0),
        *(abs(found.rebound_time[i] / float(rows[i]["rebound_time_s"]) - 1.0) for i in (0, 1)),
    )
    assert worst <= found.error_bound < 1e3 * max(worst, LUCK)


def drawn(seed: int, count: int, **spans: tuple[float, float]) -> dict[str, Any]:
    random = np.random.default_rng(seed)
    return {key: random.uniform(*span, count) for key, span in spans.items()}


@pytest.mark.parametrize("tolerance", [1e-4, 1e-7, 1e-10])
def test_stated_bound_on_random_parameters(
    model: ReducedModel, fine: ReducedModel, tolerance: float
) -> None:
    """In 500 random cases no error exceeds its bound, from the tightest to the loosest tolerance.

    The truth is another, finer table solved to 1e-13: its own bounds, added here, are far below.
    The bounds are not empty: in 19 of 20 cases the bound is within 1e3 times the worst of four
    (measured: within 300 times). The others are right by luck, as where errors cross zero.
    """
    cases = drawn(5, 500, speed_rpm=(300.0, 700.0), restitution=(0.02, 0.5),
                  stiffness=(7000.0, 13000.0), preload=(0.009, 0.015))  # fmt: skip
    true = transitions(fine, tolerance=1e-13, **cases)
    found = transitions(model, tolerance=tolerance, **cases)
    rest = (true.status == Status.AT_REST) & (found.status == Status.AT_REST)
    assert rest.sum() > 450
    for key, bound in (("duration", "duration_error"), *BOUNDS.values()):
        error = np.abs(getattr(found, key) - getattr(true, key))[rest]
        stated = (getattr(found, bound) + getattr(true, bound))[rest]
        # Collisions that only one of the two has computed are NaN.
        assert not (error > stated).any(), key
    worst = np.maximum.reduce([
        np.abs(found.duration / true.duration - 1.0)[rest],
        np.abs(found.rebound_amplitude / true.rebound_amplitude - 1.0)[rest, 0],
        *np.abs(found.rebound_time / true.rebound_time - 1.0)[rest, :2].T,
    ])  # fmt: skip
    ratio = found.error_bound[rest] / np.maximum(worst, LUCK)
    assert ratio.min() >= 1.0
    assert np.quantile(ratio, 0.95) < 1e3


@pytest.mark.parametrize("tolerance", [1e-3, 1e-5, 1e-7])
def test_stated_bound_of_the_limit(
    model: ReducedModel, fine: ReducedModel, tolerance: float
) -> None:
    """Near the speed that lifts the jaw off, where a limit is hardest to know, its bound holds.

    There x'' changes by its own size during the bounces, so that extrapolations agree by chance: a
    bound from their difference alone is exceeded twelve times in this range.
    """
    cases = drawn(6, 2000, speed_rpm=(700.0, 800.0), restitution=(0.25, 0.45),
                  stiffness=(5000.0, 16000.0), preload=(0.006, 0.02))  # fmt: skip
    true = transitions(fine, tolerance=1e-13, **cases)
    found = transitions(model, tolerance=tolerance, **cases)
    rest = (true.status == Status.AT_REST) & (found.status == Status.AT_REST)
    assert rest.sum() > 800
    error = np.abs(found.duration - true.duration)[rest]
    assert (error <= (found.duration_error + true.duration_error)[rest]).all()


def test_direct_engine_on_random_parameters(model: ReducedModel) -> None:
    """Speed, restitution and spring at random: the direct engine finds the same motion."""
    random = np.random.default_rng(7)
    for _ in range(6):
        speed, e = random.uniform(380.0, 680.0), random.uniform(0.05, 0.4)
        k, p = random.uniform(8000.0, 12000.0), random.uniform(0.010, 0.014)
        mechanism = load(
            "e62",
            {
                "stops.jaw.restitution": e,
                "springs.steeve.stiffness_N_per_m": k,
                "springs.steeve.preload_length_mm": 1e3 * p,
            },
        )
        case = Case(speed_rpm=speed, resolution=Resolution(tolerance=FINE))
        direct = simulate(mechanism, case)
        found = transition(
            model, speed_rpm=speed, restitution=e, stiffness=k, preload=p, tolerance=FINE
        )
        assert found.duration == pytest.approx(direct.transitions[0].duration, rel=1e-10)
        assert found.share == pytest.approx(direct.transitions[0].first_two_share, rel=1e-10)
        for collision in direct.collisions[:5]:
            i = collision.number - 1
            assert found.impulse[i] == pytest.approx(collision.impulse, rel=1e-9)
            assert found.rebound_time[i] == pytest.approx(collision.rebound_time, rel=1e-9)
            height = pytest.approx(collision.rebound_amplitude, rel=1e-9)
            assert found.rebound_amplitude[i] == height


def test_other_masses() -> None:
    """A mechanism with a heavier jaw has another model, and it agrees with the direct engine."""
    mechanism = load("e62", {"links.top_nipper.mass_kg": 1.5, "stops.steeve.restitution": 0.1})
    direct = simulate(mechanism, Case(speed_rpm=500.0)).transitions[0]
    found = transition(build(mechanism), speed_rpm=500.0, tolerance=FINE)
    assert found.duration == pytest.approx(direct.duration, rel=1e-10)
    standard = transition(build(load("e62")), speed_rpm=500.0)
    assert abs(standard.duration / direct.duration - 1.0) > 1e-2


def test_rest_by_threshold(model: ReducedModel, e62: Mechanism) -> None:
    """With a threshold the transition ends at the same collision as in the direct engine."""
    direct = simulate(e62, Case(speed_rpm=600.0, rest_rate=1e-2)).transitions[0]
    found = transition(model, speed_rpm=600.0, rest_rate=1e-2)
    assert found.collisions == direct.collisions
    assert found.duration == pytest.approx(direct.duration, rel=1e-9)
    assert found.separation_rate[-1] < 1e-2 <= found.separation_rate[-2]


@pytest.mark.parametrize("assumed", [True, False])
def test_batch_equals_single(model: ReducedModel, assumed: bool) -> None:
    """A case gives the same bits alone and among others, whatever was computed before it."""
    cases = drawn(5, 8, speed_rpm=(600.0, 690.0), restitution=(0.02, 0.3),
                  stiffness=(7000.0, 9000.0), preload=(0.0085, 0.0105))  # fmt: skip
    batch = transitions(model, assumed=assumed, **cases)
    assert (batch.status == Status.AT_REST).all()
    assert len(np.unique(batch.duration)) == 8
    assert set(batch.premise) == {0, 1}
    for i in range(8):
        one = transition(model, assumed=assumed, **{key: row[i] for key, row in cases.items()})
        assert one.premise_holds is bool(batch.premise[i])
        for name in ("collisions", "duration", "duration_error", "share", "error_bound"):
            assert getattr(one, name) == getattr(batch, name)[i], name
        np.testing.assert_array_equal(one.table, batch.table[i, :, : one.collisions])
        assert np.isnan(batch.table[i, :, one.collisions :]).all()


def test_threads(model: ReducedModel) -> None:
    """Calls from several threads give the bits of calls from one: nothing is shared in a run."""
    speeds = np.random.default_rng(4).uniform(400.0, 650.0, 200).tolist()

    def solve(speed: float) -> bytes:
        return transition(model, speed_rpm=speed).table.tobytes()

    with ThreadPoolExecutor(4) as pool:
        found = list(pool.map(solve, speeds))
    assert found == [solve(speed) for speed in speeds]
    assert len(set(found)) == len(speeds)


def test_worker_process(model: ReducedModel, tmp_path: Path) -> None:
    """A pickled model gives the same bits in a process that never loads Pinocchio's model."""
    file = tmp_path / "model.pickle"
    file.write_bytes(pickle.dumps(model))
    program = (
        "import pickle, sys\n"
        "from nipper_pin.reduced import transition\n"
        "model = pickle.load(open(sys.argv[1], 'rb'))\n"
        "print(transition(model, speed_rpm=520.0).duration.hex())\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", program, str(file)], capture_output=True, text=True, check=True
    )
    assert done.stdout.strip() == transition(model, speed_rpm=520.0).duration.hex()


@pytest.mark.slow
def test_a_model_of_another_gravity_has_that_gravity() -> None:
    """The direct engine says the same, to 1e-10."""
    mars, earth = (load("e62", {"gravity_m_s2": gravity}) for gravity in (3.7, 9.81))
    less, more = (
        simulate(machine, Case(speed_rpm=650.0)).transitions[0].duration
        for machine in (mars, earth)
    )
    assert abs(less / more - 1.0) > 1e-6
    for machine, true in ((mars, less), (earth, more)):
        found = transition(build(machine), speed_rpm=650.0, tolerance=FINE)
        assert found.duration == pytest.approx(true, rel=1e-9)
