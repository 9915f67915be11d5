"""Stated errors against true ones, for the certified transitions at many tolerances."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

import nipper_pin as nip

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "scripts/maintain/measure"))

from stated_errors.ratios import judged
from stated_errors.truth import Trial, solved, trial

extended_only = pytest.mark.skipif(
    np.finfo(np.longdouble).eps > 1e-18, reason="numpy.longdouble has no 80 bits on this machine"
)

# Speed, restitution of the jaw and stiffness of the certified transitions.
CERTIFIED = (
    (450.0, 0.2, 9000.0), (550.0, 0.2, 9000.0), (650.0, 0.2, 9000.0), (650.0, 0.05, 9000.0),
    (650.0, 0.25, 9000.0), (650.0, 0.5, 9000.0), (650.0, 0.2, 7000.0), (650.0, 0.2, 11000.0),
)  # fmt: skip


@pytest.mark.campaign
@extended_only
@pytest.mark.parametrize("tolerance", [1e-4, 1e-6, 1e-8, 1e-10, 1e-12])
def test_true_errors_are_at_most_the_stated_ones(
    monkeypatch: pytest.MonkeyPatch, tolerance: float
) -> None:
    """Over eight decades of tolerance, for the certified transitions and both engines.

    The stated errors come from the run itself; the true ones from a solution that shares nothing
    with it.
    """
    monkeypatch.setattr("stated_errors.ratios.TOLERANCES", (tolerance,))
    kinds: dict[str, list[float]] = {"time": [], "impulse": []}
    for speed, e, k in CERTIFIED:
        for row in judged(solved(Trial(0, False, speed, e, 0.2, k, 11.0, 166.0)))["rows"]:
            kinds.setdefault(row[2].split()[0], []).append(row[-1])
    for found in kinds.values():
        assert max(found) <= 1.0
    assert min(np.median(kinds["time"]), np.median(kinds["impulse"])) > 3e-3


# Medians of true over stated errors of the 20 random machines below. Kernels of BLAS change them by
# less than a fifth; a factor of 2.5 detects stated errors that are wrong by a factor of three.
MEDIANS = {
    ("direct", "transition", "time of a collision"): 0.034,
    ("direct", "transition", "approach rate"): 0.0165,
    ("direct", "transition", "impulse"): 0.016,
    ("direct", "transition", "amplitude"): 0.0103,
    ("direct", "transition", "time of a rebound"): 0.017,
    ("direct", "transition", "time of a rest"): 0.017,
    ("direct", "turn", "time of a collision"): 0.024,
    ("direct", "turn", "approach rate"): 0.0165,
    ("direct", "turn", "impulse"): 0.016,
    ("direct", "turn", "time of a rest"): 0.02,
    ("reduced", "transition", "time of a collision"): 0.021,
    ("reduced", "transition", "approach rate"): 0.0104,
    ("reduced", "transition", "impulse"): 0.026,
    ("reduced", "transition", "amplitude"): 0.0145,
    ("reduced", "transition", "time of a rebound"): 0.013,
    ("reduced", "transition", "time of a rest"): 0.022,
}
_WITHIN = 2.5


@pytest.fixture(scope="module")
def measured() -> dict[tuple[str, str, str], list[float]]:
    """True over stated errors of 20 random machines, all tolerances together."""
    found: dict[tuple[str, str, str], list[float]] = {}
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("stated_errors.ratios.TOLERANCES", (1e-4, 1e-7, 1e-10))
        for number in range(20):
            rows = judged(solved(trial(7, number)))["rows"]
            for engine, window, what, _, ratio in rows:
                found.setdefault((engine, window, what), []).append(ratio)
    return found


@pytest.mark.campaign
@extended_only
@pytest.mark.parametrize("key", MEDIANS)
def test_of_random_machines_too_and_not_because_the_statement_is_idle(
    measured: dict[tuple[str, str, str], list[float]], key: tuple[str, str, str]
) -> None:
    """Against the 80-bit solution: a bound on all, and one on both sides of the median."""
    assert len(measured[key]) >= 30
    assert max(measured[key]) <= 1.0
    assert MEDIANS[key] / _WITHIN < np.median(measured[key]) < MEDIANS[key] * _WITHIN


@extended_only
@pytest.mark.sampled(2)
@pytest.mark.parametrize(("number", "tolerance"), [(782, 1e-8), (932, 1e-4), (1844, 1e-8)])
def test_a_stop_that_is_hardly_pressed_shut_rests_when_it_is_stated_to(
    monkeypatch: pytest.MonkeyPatch, number: int, tolerance: float
) -> None:
    """Three machines whose steeve slows down three times less at its rest than when it lands.

    Polynomials of time in the rebound rate agree with one another there, and not with the limit:
    1.04, 2.3 and 3.3 times what was stated. The bound is that of all stated errors.
    """
    monkeypatch.setattr("stated_errors.ratios.TOLERANCES", (tolerance,))
    rows = judged(solved(trial(19, number)))["rows"]
    rests = [row[-1] for row in rows if row[2] == "time of a rest"]
    assert rests
    assert max(rests) <= 1.0


@extended_only
@pytest.mark.parametrize("number", [461, 545])
def test_of_a_slow_series_and_of_a_flight_from_a_release(
    monkeypatch: pytest.MonkeyPatch, number: int
) -> None:
    """Two machines of which the reduced engine stated too little: the rest 1.4 times, a rate 1.8.

    Extrapolations of six bounces agreed by chance; and what a flight misses between its nodes acts
    on its last rate the more, the slower that is beside its acceleration.
    """
    monkeypatch.setattr("stated_errors.ratios.TOLERANCES", (1e-6,))
    rows = judged(solved(trial(19, number)))["rows"]
    assert {row[0] for row in rows} == {"direct", "reduced"}
    assert max(row[-1] for row in rows) <= 1.0


def test_the_error_of_a_release_is_that_of_the_force_over_its_slope() -> None:
    """The steeve of the E62-class model lets go at 650 r/min: where a force falls through zero.

    The release depends on nothing but the drives, so runs at any tolerance and number of nodes find
    the same time but for round-off; their spread has to lie within twice what they state, which is
    round-off of closures and forces: more than nothing, and below 1e-12 of the time.
    """
    times, stated = [], []
    for nodes in (12, 16, 20, 24):
        resolution = nip.Resolution(kinematic_nodes=nodes)
        case = nip.Case(speed_rpm=650.0, window=nip.Window.CYCLE, resolution=resolution)
        solution = nip.simulate(nip.load("e62"), case)
        number = next(e.number for e in solution.events if e.kind is nip.EventKind.RELEASE)
        times.append(solution.events[number - 1].t)
        stated.append(solution.errors[number - 1].time)
    assert max(times) - min(times) <= 2.0 * max(stated)
    assert 0.0 < max(stated) < 1e-12 * max(times)


def test_kinematic_phases_forget_the_past(e62: nip.Mechanism) -> None:
    """The first collision of a cycle has an error of round-off only, whatever the tolerance."""
    case = nip.Case(
        speed_rpm=450.0, window=nip.Window.CYCLE, resolution=nip.Resolution(tolerance=1e-5)
    )
    first, _, later, *_ = nip.simulate(e62, case).errors
    assert first.time < min(1e-14, later.time)


def test_copies_of_a_turn_are_as_wrong_as_what_they_are_copies_of() -> None:
    """Four turns, of which three are copies, and the same ones computed.

    A copy has the impulses of the turn it shows, and its times but for round-off of the sum. A turn
    that is computed later is judged for itself: these errors are round-off, which falls in another
    way, with other processors, too, by a third of itself. Later times have more of it, a few dozen
    units; impulses of bounces that become as short as that are up to eight times worse.
    """
    model = nip.load("e62")
    copied, computed = (
        nip.simulate(
            model, nip.Case(speed_rpm=450.0, window=nip.Window.CYCLE, cycles=4, reuse_cycles=reuse)
        )
        for reuse in (True, False)
    )
    assert copied.repeated_from == 1
    assert computed.repeated_from is None
    count = len(copied.events) // 4
    assert len(copied.errors) == len(computed.errors) == 4 * count > 40
    for number, (one, two) in enumerate(zip(copied.errors, computed.errors, strict=True)):
        first, event = copied.errors[number % count], copied.events[number]
        assert one.impulse == first.impulse
        assert first.time <= one.time <= first.time + 1e-15 * event.t
        clock = 32.0 * np.finfo(float).eps * event.t
        assert 0.75 * one.time <= two.time <= 1.33 * one.time + clock
        assert 0.75 * one.impulse <= two.impulse <= 8.0 * one.impulse


@extended_only
@pytest.mark.parametrize("degrees", [pytest.param(115.582, marks=pytest.mark.slow), 115.6, 117.0])
def test_a_jaw_that_touches_slowly_has_the_round_off_of_fast_drives(degrees: float) -> None:
    """Near the extreme of the pendulum all rates pass through zero, and their round-off does not.

    A round-off that is taken relative to the rate alone is 80 to 20,000 times too small here.
    """
    one = Trial(0, False, 650.0, 0.2, 0.2, 9000.0, 11.0, degrees)
    rows = judged(solved(one))["rows"]
    assert {row[0] for row in rows} == {"direct", "reduced"}
    assert max(row[-1] for row in rows) <= 1.0
    rates = [row[-1] for row in rows if row[2] == "approach rate"]
    assert max(rates) > 1e-3


@pytest.mark.parametrize("engine", ["direct", "reduced"])
def test_the_first_collision_is_as_wrong_as_the_rate_before_it(engine: str) -> None:
    """Its round-off is that of the approach: the restitution has no part in it."""
    impulse, rate = [], []
    for restitution in (0.02, 0.5):
        values = {"speed_rpm": 650.0, "restitution": restitution}
        table = nip.transition_table(nip.load("e62"), **values, engine=engine)
        rate.append(table.rate_error[0, 0] / abs(table.approach_rate[0, 0]))
        impulse.append(table.impulse_error[0, 0] / table.impulse[0, 0])
    assert rate[0] == pytest.approx(rate[1], rel=1e-12)
    assert min(rate) > 8.0 * np.finfo(float).eps
    assert impulse[0] == pytest.approx(impulse[1], rel=1e-12)
    assert min(impulse) > 8.0 * np.finfo(float).eps
