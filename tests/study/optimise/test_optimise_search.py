"""Parts of a search: seeds that count, and engines that are named as what they were."""

from __future__ import annotations

import os
import time
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from nipper_pin import InputError, SimulationError
from nipper_pin.study.identify import working_cycle
from nipper_pin.study.optimise import Problem, optimise, read_problem, run
from nipper_pin.study.optimise.points import Evaluator, bounces, one_machine
from nipper_pin.study.optimise.problem.quantities import cycle_values, thinned
from nipper_pin.study.optimise.search.samples import SHARE, evolve, look, samples, scales
from nipper_pin.study.optimise.search.stages import Search, screen
from nipper_pin.study.optimise.work import Work
from nipper_pin.tolerances.study import QUANTITY_ROUND_OFF

MASS = Path(__file__).resolve().parents[2] / "verification" / "models" / "bouncing_mass"
HEAD = f"""
format = 1
model = "{MASS}"
minimise = "duration_s"
case = {{ speed_rpm = 60.0 }}
[parameters."stops.table.restitution"]
low = 0.05
high = 0.5
"""
LEAD = """
[parameters."drives.table.lead_mm_per_turn"]
low = 20.0
high = 100.0
"""
E62 = """
format = 1
model = "e62"
minimise = "rebound_amplitude_1"
case = { speed_rpm = 650.0 }
[parameters.preload]
low = 9.0
high = 14.0
"""


def problem(folder: Path, text: str) -> Problem:
    file = folder / "study.toml"
    file.write_text(text, encoding="utf-8")
    return read_problem(file)


def test_the_evolution_follows_its_seed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """One seed, one way; another seed looks at other points. So do the samples of the screen."""
    monkeypatch.setattr("nipper_pin.study.optimise.search.samples._GENERATIONS", 3)
    found = problem(tmp_path, HEAD)
    text = found.text()
    places = samples(found, 1)
    by = scales(found, found.aims[0], look(text, [tuple(z) for z in places.tolist()]))
    assert not np.array_equal(places, samples(found, 2))

    def run(seed: int) -> tuple[Any, list[tuple[float, ...]]]:
        asked: list[tuple[float, ...]] = []

        def here(function: Any, members: Any) -> list[Any]:
            rows = [np.array(z) for z in members]
            asked.extend(tuple(z) for z in rows)
            return [function(z) for z in rows]

        return evolve(text, by, seed, here), asked

    first, again, other = run(1), run(1), run(2)
    assert first == again
    assert first[1][:20] != other[1][:20]
    assert first[0].z != other[0].z
    # Every point that was asked for is counted, by the engine that found it.
    assert sum(first[0].engines.values()) == len(first[1])


def test_a_search_passes_its_seed_to_screen_and_evolution(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    seeds: list[int] = []

    def evolved(text: bytes, by: Any, seed: int, mapper: Any) -> Any:
        seeds.append(seed)
        return evolve(text, by, seed, mapper)

    monkeypatch.setattr("nipper_pin.study.optimise.search.stages.evolve", evolved)
    monkeypatch.setattr("nipper_pin.study.optimise.search.samples._GENERATIONS", 2)
    found = optimise(problem(tmp_path, HEAD), starts=1, seed=7, workers=1)
    assert seeds == [7]
    assert found.seed == 7


def test_a_search_without_its_tables_says_so(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Points are named by the engine that computed them, and the reason is in the result."""
    found = problem(tmp_path, E62)
    z = np.array([0.5])
    source = Evaluator(found)
    assert source.at(z).engine == "reduced"
    assert source.transitions.why == "one machine: its tables are sampled once"

    def refused(*_: object) -> None:
        message = "no tables today"
        raise InputError(message)

    monkeypatch.setattr(bounces, "build", refused)
    other = Evaluator(found)
    point = other.at(z)
    assert point.engine == "direct"
    assert other.transitions.why == "no tables today"
    # Both engines state relative errors below 1e-8 here.
    assert point.values["rebound_amplitude_1"] == pytest.approx(
        source.at(z).values["rebound_amplitude_1"], rel=1e-8
    )


def test_a_point_that_its_tables_do_not_know_is_counted_as_direct(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def beyond(*_: object, **__: object) -> None:
        message = "beyond the tables"
        raise SimulationError(message)

    monkeypatch.setattr(bounces, "transition", beyond)
    found = optimise(problem(tmp_path, HEAD), starts=1, check=False, workers=1)
    assert set(found.engines) == {"direct"}
    assert found.best.engine == "direct"
    assert found.record()["search"]["engines"] == found.engines
    assert found.record()["optimum"]["engine"] == "direct"


def test_free_lengths_are_why_the_direct_engine_is_taken(tmp_path: Path) -> None:
    source = Evaluator(problem(tmp_path, HEAD + LEAD))
    assert source.at(np.array([0.5, 0.5])).engine == "direct"
    assert source.transitions.why.startswith("drives.table.lead_mm_per_turn change the machine")


def test_turns_that_differ_are_no_usable_machine(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A turn that does not repeat has no transition of its own: excluded, with a word."""
    from dataclasses import replace

    from nipper_pin.study.true_transition import transition_of_turns

    def drifting(*arguments: Any) -> Any:
        found = transition_of_turns(*arguments)
        return replace(found, solution=replace(found.solution, repeated_from=None))

    text = E62.replace("650.0", "700.0").replace("9.0", "3.0")
    source = Evaluator(problem(tmp_path, text))
    z = np.array([0.1])
    assert source.at(z).engine == "reduced_turn"
    followed = bounces.turn_transition
    monkeypatch.setattr(
        bounces, "turn_transition", lambda *words: replace(followed(*words), repeats=False)
    )
    assert source.at(z).engine == "turn"
    monkeypatch.setattr(bounces, "transition_of_turns", drifting)
    point = source.at(z)
    assert not point.usable
    assert "turns differ from one another" in point.why


def test_a_screen_is_made_of_shares_in_order(tmp_path: Path) -> None:
    found = problem(tmp_path, HEAD)
    places = [tuple(z) for z in samples(found, 3).tolist()]
    assert len(places) > SHARE
    assert [item.z for item in screen(found, 3, Work(1, None))] == places


def test_only_what_meets_the_limits_is_polished(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The check of a problem whose limit nothing meets ends with its evolution."""
    monkeypatch.setattr("nipper_pin.study.optimise.search.samples._GENERATIONS", 2)
    for limit, feasible in ((1.0, False), (1e-6, True)):
        text = f"{HEAD}[limits]\nrebound_amplitude_1 = {{ low = {limit} }}\n"
        found, work = problem(tmp_path, text), Work(1, None)
        search = Search(found, screen(found, 1, work), 1, 2, work)
        evolved, polished = search.check(found.aims[0])
        assert evolved.feasible is feasible
        assert (polished is not None) is feasible


def test_stated_errors_of_a_design(tmp_path: Path) -> None:
    """What half of the samples of a cycle change, and round-off; else those of the transition."""
    text = f"{E62}[limits]\nstop_force_N = {{ low = 1.0 }}\nduration_s = {{ high = 1.0 }}\n"
    source, z = Evaluator(problem(tmp_path, text)), np.array([0.5])
    machine = source.mechanism(z)
    cycle = working_cycle(machine, 650.0)
    whole, half = (cycle_values(item)["stop_force_N"] for item in (cycle, thinned(cycle)))
    found = source.errors(z)
    assert found["stop_force_N"] == abs(whole - half) + QUANTITY_ROUND_OFF * abs(whole)
    assert found["duration_s"] == source.transitions.at(machine, 650.0).errors["duration_s"]
    assert abs(whole - half) > QUANTITY_ROUND_OFF * abs(whole)


def test_a_search_without_numba(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    found = problem(tmp_path, E62)
    monkeypatch.setattr(one_machine, "installed", lambda name: name != "numba")
    assert Evaluator(found).transitions.why == (
        "the reduced engine needs numba, which is not installed"
    )


def test_designs_that_cannot_be_simulated_again() -> None:
    design: Any = object()
    assert run._known(design) is design
    with pytest.raises(SimulationError, match="unforeseen"):
        run._known(None)


def late(pause: float, answer: int) -> int:
    """A task that another process can find."""
    time.sleep(pause)
    return answer


@pytest.mark.slow
def test_parts_of_a_search_in_processes() -> None:
    """In their order whoever ends first, and counted as they end."""
    told: list[tuple[int, int]] = []
    with Work(2, lambda done, known: told.append((done, known))) as work:
        assert work.all([partial(late, 0.4, 7), partial(late, 0.0, 11)]) == [7, 11]
        assert told == [(0, 2), (1, 2), (2, 2)]
        assert work.one(lambda: 5) == 5
        assert told[-1] == (3, 3)
        assert work.mapper(abs, [-3, 2]) == [3, 2]


@pytest.mark.slow
def test_a_search_whose_process_dies() -> None:
    for ask in (
        lambda work: work.all([partial(os._exit, 3)]),
        lambda work: work.mapper(os._exit, [3]),
    ):
        with (
            pytest.raises(SimulationError, match="a worker process died, perhaps") as caught,
            Work(2, None) as work,
        ):
            ask(work)
        assert caught.value.evidence == {"workers": 2}
