"""The benchmark measures what it says: its reference, its norms, its scenes, its comparisons.

Nothing here looks at seconds.
"""

from __future__ import annotations

import io
import json
import math
import subprocess
import sys
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from drawn import drawn
from numpy.polynomial import chebyshev
from programs import main
from rich.console import Console
from snapshots import Words

from benchmarks.peers import available
from benchmarks.run_time import timing
from benchmarks.run_time.benchmark import Benchmark
from benchmarks.run_time.certified import Certified, certified, certified_cycle, certified_names
from benchmarks.run_time.cost import four_bar_chain
from benchmarks.run_time.recorded import read_record, record, slower
from benchmarks.run_time.timing import Timing
from benchmarks.run_time.turns import TurnRow, _errors
from benchmarks.run_time.work_precision import (
    Observed,
    Row,
    graded,
    graded_four,
    observe,
    trajectory_error,
)
from benchmarks.views.benchmark_report import (
    markdown,
    print_benchmark,
    print_slower,
    write_benchmark,
)
from benchmarks.views.work_precision_plot import work_precision_figure
from nipper_pin import Case, InputError, Mechanism, Window, simulate

sys.path.insert(0, str(Path(__file__).resolve().parents[3] / "scripts/maintain/figures"))

from write_benchmark_page import least_times, page

ROOT = Path(__file__).resolve().parents[3]
TIMING = Timing(2.0, 1.0, 0.5, 0.1, 3)


@pytest.fixture(scope="module")
def reference() -> Certified:
    return certified()


@pytest.fixture(scope="module")
def seen(e62: Mechanism) -> Observed:
    """What the direct engine finds, which is far more accurate than the errors that are planted."""
    return observe(simulate(e62, Case(speed_rpm=650.0)))


def test_dense_reference_belongs_to_the_certified_collisions(reference: Certified) -> None:
    """Dense flights start, end, rebound and culminate where the certified collisions say.

    Peaks and end rates are no samples of the file: they come from its interpolant and are compared
    with numbers of another file. Interpolation of an entire function in 33 points: round-off.
    """
    assert len(reference.flights) == 5
    assert reference.flights[0].rate[0] == reference.separation_rate
    for number, flight in enumerate(reference.flights):
        sigma = 2.0 * flight.fractions - 1.0
        # Both ends are nodes: the interpolant is the values, nothing is fitted.
        inverse = np.linalg.inv(chebyshev.chebvander(sigma, len(sigma) - 1))
        gap, rate = inverse @ flight.gap, inverse @ flight.rate
        assert flight.start_s == pytest.approx(reference.times[number], rel=1e-15)
        assert flight.duration_s == pytest.approx(reference.rebound_times[number], rel=1e-15)
        places = chebyshev.chebroots(chebyshev.chebder(gap)[:12])
        (top,) = [z.real for z in places if abs(z.imag) < 1e-9 and abs(z.real) < 1.0]
        peak = chebyshev.chebval(top, gap)
        assert peak == pytest.approx(reference.amplitudes[number], rel=1e-13)
        # The rate is the derivative of the gap: another 1e-13 times the square of the degree.
        slope = chebyshev.chebval(sigma, chebyshev.chebder(gap))
        tolerance = 1e-11 * abs(flight.rate[0])
        assert 2.0 * slope / flight.duration_s == pytest.approx(flight.rate, abs=tolerance)
        assert chebyshev.chebval(1.0, rate) < 0.0


@pytest.mark.parametrize("stretch", [1e-3, -1e-6])
def test_trajectory_error_of_shifted_events_is_the_shift(
    reference: Certified, seen: Observed, stretch: float
) -> None:
    """Stretching time by 1 + e gives e times (end of the last flight / transition time).

    Motion at equal fractions is unchanged, so the shift is all there is. At equal times instead,
    the rate would jump by 1.2 first separation rates at the first shifted event: no e at all.
    """
    scale, motion = 1.0 + stretch, seen.motion
    assert motion is not None
    late = replace(seen, times=scale * seen.times, motion=lambda t, left: motion(t / scale, left))
    last = reference.flights[-1]
    end = (last.start_s + last.duration_s) / reference.transition_time
    assert trajectory_error(late, reference) == pytest.approx(abs(stretch) * end, rel=1e-3)


def test_trajectory_error_of_a_motion_is_its_excess(reference: Certified, seen: Observed) -> None:
    """Too high by 1e-5 of the first amplitude, or too fast by 1e-4 of the first separation rate.

    The samples of the first flight miss its top by at most (pi/64)^2 / 2 of the height, 0.2 %.
    Without dense flights there is no error to tell.
    """
    motion = seen.motion
    assert motion is not None
    for swell, faster, error in ((1e-5, 0.0, 1e-5), (0.0, 1e-4, 1e-4)):

        def off(t: Any, left: bool, swell: float = swell, faster: float = faster) -> Any:
            gap, rate = motion(t, left)
            return (1.0 + swell) * gap, rate + faster * reference.separation_rate

        found = trajectory_error(replace(seen, motion=off), reference)
        assert found == pytest.approx(error, rel=3e-3)
    assert trajectory_error(seen, replace(reference, flights=())) is None


def test_each_error_is_that_of_its_quantity(reference: Certified) -> None:
    """Every list is off by a factor of its own, one more in a single place; the worst is told."""
    count = 5
    times_of_hits = reference.times[:count] * (1.0 + 1e-6)
    times_of_hits[2] *= 1.0 + 1e-5
    impulses = reference.impulses[:count] * (1.0 - 2e-4)
    amplitudes = reference.amplitudes[:count] * (1.0 + 3e-4)
    amplitudes[3] *= 1.0 - 1e-2
    duration = reference.transition_time * (1.0 - 4e-3)
    observed = Observed(times_of_hits, impulses, amplitudes, duration, 17)
    row = graded("one", "1e-3", Timing(100.0, 8.0, 1.0, 0.125, 9), observed, reference)
    times = (row.first_ms, row.wall_ms, row.fastest_ms, row.spread_ms, row.runs)
    assert times == (100.0, 8.0, 1.0, 0.125, 9)
    assert (row.engine, row.setting, row.evaluations) == ("one", "1e-3", 17)
    assert row.error_times == pytest.approx((1.0 + 1e-6) * (1.0 + 1e-5) - 1.0, rel=1e-6)
    assert row.error_impulses == pytest.approx(2e-4, rel=1e-9)
    assert row.error_amplitudes == pytest.approx(1.0 - (1.0 + 3e-4) * (1.0 - 1e-2), rel=1e-9)
    assert row.error_duration == pytest.approx(4e-3, rel=1e-9)
    assert row.error_worst == pytest.approx(4e-3, rel=1e-9)
    assert row.error_trajectory is None
    assert row.version is None
    # Peers tell four numbers. What an engine did not find is no result, never a small error.
    true = [*reference.rebound_times[:2], reference.amplitudes[0], reference.transition_time]
    for place in range(4):
        four = [value * (1.0 - 1e-7 * (n == place)) for n, value in enumerate(true)]
        peer = graded_four("peer", "setting", TIMING, four, reference)
        assert peer.error_worst == pytest.approx(1e-7, rel=1e-6)
    assert graded_four("peer", "", TIMING, [math.nan, *true[1:]], reference).error_worst is None
    short = replace(observed, times=times_of_hits[:2])
    assert graded("engine", "setting", TIMING, short, reference).error_worst is None


def test_chain_of_parallelograms_moves_as_one() -> None:
    """All cranks follow the drive, couplers stay level, and the energy is that of 2 N + 1 bars.

    N + 1 bars of 1 m and 1 kg turning about an end, J = 1/3, and N that move with the tip:
    T = (N + 1) w^2 / 6 + N w^2 / 2. A missing or double link changes it by its whole share.
    Closures meet to round-off, which the chain carries on from bar to bar: 1e-13.
    """
    count = 3
    mechanism = four_bar_chain(count)
    case = Case(speed_rpm=60.0, window=Window.CYCLE, start_index=0.0)
    solution = simulate(mechanism, case)
    assert len(mechanism.joints) == 2 * count + 1
    assert len(mechanism.closures) == count
    t = np.linspace(0.0, 1.0, 50)
    motion = solution.trajectory.evaluate(t)
    angle = 0.5 * np.sin(2.0 * np.pi * t)
    for joint in mechanism.joints:
        sign = 1.0 if joint.name.startswith("crank") else -1.0
        assert motion.q[:, joint.index] == pytest.approx(sign * angle, abs=1e-12)
    rate = np.pi * np.cos(2.0 * np.pi * t)
    energy = solution.system.body.kinetic_energy(motion.q, motion.v)
    expected = ((count + 1) / 6.0 + count / 2.0) * rate**2
    assert energy == pytest.approx(expected, abs=1e-11)


def test_errors_of_a_turn() -> None:
    """The certified turn against itself, a collision of the second series later and harder.

    A series that one has further than the other is compared as far as both have it.
    """
    rows = certified_cycle("650")
    stops = [row["stop"] for row in rows]
    times = np.array([float(row["time_s"]) for row in rows])
    impulses = np.array([float(row.get("impulse_lip_N_s", row["impulse"])) for row in rows])
    assert _errors("650", stops, times, impulses) == (0.0, 0.0)
    place = next(n for n, stop in enumerate(stops) if stop != stops[0])
    late, hard = times.copy(), impulses.copy()
    late[place] += 1e-5
    hard[place] *= 1.001
    time, impulse = _errors("650", stops[:-1], late[:-1], hard[:-1])
    assert time == pytest.approx(1e-5 * 650.0 / 60.0, rel=1e-6)
    assert impulse == pytest.approx(1e-3, rel=1e-6)


def _top_levels(code: str) -> set[str]:
    listed = f"{code}\nimport sys\nprint(*{{name.split('.')[0] for name in sys.modules}})"
    said = subprocess.run(
        [sys.executable, "-c", listed], capture_output=True, text=True, check=True
    )
    return set(said.stdout.split())


def test_import_adds_little_to_pinocchio() -> None:
    """The package adds itself alone: parsers come with a model, archives with a file.

    Names, not seconds: what is imported is what a start has to pay for. The control asks for
    `save`: there the same list does contain the parsers and the archives.
    """
    begin, imported, saved = (
        _top_levels(f"import pinocchio{code}")
        for code in (
            "",
            "; from nipper_pin import Case, load, simulate, record",
            ", nipper_pin; nipper_pin.load(); nipper_pin.save",
        )
    )
    late = {"msgspec", "tomllib", "xml", "csv", "json", "zipfile"}
    # eigenpy is the library that pinocchio is bound to Python by; its module takes 4 ms.
    assert imported - begin - sys.stdlib_module_names == {"nipper_pin", "eigenpy"}
    assert not (imported - begin) & late
    assert late <= saved - imported


def test_what_is_told_of_a_benchmark(
    tmp_path: Path,
    words: Words,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    """Printed in eighty columns, as tables, as the page that was recorded, and as a figure.

    No two numbers are equal, and one is none: settings without an answer have no place in a figure.
    """
    # Errors above one: smaller ones are no words that processors have in common.
    row = Row("direct", "finest", 3.25, 9.0, 3.0, 0.125, 30, 1.5, 2.5, 3.5, 4.5, 5.5, 6.5, 212)
    peer = Row("a peer with a rather long name (by hand)", "fine", 50.0, 99.0, 40.0, 5.0, 31,
               7.5, 8.5, evaluations=999, version="1.2.3")  # fmt: skip
    result = Benchmark(
        quick=True,
        environment={
            "date": "2026-01-02T03:04:05", "platform": "here", "processor": "chip", "cores": 6,
            "cores_allowed": 5, "load_average": [1.25, 2.5, 3.5], "python": "3.11.9",
            "threads": {"OMP_NUM_THREADS": None, "MKL_NUM_THREADS": "3"},
            "versions": {"numpy": "2.1", "pin": "3.2"},
        },
        engines=(row, replace(row, setting="coarse", fastest_ms=2.5, error_worst=9.5)),
        accuracy=(replace(row, setting="case 450", wall_ms=3.5),),
        peers=(peer, replace(peer, setting="too coarse", fastest_ms=45.0, error_worst=None)),
        unavailable=("a peer, 1 ms: no bounce",),
        reduced={"build_ms": 144.0, "transitions_per_s": 21792.4},
        turns=(TurnRow("direct", "450 r/min", 13.0, 1.25, math.nan, 77.0, None),),
        cost={
            "turns": [{"turns": 3, "reuse_ms": 14.0, "no_reuse_ms": 44.0}],
            "links": [{"links": 5, "held_ms": 1.5, "inertial_ms": 20.0, "evaluation_us": None}],
        },
    )  # fmt: skip
    printed = io.StringIO()
    print_benchmark(result, Console(file=printed, width=80, color_system=None))
    assert max(len(line) for line in printed.getvalue().splitlines()) <= 80
    text = page(result.record())
    told = ("| ", "Measured:", "The reduced engine's tables")
    lines = [line for line in text.splitlines() if line.startswith(told)]
    figure = drawn(work_precision_figure(result))
    words("\n".join([printed.getvalue(), markdown(result), *lines, "", figure]))
    kept = (ROOT / "docs/benchmark.md").read_text(encoding="utf-8")
    for start in ("#", "| engine", "| turns", "| links"):
        titles = [line for line in text.splitlines() if line.startswith(start)]
        assert titles
        assert [line for line in kept.splitlines() if line.startswith(start)] == titles
    files = write_benchmark(result, tmp_path / "new")
    assert [path.name for path in files] == ["benchmark.json", "tables.md", "work_precision.png"]
    document = json.loads(files[0].read_text(encoding="utf-8"))
    assert document == json.loads(json.dumps(result.record(), allow_nan=False))
    assert document["turns"][0]["error_impulses"] is None
    assert document["engines"][0] == asdict(result.engines[0])
    assert files[1].read_text(encoding="utf-8") == markdown(result)
    assert files[2].read_bytes().startswith(b"\x89PNG")
    before = record(document)
    before["engines"][0][2] /= 2.0
    file = tmp_path / "recorded.json"
    file.write_text(json.dumps(before), encoding="utf-8")
    monkeypatch.setattr("benchmarks.run_time.recorded.RECORDED", file)
    monkeypatch.setattr("benchmarks.run_time.benchmark.benchmark", lambda **_: result)
    assert main(["run"]) == 0
    assert main(["run", "--no-slower"]) == 1
    said = capsys.readouterr().err
    assert "settings that became slower: 1; direct at finest takes 2.00 times as long" in said


def test_the_least_time_is_below_the_bound_of_its_column() -> None:
    scipy, numba = (
        "SciPy DOP853, located events (hand-derived equation)",
        "fixed-step RK4, located impacts (numba, hand-derived equation)",
    )
    points = [("a", 4, 1e-3), ("a", 5, 9.9e-4), ("a", 9, 2e-7), ("a", 12, 1e-10), ("a", 8, None),
              (scipy, 6, 1e-12), (numba, 3, 1e-12)]  # fmt: skip
    rows = [{"engine": e, "fastest_ms": t, "error_worst": worst} for e, t, worst in points]
    assert "| a | 5 | 9 | 12 | 2 | 4 | 1.0e-10 | 12 |" in least_times(rows)
    assert f"| {scipy} | 6 | 6 | 6 | 1 | 2 | 1.0e-12 | 6 |" in least_times(rows)


def test_what_became_slower_is_told_by_the_peers_of_both_runs(words: Words) -> None:
    """On a machine of half the pace: what takes twice as long is as fast, 2.3 times is slower."""
    before = read_record()
    assert before["engines"]
    assert before["date"][:10] in (ROOT / "docs/benchmark.md").read_text(encoding="utf-8")
    factor = {"direct": 2.0, "reduced": 2.3, "reduced, batch": 1.0}

    def rows(kind: str, time: str, longer: Any) -> list[dict[str, Any]]:
        return [{"engine": name, "setting": at, time: longer(name) * ms}
                for name, at, ms in before[kind]]  # fmt: skip

    document = {
        "environment": {"date": "later"},
        "engines": [*rows("engines", "fastest_ms", factor.__getitem__),
                    {"engine": "reduced", "setting": "none before", "fastest_ms": 99.0}],
        "turns": rows("turns", "wall_ms", lambda name: 1.2 * factor[name]),
        "peers": rows("peers", "fastest_ms", lambda _: 2.0),
    }  # fmt: skip
    found = slower(document, before)
    of = {(kind, name): 0 for kind in ("engines", "turns") for name in factor}
    for kind, name in of:
        of[kind, name] = sum(row[0] == name for row in before[kind])
    assert [round(item.ratio, 12) for item in found] == [
        *[1.38] * of["turns", "reduced"], *[1.2] * of["turns", "direct"],
        *[1.15] * of["engines", "reduced"],
    ]  # fmt: skip
    printed = io.StringIO()
    for some in (found[:1], []):
        print_slower(some, Console(file=printed, width=80, color_system=None))
    words(printed.getvalue())
    with pytest.raises(InputError, match="no peer of the recorded run"):
        slower({**document, "peers": []}, before)


@pytest.mark.slow
def test_quick_benchmark_prints_one_document(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Everything in its place; finer tolerances err less, none 10 times as much as asked.

    Errors are measured against the reference, so that order over eight decades is no accident.
    """
    # Short runs are not repeated: no time is looked at here.
    monkeypatch.setattr(timing, "_SHORTEST_S", 0.0)
    assert main(["run", "--quick", "--repeats", "1", "--json", "-"]) == 0
    document = json.loads(capsys.readouterr().out)
    engines = {name: [row for row in document["engines"] if row["engine"] == name]
               for name in ("direct", "reduced", "reduced, batch")}  # fmt: skip
    for rows in engines.values():
        errors = [row["error_worst"] for row in rows]
        assert errors[0] <= 1e-3
        assert errors[-1] <= 1e-11
        for row in rows:
            assert row["error_worst"] <= 10.0 * float(row["setting"])
            assert 0.0 < row["fastest_ms"] <= row["wall_ms"]
    errors = [row["error_worst"] for row in engines["direct"]]
    assert errors == sorted(errors, reverse=True)
    assert all(row["evaluations"] > 0 for row in engines["direct"])
    assert [row["setting"] for row in document["accuracy"]] == [
        f"case {name}" for name in certified_names()
    ]
    assert all(row["error_worst"] <= 1e-10 for row in document["accuracy"])
    assert {row["engine"] for row in document["peers"]} == {peer.NAME for peer, _ in available()}
    assert all(row["version"] and row["error_worst"] < 0.1 for row in document["peers"])
    assert [row["turns"] for row in document["cost"]["turns"]] == [1, 3, 10]
    for row, count in zip(document["cost"]["links"], (1, 2, 5, 10), strict=True):
        assert (row["four_bars"], row["links"], row["cut_pins"]) == (count, 2 * count + 1, count)
        assert row["held_evaluations"] == 0 < row["inertial_evaluations"]
        assert max(row["held_energy_balance"], row["inertial_energy_balance"]) <= 1e-10
    # Its bound is one: what it states covers what is true.
    reduced = document["reduced"]
    assert reduced["error"] <= reduced["stated_error"] <= 1e-8
    assert (document["quick"], reduced["batch"]) == (True, 10_000)


# --- its clock -----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("seconds", "repeats", "budget", "runs", "figures"),
    [
        # The first run is apart from the others: their median, their best, and their quartiles.
        ([2.0, 0.3, 0.1, 0.4, 0.15, 0.9], 5, math.inf, 5, (300.0, 100.0, 525.0)),
        ([2.0, 0.1, 0.2, 0.3], 3, math.inf, 3, (200.0, 100.0, 0.0)),
        # Enough repeats, but not a fifth of a second: 1 / 64 s are repeated 13 times.
        ([1 / 64], 3, math.inf, 13, (15.625, 15.625, 0.0)),
        # A short budget is all that a short run is repeated for, however long the first took.
        ([1 / 64], 3, 1 / 8, 8, (15.625, 15.625, 0.0)),
        ([2.0, 1 / 64], 3, 1 / 8, 8, (15.625, 15.625, 0.0)),
        ([1.0], 9, 0.0, 1, (1000.0, 1000.0, 0.0)),
    ],
)
def test_figures_of_a_clock(
    monkeypatch: pytest.MonkeyPatch, seconds: list[float], repeats: int, budget: float, runs: int,
    figures: tuple[float, ...],
) -> None:  # fmt: skip
    """In milliseconds, by a clock that each run moves on by so much."""
    now, done = [50.0], [0]

    def function() -> None:
        now[0] += seconds[min(done[0], len(seconds) - 1)]
        done[0] += 1

    monkeypatch.setattr(timing.time, "perf_counter", lambda: now[0])
    found = timing.timed(function, repeats, budget)
    assert (found.runs, done[0]) == (runs, runs + 1)
    assert found.first_ms == pytest.approx(1e3 * seconds[0])
    assert (found.wall_ms, found.fastest_ms, found.spread_ms) == pytest.approx(figures)
