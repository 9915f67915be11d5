"""The benchmark measures what it says: its reference, its norms, its scenes, its comparisons.

Nothing here looks at seconds.
"""

from __future__ import annotations

import io
import itertools
import json
import math
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.polynomial import chebyshev
from programs import main
from rich.console import Console

from benchmarks.run_time.benchmark import Benchmark
from benchmarks.run_time.certified import Certified, certified, certified_names
from benchmarks.run_time.cost import four_bar_chain
from benchmarks.run_time.timing import Timing, environment, timed
from benchmarks.run_time.turns import TurnRow, turn_rows
from benchmarks.run_time.work_precision import (
    Observed,
    Row,
    graded,
    graded_four,
    observe,
    trajectory_error,
)
from benchmarks.views.benchmark_report import markdown, print_benchmark, write_benchmark
from benchmarks.views.work_precision_plot import work_precision_figure
from nipper_pin import Case, Window, simulate
from nipper_pin.errors import UnknownNameError

sys.path.insert(0, str(Path(__file__).resolve().parents[3] / "scripts/maintain/figures"))

from write_benchmark_page import least_times, page

TIMING = Timing(2.0, 1.0, 0.5, 0.1, 3)
UNWANTED = {"matplotlib", "rich", "yourdfpy", "meshcat", "pandas", "trimesh", "numba", "mpmath"}


@pytest.fixture(scope="module")
def reference() -> Certified:
    return certified()


def polynomials(reference: Certified) -> list[tuple[np.ndarray, np.ndarray]]:
    """Gap and rate of every dense flight as Chebyshev series of 2 sigma - 1."""
    found = []
    for flight in reference.flights:
        places = 2.0 * flight.fractions - 1.0
        degree = len(places) - 1
        # Both ends are nodes: the interpolant is the values, nothing is fitted.
        inverse = np.linalg.inv(chebyshev.chebvander(places, degree))
        found.append((inverse @ flight.gap, inverse @ flight.rate))
    return found


def certain(reference: Certified, stretch: float = 0.0, swell: float = 0.0) -> Observed:
    """An engine that knows the reference, but its times are off by a factor, or its gaps."""
    series, scale = polynomials(reference), 1.0 + stretch
    starts = np.array([flight.start_s for flight in reference.flights])

    def motion(t: np.ndarray, left: bool) -> tuple[np.ndarray, np.ndarray]:
        places = np.searchsorted(scale * starts, t, side="left" if left else "right") - 1
        # The end of the last flight computed is the start of none.
        gap, rate = np.empty(len(t)), np.empty(len(t))
        for row, place in enumerate(places):
            flight = reference.flights[place]
            sigma = (t[row] / scale - flight.start_s) / flight.duration_s
            gap[row], rate[row] = (
                chebyshev.chebval(2.0 * sigma - 1.0, item) for item in series[place]
            )
        return (1.0 + swell) * gap, rate

    return Observed(
        times=scale * reference.times[:6],
        impulses=reference.impulses[:6],
        amplitudes=(1.0 + swell) * reference.amplitudes[:6],
        transition_time=scale * reference.transition_time,
        evaluations=1,
        motion=motion,
    )


def test_dense_reference_belongs_to_the_certified_collisions(reference: Certified) -> None:
    """Dense flights start, end, rebound and culminate where the certified collisions say.

    Peaks and end rates are no samples of the file: they come from its interpolant and are compared
    with numbers of another file. Interpolation of an entire function in 33 points: round-off.
    """
    assert len(reference.flights) == 5
    assert reference.flights[0].rate[0] == reference.separation_rate
    for number, (flight, (gap, rate)) in enumerate(
        zip(reference.flights, polynomials(reference), strict=True)
    ):
        assert flight.start_s == pytest.approx(reference.times[number], rel=1e-15)
        assert flight.duration_s == pytest.approx(reference.rebound_times[number], rel=1e-15)
        places = chebyshev.chebroots(chebyshev.chebder(gap)[:12])
        (top,) = [z.real for z in places if abs(z.imag) < 1e-9 and abs(z.real) < 1.0]
        peak = chebyshev.chebval(top, gap)
        assert peak == pytest.approx(reference.amplitudes[number], rel=1e-13)
        # The rate is the derivative of the gap: another 1e-13 times the square of the degree.
        slope = chebyshev.chebval(2.0 * flight.fractions - 1.0, chebyshev.chebder(gap))
        tolerance = 1e-11 * abs(flight.rate[0])
        assert 2.0 * slope / flight.duration_s == pytest.approx(flight.rate, abs=tolerance)
        assert chebyshev.chebval(1.0, rate) < 0.0


def test_trajectory_error_of_the_truth_is_round_off(reference: Certified) -> None:
    """The reference against itself, through its interpolant: zero but for round-off.

    Times of 6e-3 s are known to 1e-18 s; the last flight of 1e-5 s shares that: 1e-13 in its rate.
    """
    error = trajectory_error(certain(reference), reference)
    assert error is not None
    assert error <= 1e-12


@pytest.mark.parametrize("stretch", [1e-3, -1e-6, 1e-9])
def test_trajectory_error_of_shifted_events_is_the_shift(
    reference: Certified, stretch: float
) -> None:
    """Stretching time by 1 + e gives e times (end of the last flight / transition time).

    Motion at equal fractions is unchanged, so the shift is all there is. At equal times instead,
    the rate would jump by 1.2 first separation rates at the first shifted event: no e at all.
    """
    error = trajectory_error(certain(reference, stretch=stretch), reference)
    last = reference.flights[-1]
    end = (last.start_s + last.duration_s) / reference.transition_time
    assert error == pytest.approx(abs(stretch) * end, rel=1e-3)


def test_trajectory_error_of_too_high_a_bounce_is_its_excess(reference: Certified) -> None:
    """Gaps too high by a factor 1 + 1e-5 have error 1e-5 of the first amplitude, if sampled there.

    The samples of the first flight miss its top by at most (pi/64)^2 / 2 of the height, 0.2 %.
    """
    error = trajectory_error(certain(reference, swell=1e-5), reference)
    assert error == pytest.approx(1e-5, rel=3e-3)


@pytest.mark.parametrize(("place", "error"), list(itertools.product(range(4), (1e-3, -1e-7))))
def test_worst_of_four_is_the_worst(reference: Certified, place: int, error: float) -> None:
    """An error put into one of the four quantities comes out, whichever it is, for peers too."""
    first, second = reference.rebound_times[:2]
    true = [first, second, float(reference.amplitudes[0]), reference.transition_time]
    four = list(true)
    four[place] *= 1.0 + error
    observed = replace(
        certain(reference),
        times=np.array([0.0, four[0], four[0] + four[1]]),
        amplitudes=np.array(four[2:3]),
        transition_time=four[3],
        motion=None,
    )
    row = graded("engine", "setting", TIMING, observed, reference)
    # The second rebound is the difference of two times: their round-off by its length, 1e-15.
    assert row.error_worst == pytest.approx(abs(error), abs=1e-13)
    peer = graded_four("peer", "setting", TIMING, four, reference)
    assert peer.error_worst == pytest.approx(abs(error), abs=1e-13)
    expected = abs(error) if place == 3 else 0.0
    assert row.error_duration == pytest.approx(expected, abs=1e-15)


def test_an_answer_that_is_missing_is_no_answer(reference: Certified) -> None:
    """What an engine did not find counts as no result, never as a small error."""
    true = certain(reference)
    short = replace(true, times=true.times[:2], motion=None)
    assert graded("engine", "setting", TIMING, short, reference).error_worst is None
    four = [math.nan, 1.0, 1.0, 1.0]
    assert graded_four("peer", "", TIMING, four, reference).error_worst is None


def test_direct_engine_is_graded_as_accurate() -> None:
    """At 1e-12 the engine meets every certified transition to 1e-10 in all norms.

    The reference shares no code with the engine; a wrong column or unit would be off by orders.
    """
    for name in certified_names():
        case = certified(name)
        solution = simulate(case.mechanism(), Case(speed_rpm=case.speed_rpm))
        row = graded("direct", name, TIMING, observe(solution), case)
        errors = [row.error_worst, row.error_times, row.error_impulses, row.error_amplitudes]
        assert all(item is not None and item <= 1e-10 for item in errors)
        if case.flights:
            assert row.error_trajectory is not None
            assert row.error_trajectory <= 1e-10


def test_unknown_case_is_refused() -> None:
    """A case that is not certified is refused, and the message names those that are."""
    with pytest.raises(UnknownNameError, match=r"650_e0\.5"):
        certified("650_e0.9")


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


def test_integrated_chain_keeps_its_energy_balance() -> None:
    """With an inertial shaft the chain is integrated, and work and energy agree to 1e-10."""
    case = Case(speed_rpm=60.0, window=Window.CYCLE, start_index=0.0, drive="inertial")  # type: ignore[arg-type]
    solution = simulate(four_bar_chain(2), case)
    assert not any(segment.kinematic for segment in solution.segments)
    assert solution.checks.energy_balance <= 1e-10


def test_first_run_is_kept_apart_and_a_budget_is_kept() -> None:
    """One run is the first, then the repeats; beyond the budget exactly one repeat is done.

    Six runs of 50 ms are over a fifth of a second, so none is added; a run of next to no time is
    repeated more often than asked for.
    """
    calls: list[int] = []

    def long() -> None:
        calls.append(1)
        time.sleep(0.05)

    assert timed(long, 5).runs == 5
    assert len(calls) == 6
    assert timed(lambda: None, 5).runs > 5
    calls.clear()
    assert timed(long, 5, budget_s=0.0).runs == 1
    assert len(calls) == 2


def test_environment_names_machine_and_versions() -> None:
    """Processor, cores, threads and versions are there: a time without its machine says nothing."""
    found = environment(["no-such-distribution"])
    assert found["processor"]
    assert found["cores"] >= 1
    assert {"pin", "numpy", "nipper-pin"} <= found["versions"].keys()
    assert "no-such-distribution" not in found["versions"]
    assert "OPENBLAS_NUM_THREADS" in found["threads"]


def _top_levels(code: str) -> set[str]:
    listed = f"{code}\nimport sys\nprint(*{{name.split('.')[0] for name in sys.modules}})"
    said = subprocess.run(
        [sys.executable, "-c", listed], capture_output=True, text=True, check=True
    )
    return set(said.stdout.split())


def test_a_headless_run_imports_nothing_to_look_at() -> None:
    """Simulating a transition and a turn, with JSON, imports no plotting, viewer or compiler.

    The control draws a plot in the same way: there the list does contain matplotlib.
    """
    run = (
        "import sys, nipper_pin.cli as c\n"
        "import contextlib, io\n"
        "with contextlib.redirect_stdout(io.StringIO()):\n"
        "    for window in ('transition', 'cycle'):\n"
        "        assert c.main(['simulate', '--speed', '650', '--window', window,"
        " '--json', '-']) == 0\n"
    )
    assert not _top_levels(run) & UNWANTED
    assert "matplotlib" in _top_levels(run + "import nipper_pin.view.run.plots\n") & UNWANTED


def test_import_adds_little_to_pinocchio() -> None:
    """The package adds itself alone: parsers come with a model, archives with a file.

    Names, not seconds: what is imported is what a start has to pay for. The controls load a model
    and ask for `save`: there the same list does contain the parsers and the archives. The door
    itself brings nothing at all: its errors are plain Python.
    """
    begin, imported, loaded, saved = (
        _top_levels(code)
        for code in (
            "import pinocchio",
            "import pinocchio; from nipper_pin import Case, load, simulate, record",
            "import pinocchio, nipper_pin; nipper_pin.load()",
            "import pinocchio, nipper_pin; nipper_pin.load(); nipper_pin.save",
        )
    )
    assert "numpy" not in _top_levels("import nipper_pin")
    parsers, archives = {"msgspec", "tomllib", "xml", "csv"}, {"json", "zipfile"}
    # eigenpy is the library that pinocchio is bound to Python by; its module takes 4 ms.
    assert imported - begin - sys.stdlib_module_names == {"nipper_pin", "eigenpy"}
    elsewhere = {"scipy", "argparse", "tempfile", "subprocess", "multiprocessing", "logging"}
    assert not (imported - begin) & (UNWANTED | parsers | archives | elsewhere)
    assert parsers <= loaded - imported
    assert not (loaded - begin) & (UNWANTED | archives | elsewhere)
    assert archives <= saved - loaded


@pytest.fixture
def made_up() -> Benchmark:
    """A benchmark whose numbers are invented, one of them not a number."""
    row = Row("direct", "1e-12", 3.25, 9.0, 3.0, 0.1, 30, 2e-13, 7e-13, evaluations=212)
    peer = replace(row, engine="a peer with a rather long name (by hand)", version="1.2.3")
    links = {"links": 3, "held_ms": 1.5, "inertial_ms": 20.0, "evaluation_us": math.nan}
    return Benchmark(
        quick=True,
        environment=environment(),
        engines=(row, replace(row, setting="1e-13", error_worst=0.0)),
        accuracy=(row,),
        peers=(peer, replace(peer, setting="too coarse", error_worst=None)),
        unavailable=("a peer, 1 ms: no bounce",),
        reduced={"build_ms": 144.0, "transitions_per_s": 21792.4},
        turns=(TurnRow("direct", "450 r/min, 1e-09", 13.0, 1e-12, math.nan, 77.0, None),),
        cost={
            "turns": [{"turns": 3, "reuse_ms": 14.0, "no_reuse_ms": 40.0}],
            "links": [links],
        },
    )


@pytest.mark.slow
def test_whole_turns_of_both_engines() -> None:
    """Two speeds at three tolerances; errors follow the tolerance and are not zero by accident."""
    rows = turn_rows(repeats=1)
    tolerances = ("1e-06", "1e-09", "1e-12")
    settings = [f"{speed} r/min, {item}" for speed in (450, 650) for item in tolerances]
    assert [row.setting for row in rows if row.engine == "direct"] == settings
    assert [row.setting for row in rows if row.engine == "reduced"] == settings
    for direct, reduced in zip(rows[::2], rows[1::2], strict=True):
        assert direct.tables_ms is None
        assert reduced.tables_ms is not None
        tolerance = float(direct.setting.partition(", ")[2])
        for row in (direct, reduced):
            assert 0.0 < row.error_times <= 10.0 * tolerance
            assert 0.0 < row.error_impulses <= 100.0 * tolerance
            assert row.turns_per_s == pytest.approx(1e3 / row.wall_ms)


def test_what_is_not_a_number_becomes_null(made_up: Benchmark) -> None:
    """The document is strict JSON: what is not a number is null, and all else survives."""
    document = json.loads(json.dumps(made_up.record(), allow_nan=False))
    assert document["cost"]["links"][0]["evaluation_us"] is None
    assert document["engines"][0]["error_worst"] == 7e-13
    assert document["reduced"] == {"build_ms": 144.0, "transitions_per_s": 21792.4}


def test_tables_show_the_numbers_and_fit_a_terminal(made_up: Benchmark) -> None:
    """Eighty columns hold every table; what a narrow one leaves out is in the Markdown."""
    buffer = io.StringIO()
    print_benchmark(made_up, Console(file=buffer, width=80, color_system=None))
    text = buffer.getvalue()
    assert max(len(line) for line in text.splitlines()) <= 80
    for number in ("3.25", "7.0e-13", "2.0e-13", "no bounce"):
        assert number in text
        assert number in markdown(made_up)
    assert "1.2.3" in markdown(made_up)


def test_the_page_holds_least_times_and_their_ratios(made_up: Benchmark) -> None:
    """What `make benchmark` writes; it has the headings of the page that was recorded."""
    written = page(made_up.record())
    # Of the two settings of the engine the coarser one is cheaper or equal, and above no bound.
    assert "| direct | 3 | 3 | 3 | - | - | 0.0e+00 | 3 |" in written
    assert written.count("| a peer with a rather long name (by hand) | 3 |") == 1
    kept = (Path(__file__).parents[3] / "docs/benchmark.md").read_text(encoding="utf-8")
    for start in ("#", "| engine", "| turns", "| links"):
        titles = [line for line in written.splitlines() if line.startswith(start)]
        assert titles
        assert [line for line in kept.splitlines() if line.startswith(start)] == titles


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


def test_files_are_written(made_up: Benchmark, tmp_path: Path) -> None:
    """JSON, tables and plot; an error of zero or none has a place on logarithmic axes, or none."""
    files = write_benchmark(made_up, tmp_path / "new")
    assert [path.name for path in files] == ["benchmark.json", "tables.md", "work_precision.png"]
    assert json.loads(files[0].read_text(encoding="utf-8")) == made_up.record()
    assert files[2].read_bytes().startswith(b"\x89PNG")
    (axes,) = work_precision_figure(made_up).axes
    assert axes.get_xscale() == axes.get_yscale() == "log"
    points = {len(line.get_xdata()) for line in axes.get_lines()}  # type: ignore[arg-type]
    assert points == {2, 1}


@pytest.mark.slow
def test_quick_benchmark_prints_one_document(capsys: pytest.CaptureFixture[str]) -> None:
    """The command prints one JSON document; finer tolerances err less, none 10 times as asked.

    Errors are measured against the reference, so that order over eight decades is no accident.
    """
    assert main(["run", "--quick", "--repeats", "1", "--json", "-"]) == 0
    document = json.loads(capsys.readouterr().out)
    direct = [row for row in document["engines"] if row["engine"] == "direct"]
    errors = [row["error_worst"] for row in direct]
    assert errors == sorted(errors, reverse=True)
    assert errors[0] <= 1e-3
    assert errors[-1] <= 1e-11
    for row in direct:
        assert row["error_worst"] <= 10.0 * float(row["setting"])
        assert row["evaluations"] > 0
        assert row["wall_ms"] > 0.0
    assert {"environment", "peers", "reduced", "cost"} <= document.keys()
    assert document["cost"]["links"][-1]["links"] == 21
    # Its bound is one: what it states covers what is true.
    assert document["reduced"]["error"] <= document["reduced"]["stated_error"] <= 1e-8
    assert document["reduced"]["transitions_per_s"] > 0.0
