"""What studies refuse, with evidence, and branches of theirs that few machines take."""

from __future__ import annotations

import io
import json
import math
from collections.abc import Callable, Iterator
from concurrent.futures import Future
from concurrent.futures.process import BrokenProcessPool
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pyarrow as pa
import pytest

from benchmarks.run_time import certified
from nipper_pin import Mechanism
from nipper_pin.errors import InputError, ModelError, SimulationError
from nipper_pin.hybrid.result.solution import Outcome
from nipper_pin.study import cases, processes
from nipper_pin.study.folders import make_folder
from nipper_pin.study.identify import write
from nipper_pin.study.identify.fitting import profiles, suspects
from nipper_pin.study.identify.problem import problem, targets
from nipper_pin.study.identify.problem import working_cycle as working
from nipper_pin.study.identify.problem.targets import Condition, Target
from nipper_pin.study.optimise import run
from nipper_pin.study.optimise.points import bounces, evaluate, one_machine
from nipper_pin.study.optimise.problem import quantities
from nipper_pin.study.optimise.search import infeasible
from nipper_pin.study.optimise.search import stages as searches
from nipper_pin.study.optimise.work import Work
from nipper_pin.study.sweep import local
from nipper_pin.study.sweep.chunks import DefectError
from nipper_pin.study.sweep.results import chunk_file, record
from nipper_pin.study.sweep.results import store as store_module
from nipper_pin.study.sweep.results.chunk_file import DamageError
from nipper_pin.study.sweep.results.table import SweepTable
from nipper_pin.study.sweep.study_file import read_study
from nipper_pin.tolerances.study import FEASIBLE

# Cases, costs, folders.


def test_columns_of_unequal_length() -> None:
    values = np.array([[1.0, 2.0], [3.0, 4.0], [5.0, 6.0]])
    wide = cases._joined(values, [1], np.array([[7.0]]))
    assert wide.tolist() == [[1.0, 7.0], [3.0, 7.0], [5.0, 7.0]]
    assert values[0, 1] == 2.0
    assert cases._joined(values[:1], [0], np.array([[8.0], [9.0]])).tolist() == [
        [8.0, 2.0], [9.0, 2.0],
    ]  # fmt: skip
    with pytest.raises(InputError, match="need the same number of cases"):
        cases._joined(values, [0], np.array([[1.0], [2.0]]))


def test_a_reference_that_is_missing() -> None:
    with pytest.raises(InputError, match=r"nothing\.json is missing: get the checkout") as caught:
        certified._document("nothing.json")
    assert caught.value.evidence == {"file": "nothing.json"}


def test_folders_that_cannot_be_made(tmp_path: Path) -> None:
    make_folder(tmp_path / "a" / "b")
    make_folder(tmp_path / "a" / "b")
    assert (tmp_path / "a" / "b").is_dir()
    (tmp_path / "file").write_text("", encoding="utf-8")
    for place in (tmp_path / "file", tmp_path / "file" / "below"):
        with pytest.raises(InputError, match=r"cannot be made a folder \(\w+") as caught:
            make_folder(place)
        assert caught.value.evidence == {"folder": str(place)}


# Identify.


AT = Condition(650.0, 0.25)


def target(name: str, quantity: str, **others: Any) -> Target:
    return Target(name=name, quantity=quantity, value=1.0, sigma=1.0, **{"at": AT, **others})


def test_targets_that_a_transition_has_not(monkeypatch: pytest.MonkeyPatch, e62: Mechanism) -> None:
    """Values, changes since another setting, and names of those that are missing."""
    since = Condition(450.0)
    known = {
        AT: {"duration_s": 3.0, "rebound_amplitude_1": 5.0, "rebound_amplitude_2": math.nan},
        since: {"duration_s": 2.0, "rebound_amplitude_1": 0.0},
    }
    asked: list[Any] = []

    def quantities_of(_: Any, at: Condition, *words: Any, true: bool) -> Any:
        asked.append((at, words, true))
        return known[at]

    monkeypatch.setattr(targets, "transition_quantities", quantities_of)
    plain, change = target("a", "duration_s"), target("b", "duration_s", since=since)
    values = targets.predict(e62, [plain, change], 1e-6, 0.5, true=True)
    assert values.tolist() == [3.0, 0.5]
    assert asked == [(AT, (1e-6, 0.5), True), (since, (1e-6, 0.5), True)]
    none = [target("c", "rebound_amplitude_2"), plain,
            target("d", "rebound_amplitude_1", since=since)]  # fmt: skip
    with pytest.raises(SimulationError, match="no value for c, d; leave these") as caught:
        targets.predict(e62, none, 1e-6, None)
    assert caught.value.evidence == {"targets": ["c", "d"]}
    assert asked[-1] == (since, (1e-6, None), False)


def test_transitions_without_rest(monkeypatch: pytest.MonkeyPatch, e62: Mechanism) -> None:
    """Named with the setting; the case has the accuracy and threshold that were asked for."""
    seen: list[Any] = []

    def simulate(mechanism: Mechanism, case: Any) -> Any:
        seen.append((mechanism.stop("jaw").restitution, case))
        return SimpleNamespace(collisions=(), transitions=(), outcome=Outcome.NO_REST)

    monkeypatch.setattr(targets, "simulate", simulate)
    with pytest.raises(SimulationError, match="e62 at 650 r/min: ") as caught:
        targets.transition_quantities(e62, AT, 1e-6, 0.5, true=False)
    assert caught.value.evidence == {"condition": AT._asdict()}
    ((restitution, case),) = seen
    assert (restitution, case.speed_rpm, case.rest_rate) == (0.25, 650.0, 0.5)
    assert (case.resolution.tolerance, case.max_collisions) == (1e-6, 500)


def test_stiffnesses_need_one_spring(e62: Mechanism) -> None:
    stiff = Condition(650.0, None, 9500.0)
    one = targets.with_settings(e62, stiff)
    assert one.springs[0].stiffness == 9500.0
    assert one.stop("jaw") == e62.stop("jaw")
    spring = e62.springs[0]
    two = replace(e62, springs=(spring, replace(spring, name="second")))
    with pytest.raises(InputError, match="e62 has 2 springs") as caught:
        targets.with_settings(two, stiff)
    assert caught.value.evidence == {"springs": ["steeve", "second"]}
    aim = target("a", "duration_s", at=stiff)
    for mechanism in (two, replace(e62, springs=())):
        with pytest.raises(ModelError, match="only with a model that has one spring") as no:
            problem._check_fit(mechanism, [target("b", "duration_s"), aim], None, "fit.toml")
        told = no.value.evidence
        assert (told["file"], told["key"], told["value"]) == ("fit.toml", "stiffness", 9500.0)
        problem._check_fit(mechanism, [target("b", "duration_s")], None, "fit.toml")
    problem._check_fit(e62, [aim], None, "fit.toml")


def test_working_cycles_of_models_without_one(
    monkeypatch: pytest.MonkeyPatch, e62: Mechanism
) -> None:
    monkeypatch.setattr(working, "unfit", lambda mechanism: f"{mechanism.name} has none")
    with pytest.raises(InputError, match="e62 has none") as caught:
        working.working_cycle(e62, 650.0)
    assert caught.value.evidence == {"model": "e62", "initial": ["steeve"]}


def test_a_stop_that_does_not_open_again() -> None:
    """The walk ends after a turn; a fall through zero is found to the last digits."""
    walk: Any = SimpleNamespace(
        _dt=0.1, stop=SimpleNamespace(name="jaw"),
        system=SimpleNamespace(mechanism=SimpleNamespace(name="made_up")),
    )  # fmt: skip
    asked: list[float] = []

    def at(function: Callable[[float], float]) -> Callable[[float], Any]:
        def read(t: float) -> Any:
            asked.append(t)
            return [math.nan, function(t)]

        return read

    walk._root = lambda *words: working._Walk._root(walk, *words)
    walk.at = at(lambda t: 0.37**3 - t**3)
    assert working._Walk.return_of(walk, 1, 1.0) == pytest.approx(0.37, rel=1e-12)
    for function in (lambda t: 1.0 + t, lambda t: t - 0.5, lambda t: -1.0 - t):
        walk.at = at(function)
        asked.clear()
        with pytest.raises(SimulationError, match="made_up: the stop jaw does not open") as caught:
            working._Walk.return_of(walk, 1, 1.0)
        assert caught.value.evidence == {"stop": "jaw"}
        assert 1.0 <= max(asked) < 1.2


def test_a_profile_of_the_only_number() -> None:
    """Half the sum of squares where nothing is left to fit; infinite where there is no machine."""
    rows = lambda z: np.array([3.0 * z[0], 4.0])  # noqa: E731
    objective: Any = SimpleNamespace(rows=rows)
    assert profiles._held(objective, np.array([0.9]), 0, 1.0) == 12.5

    def none(_: Any) -> Any:
        message = "no machine"
        raise SimulationError(message)

    assert profiles._held(SimpleNamespace(rows=none), np.array([0.9]), 0, 1.0) == math.inf  # type: ignore[arg-type]


def test_units_are_suspected_by_the_fit_where_the_model_itself_fails(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A thousand times what is found, though nothing is known of the model's own numbers."""
    monkeypatch.setattr(suspects, "_units", lambda *_: {})
    monkeypatch.setattr(suspects, "_question", lambda factor, _: f"what? {factor:g}")

    def predicted(_: Any) -> Any:
        message = "it jams"
        raise SimulationError(message)

    aims = [replace(target("a", "duration_s"), value=4.0),
            replace(target("b", "duration_s"), value=6.0)]  # fmt: skip
    objective: Any = SimpleNamespace(mechanism=lambda _: None, predicted=predicted, start=None,
                                     problem=SimpleNamespace(targets=aims))  # fmt: skip
    (told,) = suspects.suspected_units(objective, np.zeros(0), np.array([4e-3, 6e-3]))
    assert told == "duration_s is wanted about 1000 times what? 1000"


URDF = """<robot name="r"><link name="plain"><visual name="v"><geometry><box/></geometry></visual>
<collision name="c"><geometry><box/></geometry></collision></link>
<link name="drawn"><visual name="m"><geometry><mesh filename="m.stl"/></geometry></visual>
<visual name="b"><geometry><box/></geometry></visual>
<collision name="d"><geometry><sphere radius="1"/></geometry></collision></link></robot>"""


def test_moved_links_show_their_plain_bodies() -> None:
    """Where a mesh was drawn for other places, all of the link is redrawn; other links stay."""
    root = ElementTree.fromstring(URDF)
    write._show_collision_shapes(root)
    found = {
        link.get("name"): [(item.tag, item.get("name")) for item in link]
        for link in root.findall("link")
    }
    assert found == {
        "plain": [("visual", "v"), ("collision", "c")],
        "drawn": [("collision", "d"), ("visual", "d")],
    }
    assert len(root.findall(".//visual/geometry/sphere")) == 1


def test_meshes_move_with_a_model(tmp_path: Path) -> None:
    """Those that are there, into folders of their names; one that is only drawn may be missing."""
    old, new = tmp_path / "old", tmp_path / "new"
    (old / "deep").mkdir(parents=True)
    (old / "deep" / "m.stl").write_text("mesh", encoding="utf-8")
    text = '<robot><mesh filename="gone.stl"/><mesh filename="deep/m.stl"/></robot>'
    write._copy_meshes(ElementTree.fromstring(text), old, new)
    assert [item.relative_to(new).as_posix() for item in new.rglob("*.stl")] == ["deep/m.stl"]
    assert (new / "deep" / "m.stl").read_text(encoding="utf-8") == "mesh"


@pytest.mark.parametrize("moves", [True, False])
def test_provenance_of_identified_numbers(moves: bool) -> None:
    """Identified numbers first, then what the model said of others."""
    path = "points.jaw.x_mm" if moves else "stops.jaw.restitution"
    item = SimpleNamespace(path=path, low=1.0, high=4.0, start=2.0)
    fit: Any = SimpleNamespace(
        objective=SimpleNamespace(problem=SimpleNamespace(parameters=[item], targets=[1, 2, 3])),
        values={path: 3.125},
    )
    found = write._provenance(fit, {path: "measured", "b": 7})
    identified = (
        "identified: 3.125 between 1 and 4 (before: 2) from 3 targets; not measured, not the "
        "maker's"
    )
    visuals = {"urdf.visuals": "illustration: the collision shapes"} if moves else {}
    assert found == {path: identified, **visuals, "b": "7"}
    assert next(iter(found)) == path
    assert write._provenance(fit, "no table") == {path: identified, **visuals}


# Optimise.


MACHINE = SimpleNamespace(name="machine")


def point_source(**changes: Any) -> Any:
    given = {
        "parameters": [], "sources": SimpleNamespace(build=lambda: MACHINE), "rest_rate": None,
        "tolerance": 1e-8, **changes,
    }  # fmt: skip
    return SimpleNamespace(_problem=SimpleNamespace(**given))


def test_why_a_search_has_no_tables(monkeypatch: pytest.MonkeyPatch) -> None:
    """Numbers of the machine, numba that is missing, a machine that does not fit, or an error."""

    def sample(source: Any) -> Any:
        transitions = bounces.Transitions(source._problem)
        return transitions._sampled()

    monkeypatch.setattr(one_machine, "installed", lambda name: name == "numba")
    monkeypatch.setattr(bounces, "unfit", lambda _: None)
    monkeypatch.setattr(bounces, "build", lambda machine: f"tables of the {machine.name}")
    assert sample(point_source()) == (
        "tables of the machine", "one machine: its tables are sampled once",
    )  # fmt: skip
    names = [SimpleNamespace(name="x", target=SimpleNamespace(kind="model")),
             SimpleNamespace(name="y", target=SimpleNamespace(kind="speed")),
             SimpleNamespace(name="z", target=SimpleNamespace(kind="model"))]  # fmt: skip
    assert sample(point_source(parameters=names)) == (
        None, "x, z change the machine, and so the tables",
    )  # fmt: skip
    assert sample(point_source(parameters=names[1:2]))[0] is not None
    monkeypatch.setattr(bounces, "unfit", lambda machine: f"no {machine.name}")
    assert sample(point_source()) == (None, "no machine")

    def fails() -> None:
        message = "it jams"
        raise InputError(message)

    assert sample(point_source(sources=SimpleNamespace(build=fails))) == (None, "it jams")
    monkeypatch.setattr(one_machine, "installed", lambda name: name != "numba")
    assert sample(point_source()) == (
        None, "the reduced engine needs numba, which is not installed",
    )  # fmt: skip


def test_transitions_that_do_not_rest() -> None:
    rests: Any = SimpleNamespace(outcome=Outcome.AT_REST)
    assert bounces._at_rest(rests) is rests
    with pytest.raises(SimulationError) as caught:
        bounces._at_rest(SimpleNamespace(outcome=Outcome.NO_REST))  # type: ignore[arg-type]
    assert caught.value.message == Outcome.NO_REST.value
    assert caught.value.evidence == {"outcome": "NO_REST"}


def test_designs_without_a_quantity() -> None:
    """Asked quantities alone have to be there."""
    problem = SimpleNamespace(
        speed=lambda z: 600.0 + z[0], quantities=("duration_s", "rebound_amplitude_1")
    )
    source: Any = SimpleNamespace(problem=problem)
    values = {"duration_s": 0.5, "rebound_amplitude_1": 2.0, "rebound_time_s_1": math.nan}
    known: Any = SimpleNamespace(
        cycle=None, turn=None, bounces=SimpleNamespace(values=values, turn=None)
    )
    assert evaluate.Evaluator._values(source, known, np.array([5.0])) == pytest.approx(
        {"speed_rpm": 605.0, **values}, nan_ok=True
    )
    values |= dict.fromkeys(problem.quantities, math.nan)
    with pytest.raises(SimulationError, match="no duration_s, rebound_amplitude_1") as caught:
        evaluate.Evaluator._values(source, known, np.array([5.0]))
    assert caught.value.evidence == {"missing": ["duration_s", "rebound_amplitude_1"]}


@pytest.mark.parametrize("turns", [True, False])
@pytest.mark.parametrize("thin", [True, False])
def test_designs_with_a_cycle(monkeypatch: pytest.MonkeyPatch, turns: bool, thin: bool) -> None:
    """By kinematics, and over that what turns say; both in half of their samples if asked."""
    monkeypatch.setattr(evaluate, "thinned", lambda cycle: f"half {cycle}")
    monkeypatch.setattr(evaluate, "cycle_values", lambda cycle: {"a": cycle, "b": cycle})
    monkeypatch.setattr(evaluate, "turn_values", lambda turn, thin: {"b": (turn, thin)})
    monkeypatch.setattr(evaluate.np, "isfinite", lambda _: True)
    source: Any = SimpleNamespace(
        problem=SimpleNamespace(speed=lambda _: 600.0, quantities=("a", "b"))
    )
    known: Any = SimpleNamespace(
        cycle="cycle",
        turn=None,
        bounces=SimpleNamespace(values={}, turn="turn" if turns else None),
    )
    found = evaluate.Evaluator._values(source, known, np.zeros(1), thin=thin)
    cycle = "half cycle" if thin else "cycle"
    assert found == {"speed_rpm": 600.0, "a": cycle, "b": ("turn", thin) if turns else cycle}


def test_quantities_of_a_cycle_need_one(monkeypatch: pytest.MonkeyPatch, e62: Mechanism) -> None:
    monkeypatch.setattr(quantities, "unfit", lambda _: "it has three phases")
    quantities.check_fit(("duration_s", "speed_rpm"), e62, "here")
    with pytest.raises(InputError) as caught:
        quantities.check_fit(("duration_s", "stop_force_N"), e62, "here")
    assert caught.value.message == "here: stop_force_N cannot be used: it has three phases"
    assert caught.value.evidence == {"quantity": "stop_force_N", "model": "e62"}


@pytest.mark.parametrize("place", [0.25, 1.25, 2.5, 3.75])
def test_a_dip_belongs_to_the_interval_that_it_lies_in(place: float) -> None:
    """Of a parabola, that its spline is: the others have their least value at an end."""
    knots = np.array([0.0, 1.0, 2.0, 3.0, 4.0])
    found = quantities.lowest(knots, (knots - place) ** 2)
    wanted = [0.0 if k < place < k + 1 else min((k - place) ** 2, (k + 1 - place) ** 2)
              for k in range(4)]  # fmt: skip
    assert found == pytest.approx(wanted, abs=1e-12)


def test_designs_that_cannot_be_simulated_again() -> None:
    design: Any = object()
    assert run._known(design) is design
    with pytest.raises(SimulationError, match="unforeseen"):
        run._known(None)


def test_screens_without_a_machine(monkeypatch: pytest.MonkeyPatch) -> None:
    """Shares in order."""
    monkeypatch.setattr(
        searches, "samples", lambda *_: np.arange(2.0 * searches.SHARE + 2.0)[:, None]
    )
    asked: Any = SimpleNamespace(text=lambda: b"text")
    shares: list[Any] = []

    def work(values: Any) -> Any:
        def do_all(tasks: Any) -> list[Any]:
            shares.extend((task.args[0], len(task.args[1])) for task in tasks)
            return [
                tuple(SimpleNamespace(values=values, why=f"no {z[0]:g}") for z in task.args[1])
                for task in tasks
            ]

        return SimpleNamespace(all=do_all)

    found = searches.screen(asked, 3, work({"a": 1.0}))
    size = searches.SHARE
    assert len(found) == 2 * size + 2
    assert [item.why.split()[1] for item in found[size - 1 : size + 1]] == [
        f"{size - 1}", f"{size}",
    ]  # fmt: skip
    assert shares == [(b"text", size), (b"text", size), (b"text", 2)]


def test_a_check_that_finds_no_feasible_design(monkeypatch: pytest.MonkeyPatch) -> None:
    """Only what meets the limits is polished."""
    monkeypatch.setattr(searches.Search, "scales", lambda *_: "scales")
    asked = SimpleNamespace(with_aim=lambda _: SimpleNamespace(text=lambda: b"text"))
    for feasible in (False, True):
        found = SimpleNamespace(feasible=feasible, z=(0.5,))
        done: list[str] = []
        work = SimpleNamespace(
            one=lambda task: done.append(task.func.__name__) or found,  # noqa: B023
            all=lambda tasks: (
                done.extend(item.func.__name__ for item in tasks)  # noqa: B023
                or ["polished"]
            ),
            mapper=None,
        )
        made: Any = searches.Search
        search = made(problem=asked, seen=(), starts=1, seed=2, work=work)
        aim: Any = "aim"
        assert search.check(aim) == (found, "polished" if feasible else None)
        assert done == (["evolve", "descend"] if feasible else ["evolve"])


def test_limits_that_are_kept_are_not_told_as_broken(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of three limits the one that is missed by more than its tolerance, and what it is alone."""
    Limit = type("Limit", (), {"__init__": lambda self, q: setattr(self, "quantity", q),
                               "__str__": lambda self: f"{self.quantity} <= 1"})  # fmt: skip
    limits = tuple(Limit(name) for name in ("a", "b", "c"))  # type: ignore[call-arg]
    point = SimpleNamespace(
        slacks=(0.5, -3.0, -0.5 * FEASIBLE * 2.0), values={"a": 0.5, "b": 4.0, "c": 1.0}
    )
    monkeypatch.setattr(infeasible, "Evaluator", lambda _: SimpleNamespace(at=lambda _z: point))
    monkeypatch.setattr(
        infeasible, "replace", lambda _, limits: SimpleNamespace(text=lambda: limits)
    )
    tasks: list[Any] = []

    def do_all(given: Any) -> list[Any]:
        tasks.extend(given)
        return [SimpleNamespace(feasible=False, violation=0.25)]

    asked: Any = SimpleNamespace(
        limits=limits,
        units={"a": "", "b": "N", "c": ""},
        numbers=lambda z: {"x": float(z[0])},
        bounds_at=lambda z: (f"x <= {z[0]:g}",),
    )
    scales: Any = infeasible.Scales(1.0, (1.0, 8.0, 2.0))
    nearest: Any = SimpleNamespace(z=(0.75,))
    work: Any = SimpleNamespace(all=do_all)
    error = infeasible._infeasible(asked, scales, nearest, work)
    assert "nearest (x = 0.75) breaks b <= 1: 4 is reached, missed by 3 N (alone it is still" in (
        error.message
    )
    assert "missed by 2)" in error.message
    (broken,) = error.evidence["limits"]  # type: ignore[misc]
    assert broken == {
        "limit": "b <= 1", "reached": 4.0, "missed_by": 3.0, "can_be_met_alone": False,
        "missed_by_alone": 2.0,
    }  # fmt: skip
    assert error.evidence["numbers"] == {"x": 0.75}
    (task,) = tasks
    assert task.args == ((limits[1],), infeasible.Scales(1.0, (8.0,)), (0.75,))


@pytest.fixture(name="work")
def made_up_work() -> tuple[Any, list[tuple[int, int]], Any]:
    """Work whose processes are a stand-in that is called here."""
    told: list[tuple[int, int]] = []

    class Pool:
        broken = False

        def __init__(self) -> None:
            self.ends: list[Any] = []

        def submit(self, task: Callable[[], Any]) -> Future[Any]:
            future: Future[Any] = Future()
            if self.broken:
                future.set_exception(BrokenProcessPool())
            else:
                future.set_result(task())
            return future

        def map(self, function: Any, places: Any, chunksize: int) -> Iterator[Any]:
            assert chunksize == 4
            if self.broken:
                raise BrokenProcessPool
            return map(function, places)

        def shutdown(self, **words: Any) -> None:
            self.ends.append(words)

    pool = Pool()
    work: Any = Work(3, lambda done, known: told.append((done, known)))
    work._workers._pool = pool
    return work, told, pool


def test_parts_of_a_search_in_processes(work: Any) -> None:
    """In their order whoever ends first."""
    doing, told, pool = work
    assert doing.all([lambda: 7, lambda: 11, lambda: 9]) == [7, 11, 9]
    assert told[0] == (0, 3)
    assert told[-1] == (3, 3)
    assert doing.one(lambda: 5) == 5
    assert told[-1] == (4, 4)
    assert doing.mapper(abs, [-3, 2]) == [3, 2]
    with doing:
        pass
    assert pool.ends == []
    message = "stop"
    with pytest.raises(RuntimeError, match=message), doing:
        raise RuntimeError(message)
    assert pool.ends == [{"cancel_futures": True}]


def test_a_search_whose_process_dies(work: Any) -> None:
    doing, _, pool = work
    pool.broken = True
    for act in (lambda: doing.all([lambda: 7]), lambda: doing.mapper(abs, [1])):
        with pytest.raises(SimulationError, match="a worker process died, perhaps") as caught:
            act()
        assert caught.value.evidence == {"workers": 3}


# Sweep.


SWEEP = """
format = 1
model = "e62"
[case]
speed_rpm = 650.0
[parameters.restitution]
low = 0.1
high = 0.2
points = POINTS
[parameters.preload]
low = 10.0
high = 12.0
points = 1000000
"""


def test_sweeps_of_too_many_scenarios(tmp_path: Path) -> None:
    file = tmp_path / "sweep.toml"
    file.write_text(SWEEP.replace("POINTS", "1000000"), encoding="utf-8")
    assert len(read_study(str(file)).job.axes) == 2
    file.write_text(SWEEP.replace("POINTS", "1000001"), encoding="utf-8")
    with pytest.raises(InputError, match=r"1000001000000 scenarios; at most 10+$") as caught:
        read_study(str(file))
    assert caught.value.evidence == {"key": "parameters", "scenarios": 1_000_001_000_000}


def test_sweeps_whose_process_dies(monkeypatch: pytest.MonkeyPatch) -> None:
    """What is finished comes first; a chunk with a defect is given as such."""
    defect = DefectError("odd")
    outcomes: list[Any] = [b"one", defect]

    def computed(*_: Any) -> Any:
        what = outcomes.pop(0)
        if isinstance(what, Exception):
            raise what
        return what

    class Pool:
        def __enter__(self) -> Pool:
            return self

        def __exit__(self, *_: object) -> None:
            """Nothing is left."""

        def shutdown(self, **_: bool) -> None:
            """What waits is left out."""

        def submit(self, task: Callable[[], Any]) -> Future[Any]:
            future: Future[Any] = Future()
            if outcomes:
                future.set_result(task())
            else:
                future.set_exception(BrokenProcessPool())
            return future

    asked: list[Any] = []
    monkeypatch.setattr(local, "run_chunk", computed)
    monkeypatch.setattr(
        processes,
        "fresh_processes",
        lambda workers, first: asked.append((workers, first)) or Pool(),
    )
    chunks = [SimpleNamespace(start=k) for k in range(3)]
    tasks: Any = [(chunk, np.zeros(1)) for chunk in chunks]
    found: list[Any] = []
    with pytest.raises(SimulationError, match="a worker process died, perhaps") as caught:
        found.extend(local.on_this_machine(b"job", tasks, 5))
    assert caught.value.evidence == {"workers": 5}
    assert asked == [(5, local.wake)]
    assert all(answer == {0: b"one", 1: defect}[chunk.start] for chunk, answer in found)


def rows(start: int, stop: int, plan: str = "mine") -> pa.Table:
    table = pa.table({"scenario": np.arange(start, stop)})
    return table.replace_schema_metadata({chunk_file._ABOUT: json.dumps({"plan": plan})})


def test_rows_of_another_chunk() -> None:
    chunk_file.check(rows(3, 6), "x", 3, 6, "mine")
    for table in (rows(2, 6), rows(3, 7), rows(4, 7)):
        with pytest.raises(DamageError) as caught:
            chunk_file.check(table, "x", 3, 6, "mine")
        assert caught.value.message == "x: holds other scenarios than 3 to 5"
        assert caught.value.evidence == {"file": "x"}
    with pytest.raises(DamageError) as caught:
        chunk_file.check(rows(3, 6, "other"), "x", 3, 6, "mine")
    assert caught.value.message == "x: holds scenarios of another plan"
    assert caught.value.evidence == {"file": "x"}


def test_chunks_that_cannot_be_read(tmp_path: Path) -> None:
    with pytest.raises(DamageError, match=r"gone: cannot be read \(No such file") as caught:
        chunk_file.read_file(tmp_path / "gone")
    assert caught.value.evidence == {"file": str(tmp_path / "gone")}
    (tmp_path / "bad").write_bytes(b"0123456789" * 9)
    with pytest.raises(DamageError, match=r"bad: damaged, or no chunk of a sweep") as caught:
        chunk_file.read_file(tmp_path / "bad")
    assert caught.value.evidence == {"file": str(tmp_path / "bad")}


def test_records_of_another_format(tmp_path: Path) -> None:
    file = tmp_path / "plan.json"
    whole = {
        "format": record._FORMAT, "hash": "", "identity": "", "title": "", "model": "",
        "scenarios": 1, "axes": [], "samples": None, "quantities": [], "description": {}, "a": 1,
    }  # fmt: skip
    file.write_text(json.dumps(whole), encoding="utf-8")
    assert record.read_document(file) == whole
    for key in whole.keys() - {"format", "a"}:
        file.write_text(json.dumps({**whole, key: 1.5}), encoding="utf-8")
        with pytest.raises(InputError, match="not the plan of a sweep, or a damaged one"):
            record.read_document(file)
    file.write_text(json.dumps({"format": record._FORMAT + 1}), encoding="utf-8")
    with pytest.raises(InputError, match=f"and this version reads {record._FORMAT};") as caught:
        record.read_document(file)
    assert caught.value.evidence == {"file": str(file)}
    for text in ("[]", "{", "{}"):
        file.write_text(text, encoding="utf-8")
        with pytest.raises(InputError, match="not the plan of a sweep, or a damaged one"):
            record.read_document(file)


def test_chunks_without_a_plan(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Without chunks the plan is written; with chunks and no plan nothing is."""
    monkeypatch.setattr(store_module, "plan_record", lambda plan: {"plan": plan})
    chunks = tmp_path / "chunks"
    chunks.mkdir()
    (chunks / "0000001.parquet").write_bytes(b"")
    store: Any = SimpleNamespace(_folder=tmp_path, _chunks=chunks)
    taken_up = store_module.Store._taken_up
    plan: Any = "mine"
    with pytest.raises(InputError, match="holds chunks and no") as caught:
        taken_up(store, plan)
    assert caught.value.evidence == {"folder": str(tmp_path)}
    assert not (tmp_path / store_module.PLAN).exists()
    (chunks / "0000001.parquet").unlink()
    assert taken_up(store, plan) == "mine"
    written = json.loads((tmp_path / store_module.PLAN).read_text(encoding="utf-8"))
    assert written == {"plan": "mine"}


def test_a_table_of_a_sweep() -> None:
    """All rows as a frame of each library, a line, and a page that counts what is left."""
    table = pa.table({"a": list(range(15)), "b": [0.5 * k for k in range(15)]})
    made: Any = SweepTable
    fields = {
        "model": "e62", "title": "", "axes": ({"name": "a"}, {"name": "b"}), "scenarios": 2000,
        "stored": 1500, "table": table,
    }  # fmt: skip
    names = set(SweepTable.__dataclass_fields__)
    rest = {name: None for name in names - set(fields)}
    found = made(**{key: value for key, value in fields.items() if key in names}, **rest)
    assert repr(found) == "<SweepTable of e62: 15 scenarios over a, b>"
    assert found.to_frame("pyarrow") is table
    frame = found.to_frame("pandas")
    assert {name: frame[name].tolist() for name in frame} == table.to_pydict()
    page = found._repr_html_()
    assert "<b>sweep</b>" in page
    assert "1,500 of 2,000 stored" in page
    assert "and 3 more" in page
    assert page.count("<tr>") == 2 + 1 + 12
    assert io.StringIO(page).read().index("<th>a</th>") < page.index("<th>b</th>")


def test_stated_errors_of_a_design() -> None:
    """What half of the samples change and round-off; those of the transition where it has some."""
    known = SimpleNamespace(turn=None, bounces=SimpleNamespace(errors={"duration_s": 0.5}))
    whole = {"a": 8.0, "b": -400.0, "c": 0.0, "duration_s": 3.0}
    half = {"a": 8.25, "b": -400.5, "c": -0.125, "duration_s": 3.0}
    source: Any = SimpleNamespace(
        _known=lambda _: known, _values=lambda _known, _z, thin=False: half if thin else whole
    )  # fmt: skip
    found = evaluate.Evaluator.errors(source, np.zeros(1))
    assert found == pytest.approx(
        {"a": 0.25 + 8e-9, "b": 0.5 + 4e-7, "c": 0.125, "duration_s": 0.5}, rel=1e-12
    )


@pytest.mark.parametrize("cycle", [True, False])
def test_points_and_why_they_are_none(monkeypatch: pytest.MonkeyPatch, cycle: bool) -> None:
    """Slacks of the limits, by kinematics where there is a cycle; the reason of a failure."""
    asked: list[Any] = []
    monkeypatch.setattr(evaluate, "lowest", lambda *words: ("lowest", *words))
    monkeypatch.setattr(
        evaluate, "slack_rows", lambda *words: asked.append(words) or (np.ones(2), (0, 1))
    )
    waiting = SimpleNamespace(index="index", force="force")
    known = SimpleNamespace(
        cycle=SimpleNamespace(waiting=waiting) if cycle else None,
        engine="turn",
    )
    source: Any = SimpleNamespace(
        _known=lambda _: known, _values=lambda *_: {"a": 1.0},
        problem=SimpleNamespace(limits="limits"),
    )  # fmt: skip
    z = np.array([0.25])
    point = evaluate.Evaluator.at(source, z)
    assert (point.z.tolist(), point.values, point.owners) == ([0.25], {"a": 1.0}, (0, 1))
    assert (point.engine, point.why, point.usable) == ("turn", "", True)
    ((limits, values, rows),) = asked
    assert (limits, values) == ("limits", {"a": 1.0})
    assert rows == ("lowest", "index", "force") if cycle else rows.size == 0

    def fails(_: Any) -> Any:
        message = "it jams"
        raise SimulationError(message)

    source._known = fails
    none = evaluate.Evaluator.at(source, z)
    assert (none.why, none.usable, none.values, none.owners) == ("it jams", False, {}, ())
    assert (none.z.tolist(), none.rows.size, none.engine) == ([0.25], 0, "")
