"""Rows of work against precision, of either engine and of peers, with a clock that is made up."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from made_up_clock import Clock

from benchmarks.run_time import reduced_work, work_precision
from benchmarks.run_time.certified import Certified, certified
from benchmarks.run_time.timing import Timing
from benchmarks.run_time.work_precision import Observed, Row, graded, observe
from nipper_pin import Case, Mechanism, Resolution, simulate
from nipper_pin.hybrid.result.solution import Solution
from nipper_pin.hybrid.result.tables import Collision


@pytest.fixture(name="clock")
def made_up_clock(monkeypatch: pytest.MonkeyPatch) -> Clock:
    found = Clock()
    for module in (reduced_work, work_precision):
        monkeypatch.setattr(module, "timed", found.timed)
    return found


@pytest.fixture(name="reference", scope="module")
def certified_transition() -> Certified:
    return certified()


def of_the_clock(row: Row, median_ms: float, runs: int, share: float = 1.0) -> None:
    """The four times of a row are those of one measurement, or a share of them."""
    times = (row.first_ms, row.wall_ms, row.fastest_ms, row.spread_ms)
    wanted = (100.0 + median_ms, median_ms, median_ms / 8.0, median_ms / 64.0)
    assert times == pytest.approx([share * item for item in wanted])
    assert row.runs == runs


def test_each_error_is_that_of_its_quantity(reference: Certified) -> None:
    """Every list is off by a factor of its own, one more in a single place; the worst is told."""
    count = 5
    times = reference.times[:count] * (1.0 + 1e-6)
    times[2] *= 1.0 + 1e-5
    impulses = reference.impulses[:count] * (1.0 - 2e-4)
    amplitudes = reference.amplitudes[:count] * (1.0 + 3e-4)
    amplitudes[3] *= 1.0 - 1e-2
    observed = Observed(times, impulses, amplitudes, reference.transition_time * (1.0 - 4e-3), 17)
    row = graded("one", "1e-3", Timing(100.0, 8.0, 1.0, 0.125, 9), observed, reference)
    of_the_clock(replace(row, first_ms=108.0), 8.0, 9)
    assert (row.engine, row.setting, row.first_ms, row.evaluations) == ("one", "1e-3", 100.0, 17)
    assert row.error_times == pytest.approx((1.0 + 1e-6) * (1.0 + 1e-5) - 1.0, rel=1e-6)
    assert row.error_impulses == pytest.approx(2e-4, rel=1e-9)
    assert row.error_amplitudes == pytest.approx(1.0 - (1.0 + 3e-4) * (1.0 - 1e-2), rel=1e-9)
    assert row.error_duration == pytest.approx(4e-3, rel=1e-9)
    assert row.error_worst == pytest.approx(4e-3, rel=1e-9)
    assert row.error_trajectory is None
    assert row.version is None


def test_what_is_observed_of_a_run(e62: Mechanism) -> None:
    """Times count from the first collision; motion is that of the jaw at these times."""
    run = simulate(e62, Case(speed_rpm=650.0))
    seen = observe(run)
    hits = [event for event in run.events if event.kind.value == "collision"]
    assert seen.times == pytest.approx([event.t - hits[0].t for event in hits], abs=1e-18)
    assert seen.impulses.tolist() == [item.impulse for item in run.collisions]
    assert seen.amplitudes.tolist() == [item.rebound_amplitude for item in run.collisions]
    assert seen.transition_time == run.events[-1].t - hits[0].t
    assert seen.evaluations == run.evaluations
    assert seen.motion is not None
    jaw = e62.stop("jaw").index
    left, right = (seen.motion(seen.times[1:2], side)[1][0] for side in (True, False))
    assert left == pytest.approx(hits[1].v_before[jaw], rel=1e-9)
    assert right == pytest.approx(hits[1].v_after[jaw], rel=1e-9)
    times = 0.5 * (seen.times[:-1] + seen.times[1:])
    gaps, rates = seen.motion(times, False)
    found = run.trajectory.evaluate(times + hits[0].t)
    assert gaps == pytest.approx(found.q[:, jaw], abs=1e-15)
    assert rates == pytest.approx(found.v[:, jaw], abs=1e-12)


def test_a_motion_that_is_too_fast(reference: Certified) -> None:
    """Rates too high by 1e-4 of the first separation rate, and nothing else, have that error."""

    def motion(t: np.ndarray, left: bool) -> tuple[np.ndarray, np.ndarray]:
        place = int(np.searchsorted(reference.times, t[0] + (-1e-9 if left else 1e-9))) - 1
        flight = reference.flights[place]
        gap = np.interp(t, flight.start_s + flight.fractions * flight.duration_s, flight.gap)
        rate = np.interp(t, flight.start_s + flight.fractions * flight.duration_s, flight.rate)
        return gap, rate + 1e-4 * reference.separation_rate

    observed = Observed(
        reference.times[:3], reference.impulses[:3], reference.amplitudes[:3],
        reference.transition_time, None, motion,
    )  # fmt: skip
    error = work_precision.trajectory_error(observed, reference)
    assert error == pytest.approx(1e-4, rel=1e-3)
    assert work_precision.trajectory_error(observed, replace(reference, flights=())) is None


@pytest.mark.parametrize("quick", [True, False])
@pytest.mark.usefixtures("clock")
def test_rows_of_the_direct_engine(
    monkeypatch: pytest.MonkeyPatch, reference: Certified, quick: bool
) -> None:
    """Each tolerance of the list; the time includes what is graded, which is found when asked."""
    asked: list[str] = []
    for name in ("rebound_amplitude", "rebound_time"):
        real = getattr(Collision, name)

        def called(self: Collision, real: Any = real, name: str = name) -> Any:
            asked.append(f"{name} {self.number}")
            return real.__get__(self)

        monkeypatch.setattr(Collision, name, property(called))
    transitions = Solution.transitions

    def ended(self: Solution) -> Any:
        asked.append("transitions")
        return transitions.__get__(self)

    monkeypatch.setattr(Solution, "transitions", property(ended))
    monkeypatch.setattr(work_precision, "QUICK_TOLERANCES", (1e-5, 1e-9))
    monkeypatch.setattr(work_precision, "TOLERANCES", (1e-5, 1e-7, 1e-9))
    monkeypatch.setattr(
        work_precision, "observe", lambda run: (asked.append("seen"), observe(run))[1]
    )
    rows = work_precision.direct_rows(reference, quick=quick, repeats=6)
    assert (
        [row.setting for row in rows] == ["1e-05", "1e-09"]
        if quick
        else ["1e-05", "1e-07", "1e-09"]
    )
    before = asked[: asked.index("seen")]
    half = len(before) // 2
    assert before[:half] == before[half:]
    assert set(before) == {
        "rebound_amplitude 1", "rebound_time 1", "rebound_time 2", "transitions",
    }  # fmt: skip
    for number, row in enumerate(rows, 1):
        of_the_clock(row, number, 6)
        assert row.engine == "direct"
        resolution = Resolution(tolerance=float(row.setting))
        run = simulate(reference.mechanism(), Case(speed_rpm=650.0, resolution=resolution))
        assert row.evaluations == run.evaluations
        assert row.error_worst is not None
        assert row.error_worst <= float(row.setting)


def test_accuracy_of_a_case(clock: Clock) -> None:
    case = certified("450")
    row = work_precision.accuracy(case, case.mechanism(), 1e-6)
    of_the_clock(row, 1, 1)
    assert row.setting == "case 450"
    assert len(clock.all[0].result) == row_collisions(case)  # type: ignore[arg-type]
    assert row.error_worst is not None
    assert 1e-13 < row.error_worst < 1e-6


def row_collisions(case: Certified) -> int:
    resolution = Resolution(tolerance=1e-6)
    return len(simulate(case.mechanism(), Case(speed_rpm=450.0, resolution=resolution)).collisions)


@pytest.mark.parametrize("quick", [True, False])
def test_rows_of_the_reduced_engine(
    clock: Clock, monkeypatch: pytest.MonkeyPatch, reference: Certified, quick: bool
) -> None:
    """Singly and in a batch, times of a case, and the figures of the engine's own tolerance."""
    import nipper_pin.reduced as engine

    for name in ("build", "transition", "transitions"):
        clock.watch(monkeypatch, reduced_work, name)
    monkeypatch.setattr(reduced_work, "_BATCH", 40)
    monkeypatch.setattr(reduced_work, "_QUICK_BATCH", 20)
    rows, summary = reduced_work.reduced_work(reference, quick=quick, repeats=3)
    tolerances = [1e-4, 1e-6, 1e-8, 1e-10, 1e-12]
    assert [row.engine for row in rows] == ["reduced"] * 5 + ["reduced, batch"] * 5
    assert [float(row.setting) for row in rows] == tolerances * 2
    building, *measured, last = clock.all
    assert [item[0] for item in building.calls] == ["build"]
    budget = building.budget_s
    assert {item.budget_s for item in clock.all} == {budget}
    for place, tolerance in enumerate(tolerances):
        single, batch = measured[2 * place], measured[2 * place + 1]
        ((name, _, given),) = single.calls
        assert (name, given) == ("transition", {"speed_rpm": 650.0, "tolerance": tolerance})
        ((name, _, given),) = batch.calls
        assert (name, given["tolerance"]) == ("transitions", tolerance)
        assert (given["speed_rpm"] == 650.0).all()
        assert (single.repeats, batch.repeats) == (300, 3)
        of_the_clock(rows[place], single.number, 300)
        of_the_clock(rows[place + 5], batch.number, 3, share=1.0 / len(given["speed_rpm"]))
        found = engine.transition(
            engine.build(reference.mechanism()), speed_rpm=650.0, tolerance=tolerance
        )
        duration = abs(found.duration / reference.transition_time - 1.0)
        assert rows[place].error_duration == rows[place + 5].error_duration == duration
        assert rows[place].error_times is not None
        assert rows[place].error_times < 100.0 * tolerance
        assert rows[place].error_impulses == pytest.approx(
            np.abs(found.impulse / reference.impulses[: len(found.impulse)] - 1.0).max(), abs=1e-15
        )
        assert rows[place].error_amplitudes is not None
        assert rows[place].error_amplitudes < 100.0 * tolerance
        if tolerance == 1e-10:
            assert summary["transition_ms"] == float(single.number)
            assert summary["transition_in_batch_ms"] == rows[place + 5].wall_ms
            assert summary["error"] == rows[place].error_worst
            assert summary["stated_error"] == found.error_bound
    assert (summary["build_ms"], summary["build_first_ms"]) == (1.0, 101.0)
    assert summary["first_transition_ms"] == 102.0
    ((name, _, given),) = last.calls
    speeds = given["speed_rpm"]
    assert speeds == pytest.approx(np.linspace(0.98 * 650.0, 1.02 * 650.0, 20 if quick else 40))
    assert summary["batch"] == len(speeds)
    # Number n lasts n ms.
    assert summary["transitions_per_s"] == pytest.approx(len(speeds) / (1e-3 * last.number))
