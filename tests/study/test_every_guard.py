"""Refusals before a study begins, unknown rows, and the choice of processes.

Processes and machines are stand-ins that remember what they were asked for.
"""

from __future__ import annotations

import signal
import sys
from collections.abc import Callable, Iterator
from concurrent.futures.process import BrokenProcessPool
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from benchmarks.run_time import cost
from nipper_pin import Case, Mechanism, simulate
from nipper_pin.errors import InputError, ModelError, SimulationError
from nipper_pin.hybrid.result.rebound_errors import ReboundError
from nipper_pin.reduced import inputs
from nipper_pin.reduced.kernels import layout
from nipper_pin.study import identify, processes, sensitivity
from nipper_pin.study.identify.problem import problem
from nipper_pin.study.identify.problem import working_cycle as working
from nipper_pin.study.sensitivity import QUANTITIES, Sensitivities, Sensitivity
from nipper_pin.study.sweep.study_file import read_study
from nipper_pin.study.transitions import rows as rows_module
from nipper_pin.study.transitions.rows import collision_rows
from nipper_pin.study.true_transition import assumed_transition
from nipper_pin.tolerances.study import DOUBTFUL

sys.path.append(str(Path(__file__).parents[2] / "scripts/maintain/measure"))

import measure_premise as premises

KNOWN = (
    "TIME", "ANGLE", "APPROACH", "SEPARATION", "IMPULSE", "ENERGY", "TIME_ERROR", "RATE_ERROR",
    "IMPULSE_ERROR",
)  # fmt: skip
REBOUND = ("AMPLITUDE", "REBOUND", "AMPLITUDE_ERROR", "REBOUND_ERROR")


# Rows of a transition.


def test_rebounds_that_a_run_does_not_reach(e62: Mechanism) -> None:
    """The last of three collisions has a row, and nothing in it of the rebound that follows."""
    case = Case(speed_rpm=650.0, max_collisions=3)
    hits = simulate(e62, case).collisions
    assert [hit.rebound_time is None for hit in hits] == [False, False, True]
    rows = collision_rows(assumed_transition(e62, case))
    for name in KNOWN:
        assert np.isfinite(rows[getattr(layout, name)]).all(), name
    for name in REBOUND:
        assert np.isfinite(rows[getattr(layout, name), :2]).all(), name
        assert np.isnan(rows[getattr(layout, name), 2]), name


@pytest.mark.parametrize("unknown", ["rebound_amplitude", "rebound_time", None])
def test_rebounds_of_which_one_number_is_missing(
    monkeypatch: pytest.MonkeyPatch, unknown: str | None
) -> None:
    """Half a rebound is none."""
    monkeypatch.setattr(rows_module, "rebound_error", lambda *_: ReboundError(0.125, 0.375))
    numbers = dict.fromkeys(
        ("t", "cylinder_angle", "approach_rate", "separation_rate", "impulse", "energy_lost",
         "rebound_amplitude", "rebound_time"), 0.5
    )  # fmt: skip
    hit = SimpleNamespace(**{**numbers, **({unknown: None} if unknown else {})})
    error = SimpleNamespace(time=1e-9, impulse=1e-8)
    found: Any = SimpleNamespace(collisions=(hit,), errors=(error,), solution=None)
    rows = collision_rows(found)
    told = [rows[getattr(layout, name), 0] for name in REBOUND]
    assert np.isnan(told).all() if unknown else told == [0.5, 0.5, 0.125, 0.375]


# Files.


SWEEP = """
format = 1
model = "e62"
[case]
speed_rpm = 650.0
[parameters]
"""
RANGE = "{ low = %g, high = %g, points = 2 }"


def sweep(folder: Path, *parameters: tuple[str, float, float]) -> Any:
    lines = [f'"{name}" = {RANGE % (low, high)}' for name, low, high in parameters]
    file = folder / "sweep.toml"
    file.write_text(SWEEP + "\n".join(lines), encoding="utf-8")
    return read_study(str(file))


def test_dimensions_that_contradict_one_another(tmp_path: Path) -> None:
    """Each may change alone; together a radius and an inertia of one link are refused."""
    radius = ("links.top_nipper.gyration_mm", 10.0, 60.0)
    inertia = ("links.top_nipper.inertia_kg_m2", 1e-3, 2e-3)
    for one in (radius, inertia):
        (axis,) = sweep(tmp_path, one).job.axes
        assert (axis.target.kind, axis.target.path) == ("model", one[0])
        assert (axis.low, axis.high) == one[1:]
    with pytest.raises(InputError, match="one of gyration_mm and inertia_kg_m2") as caught:
        sweep(tmp_path, radius, inertia)
    assert caught.value.evidence["key"] == "parameters"


FIT = """
format = 1
title = "mine"
model = "MODEL"
[parameters."PATH"]
low = 0.05
high = 0.95
[[targets]]
name = "one"
quantity = "duration_s"
at = { speed_rpm = 650.0 }
value = 0.25
sigma = 0.02
"""


def fit_file(folder: Path, model: str, limits: str) -> Path:
    file = folder / "fit.toml"
    text = FIT.replace("MODEL", model).replace("PATH", "stops.jaw.restitution")
    file.write_text(f"{text}{limits}\n", encoding="utf-8")
    return file


def test_limits_of_a_model_without_two_phases(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Refused with the reason; targets alone need no phases."""
    asked: list[str] = []

    def unfit(mechanism: Mechanism) -> str:
        asked.append(mechanism.name)
        return "it has three phases"

    monkeypatch.setattr(problem, "unfit", unfit)
    file = fit_file(tmp_path, "e62", "")
    assert identify.read_problem(file).limits is None
    assert asked == []
    file = fit_file(tmp_path, "e62", "[limits]\nat = { speed_rpm = 60.0 }")
    with pytest.raises(ModelError, match="it has three phases") as caught:
        identify.read_problem(file)
    told = caught.value.evidence
    assert (told["file"], told["key"], told["value"]) == ("fit.toml", "limits", "e62")
    assert asked == ["e62"]


@pytest.mark.parametrize(
    ("changes", "fits"),
    [
        ({}, True),
        ({"closed": frozenset()}, False),
        ({"closed": frozenset({"other", "third"})}, False),
        ({"closed": frozenset({"jaw"})}, False),
        ({"degrees_of_freedom": 4}, False),
        ({"degrees_of_freedom": 2}, False),
        ({"drives": ("one",)}, False),
        ({"plain": (True, False)}, False),
    ],
)
def test_models_with_two_phases_without_freedom(changes: dict[str, Any], fits: bool) -> None:
    """One freedom beside the drives, one other stop closed at first, and stops at zero."""
    given = {
        "closed": frozenset({"other"}), "degrees_of_freedom": 3, "drives": ("one", "two"),
        "plain": (True, True), **changes,
    }  # fmt: skip
    closed, plain = given.pop("closed"), given.pop("plain")
    mechanism: Any = SimpleNamespace(
        name="made_up", transition_stop="jaw", initial_phase=7,
        phase=lambda number: {7: SimpleNamespace(closed=closed)}[number],
        stops=[SimpleNamespace(plain=item) for item in plain], **given,
    )  # fmt: skip
    reason = working.unfit(mechanism)
    assert (reason is None) is fits
    if reason is not None:
        assert reason.startswith("made_up: timing and forces by kinematics need one degree")
        assert "by jaw after it" in reason


def test_openings_in_degrees_need_a_hinge(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The same file with a stop on a hinge, and with the same stop on a slide."""
    limits = "[limits]\nat = { speed_rpm = 60.0 }\njaw_opening_deg = { low = 20.0 }"
    file = fit_file(tmp_path, "e62", limits)
    found = identify.read_problem(file).limits
    assert found is not None
    assert (found.jaw_opening_deg, found.stop_force_N) == (20.0, None)
    real = problem.base_mechanism

    def slid(*words: Any) -> Any:
        """The stop at the end of a slide."""
        mechanism = real(*words)
        return replace(mechanism, transition_stop="steeve")

    monkeypatch.setattr(problem, "base_mechanism", slid)
    monkeypatch.setattr(problem, "unfit", lambda _: None)
    with pytest.raises(ModelError, match="only with a stop on a hinge; steeve is on a slide") as no:
        identify.read_problem(file)
    told = no.value.evidence
    assert (told["key"], told["value"]) == ("limits.jaw_opening_deg", 20.0)
    text = "[limits]\nat = { speed_rpm = 60.0 }\nstop_force_N = { low = 2.0 }"
    assert identify.read_problem(fit_file(tmp_path, "e62", text)).limits is not None


# Processes.


class Pool:
    """A pool that computes here and remembers how it was made."""

    made: tuple[int, dict[str, Any]]
    submitted: list[Any]
    broken = False

    def __init__(self, workers: int, **others: Any) -> None:
        type(self).made, type(self).submitted = (workers, others), []

    def __enter__(self) -> Pool:
        return self

    def __exit__(self, *_: object) -> None:
        """Nothing is left."""

    def shutdown(self, **_: bool) -> None:
        """What waits is left out."""

    def submit(self, first: Callable[[], None]) -> None:
        held_back = signal.SIGINT in signal.pthread_sigmask(signal.SIG_BLOCK, set())
        self.submitted.append((first, held_back))

    def map(self, task: Callable[[Any], Any], items: Any, chunksize: int) -> Iterator[Any]:
        assert chunksize == 1
        for item in items:
            if self.broken:
                raise BrokenProcessPool
            yield task(item)


@pytest.fixture(name="pool")
def made_up_pool(monkeypatch: pytest.MonkeyPatch) -> type[Pool]:
    monkeypatch.setattr(processes, "ProcessPoolExecutor", Pool)
    monkeypatch.setattr(Pool, "broken", False)
    return Pool


def test_processes_begin_afresh(pool: type[Pool]) -> None:
    """Spawned, one for each worker, watched, and deaf to the keyboard while they start."""
    first: Callable[[], None] = lambda: None  # noqa: E731
    with processes.fresh_processes(3, first) as given:
        assert isinstance(given, pool)
        assert signal.SIGINT not in signal.pthread_sigmask(signal.SIG_BLOCK, set())
    workers, others = pool.made
    assert workers == 3
    assert others["mp_context"].get_start_method() == "spawn"
    assert others["initializer"] is processes._prepare
    assert pool.submitted == [(first, True)] * 3


@pytest.mark.parametrize(("alone", "workers"), [(True, 1), (True, 2), (False, 1), (False, 4)])
def test_who_computes(
    pool: type[Pool], monkeypatch: pytest.MonkeyPatch, alone: bool, workers: int
) -> None:
    """This process, if it is one and computes in one thread; results in the order of the items."""
    monkeypatch.setattr(processes, "in_one_thread", lambda: alone)
    pool.made = (0, {})
    found = list(processes.mapped(lambda x: 2 * x, [3, 1, 2], workers))
    assert found == [6, 2, 4]
    assert pool.made[0] == (0 if alone and workers == 1 else workers)


def test_a_process_that_dies(pool: type[Pool], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(pool, "broken", True)
    with pytest.raises(SimulationError, match="a worker process died") as caught:
        list(processes.mapped(abs, [1], 2))
    assert caught.value.evidence == {"workers": 2}


@pytest.mark.parametrize(
    ("blas", "openmp", "one"),
    [("1", None, True), (None, "1", True), ("1", "4", True), ("4", "1", False),
     (None, None, False), (None, "2", False)],
)  # fmt: skip
def test_threads_of_this_process(
    monkeypatch: pytest.MonkeyPatch, blas: str | None, openmp: str | None, one: bool
) -> None:
    """OpenBLAS reads its own name first."""
    start = {"OPENBLAS_NUM_THREADS": blas, "OMP_NUM_THREADS": openmp, "MKL_NUM_THREADS": None}
    monkeypatch.setattr(processes, "_AT_START", start)
    assert processes.in_one_thread() is one


def test_processes_end_with_their_parent(monkeypatch: pytest.MonkeyPatch) -> None:
    """A thread that holds nobody up waits for the parent, and then ends the process."""
    told: list[Any] = []
    monkeypatch.setattr(processes.os, "_exit", lambda status: told.append(status))
    parent = SimpleNamespace(join=lambda: told.append("waited"))
    monkeypatch.setattr(processes, "parent_process", lambda: None)
    processes._end_with_parent()
    assert told == []
    monkeypatch.setattr(processes, "parent_process", lambda: parent)
    processes._end_with_parent()
    assert told == ["waited", 1]
    threads: list[dict[str, Any]] = []

    def thread(**words: Any) -> Any:
        threads.append(words)
        return SimpleNamespace(start=lambda: threads.append({"started": True}))

    monkeypatch.setattr(processes.threading, "Thread", thread)
    processes._prepare()
    assert threads == [
        {"target": processes._end_with_parent, "daemon": True}, {"started": True},
    ]  # fmt: skip


# Sensitivities, and the time of one evaluation.


def row(per: tuple[float, float, float], off: float = 0.0, path: str = "x") -> Sensitivity:
    control = np.array(per) + np.array([0.0, off, 0.0])
    return Sensitivity(path=path, value=2.5, unit="mm", per=np.array(per), control=control)


def test_sensitivities_of_which_two_ways_differ() -> None:
    """By the largest effect of the number, whatever its sign; a small one counts as a tenth."""
    for per, size in (
        ((1.0, 0.5, -8.0), 8.0), ((-1.0, -0.5, -8.0), 8.0), ((3.0, 8.0, 1.0), 8.0),
        ((0.01, -0.02, 0.03), 0.1),
    ):  # fmt: skip
        edge = DOUBTFUL * size
        for sign in (1.0, -1.0):
            assert not row(per, sign * 0.99 * edge).doubtful
            assert row(per, sign * 1.01 * edge).doubtful
        assert row(per, -0.5).disagreement == pytest.approx(0.5)
    assert row((1.0, np.nan, 1.0)).doubtful


def test_sensitivities_as_plain_data() -> None:
    rows = (row((1.0, -5.0, 2.0), path="a"), row((-4.0, 3.0, 0.5), 1.0, "b"),
            row((2.0, 0.25, -3.0), path="c"))  # fmt: skip
    found = Sensitivities(
        model="e62", stop="jaw", speed_rpm=450.0, premise_holds=False, amplitude_rad=0.125,
        transition_time_s=0.25, clamping_force_N=75.0, rows=rows,
    )  # fmt: skip
    order = {
        "rebound_amplitude_1": "bca", "duration_s": "abc", "clamping_force_N": "cab",
    }  # fmt: skip
    assert {name: "".join(item.path for item in found.ranked(name)) for name in QUANTITIES} == order
    told = found.record()
    assert told.pop("percent_per_unit")[1] == {
        "path": "b", "value": 2.5, "unit": "mm", "rebound_amplitude_1": -4.0, "duration_s": 3.0,
        "clamping_force_N": 0.5, "disagreement_of_two_ways": 1.0, "doubtful": True,
    }  # fmt: skip
    assert told == {
        "model": "e62", "speed_rpm": 450.0, "premise_holds": False, "rebound_amplitude_1": 0.125,
        "duration_s": 0.25, "mean_clamping_force_N": 75.0,
    }  # fmt: skip


def test_numbers_that_nothing_asked_for_depends_on() -> None:
    """Inertias of shafts, places on the index scale and axes that go with their points."""
    left_out = {
        "crank_axis_mm": [1.0, 2.0], "guide_axis_mm": [3.0, 4.0], "rated_speed_rpm": 650.0,
        "reference_angle_deg": 5.0, "reference_index": 6.0, "reflected_inertia_kg_m2": 7.0,
        "reflected_mass_kg": 8.0, "shaft_damping_ratio": 9.0, "shaft_frequency_hz": 10.0,
    }  # fmt: skip
    document = {
        "a": {"ratio": 2.0, "teeth": 17, "joint": "jaw", "closed": True, **left_out},
        "b": {"deep": {"restitution": 0.25}, "reference_angle_rad": 1.0},
    }
    assert sensitivity._numbers(document, "drives") == [
        "drives.a.ratio", "drives.a.teeth", "drives.b.deep.restitution",
        "drives.b.reference_angle_rad",
    ]  # fmt: skip
    assert sensitivity._numbers(None, "dampers") == []


def test_what_one_evaluation_is_asked_for(monkeypatch: pytest.MonkeyPatch) -> None:
    """Places and rates of the turn at evenly spaced times, with nothing closed."""
    asked: list[Any] = []
    system = SimpleNamespace(
        shaft=SimpleNamespace(driven=lambda t: ("driven", t.tolist())),
        constraint_set=lambda closed: ("rows", closed),
        accelerations=lambda *words: words,
    )
    trajectory = SimpleNamespace(
        span=(1.0, 2.0), evaluate=lambda t: SimpleNamespace(q=("q", t.tolist()), v=("v", t[0]))
    )

    def run(mechanism: str, case: Case) -> Any:
        asked.append((mechanism, case.speed_rpm, case.window.value, case.start_index))
        return SimpleNamespace(system=system, trajectory=trajectory)

    def timed(function: Callable[[], object], repeats: int) -> Any:
        asked.append((function(), repeats))
        return SimpleNamespace(median_ms=30.0)

    monkeypatch.setattr(cost, "simulate", run)
    monkeypatch.setattr(cost, "timed", timed)
    chain: Any = "chain"
    assert cost._evaluation_ms(chain, states=3) == 10.0
    times = [1.0, 1.5, 2.0]
    assert asked == [
        ("chain", 60.0, "cycle", 0.0),
        ((("driven", times), ("q", times), ("v", 1.0), ("rows", frozenset())), 5),
    ]


# Numbers of one case.


@pytest.mark.parametrize("value", [0.0, 1.0, 0.5, 0, 1, np.float32(0.25)])
def test_one_number_is_that_of_a_column(value: Any) -> None:
    """What lies plainly inside is taken as it is; all else is judged as a column is."""
    found = inputs.number("restitution", value, 0.0, 1.0)
    assert type(found) is float
    assert found == inputs.column("restitution", value, 0.0, 1.0)[0]


# Draws.


def test_how_many_random_machines_are_plain(monkeypatch: pytest.MonkeyPatch) -> None:
    """One in four has the numbers of its file but for the other restitution, of any of three."""
    seen: list[tuple[str, set[str]]] = []

    def load(model: str, overrides: dict[str, float]) -> Any:
        seen.append((model, set(overrides)))
        return model

    monkeypatch.setattr(premises, "load", load)
    machines = 1200
    groups = list(premises.draw(machines * premises.GROUP, 5))
    assert len(groups) == len(seen) == machines
    plain = sum(names == {"stops.steeve.restitution"} for _, names in seen)
    # Six standard deviations of a binomial count.
    assert abs(plain - machines / 4) < 6.0 * (machines * 3 / 16) ** 0.5 < machines / 12
    for model in premises.MODELS:
        share = sum(name == model for name, _ in seen) / machines
        assert share == pytest.approx(1 / 3, abs=0.09)
