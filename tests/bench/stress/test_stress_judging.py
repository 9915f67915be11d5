"""Each comparison of the judge is made, at the width that is said, and refusals have limits."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from machine_of_all_elements import CASE, everything
from programs import main

from benchmarks.stress import (
    FAMILIES,
    REFUSED,
    RIGHT,
    WRONG,
    Campaign,
    Trial,
    Verdict,
    excesses,
    judge,
    judging,
    trial,
)
from benchmarks.stress.checks.agreement import mirror_images, within_errors
from benchmarks.stress.checks.engines import engines_agree
from benchmarks.stress.machines.small_machines import (
    e62 as e62_source,
)
from benchmarks.stress.refusals import MEASURED, allowed_share
from nipper_pin import Case, Mechanism, Solution, simulate
from nipper_pin.hybrid.event import Event, EventKind
from nipper_pin.hybrid.result.rebounds import Rebounds
from nipper_pin.hybrid.run.outcome import Outcome
from nipper_pin.mechanism import from_sources
from nipper_pin.mechanism.build import mechanism as build

EPS = np.finfo(float).eps


@pytest.fixture(scope="module")
def transition(e62: Mechanism) -> Solution:
    return simulate(e62, Case(speed_rpm=650.0))


def later(solution: Solution, place: int, by: float) -> Solution:
    """One event is moved in time; the stated errors stay what they are."""
    events = list(solution.events)
    events[place] = replace(events[place], t=events[place].t + by)
    moved = replace(solution, events=tuple(events))
    moved.__dict__["errors"] = solution.errors
    return moved


def stronger(solution: Solution, place: int, share: float) -> Solution:
    """The impulses of one event are larger by a share."""
    events = list(solution.events)
    impulses = {name: P * (1.0 + share) for name, P in events[place].P_N.items()}
    events[place] = replace(events[place], P_N=impulses)
    moved = replace(solution, events=tuple(events))
    moved.__dict__["errors"] = solution.errors
    return moved


@pytest.mark.parametrize(("compare", "share"), [(within_errors, 2.0), (mirror_images, 0.25)])
def test_solutions_may_differ_by_what_they_state_and_no_more(
    transition: Solution, compare: Callable[[Solution, Solution], list[Any]], share: float
) -> None:
    """Half and one and a half of the limit: a factor of both stated errors, and round-off."""
    place = 1
    event, error = transition.events[place], transition.errors[place]
    time = share * 2.0 * error.time + 16.0 * EPS * event.t
    assert compare(later(transition, place, 0.5 * time), transition) == []
    assert compare(later(transition, place, 1.5 * time), transition) != []
    (stop,) = event.stops
    impulse = share * 2.0 * error.impulses[stop] / event.P_N[stop] + 64.0 * EPS
    assert compare(stronger(transition, place, 0.5 * impulse), transition) == []
    assert compare(stronger(transition, place, 1.5 * impulse), transition) != []


def test_the_engines_may_differ_by_what_they_state_and_no_more(transition: Solution) -> None:
    """The last event is the rest, whose time is that of the transition."""
    from nipper_pin.reduced import build, transitions

    model = build(transition.mechanism)
    (spring,) = transition.mechanism.springs
    batch = transitions(
        model, speed_rpm=np.array([650.0]),
        restitution=np.array([transition.mechanism.stop("jaw").restitution]),
        stiffness=np.array([[spring.stiffness]]), preload=np.array([[spring.preload]]),
        tolerance=1e-12,
    )  # fmt: skip
    last = len(transition.events) - 1
    stated = transition.errors[last].time + float(batch.duration_error[0])
    difference = float(batch.duration[0]) - transition.transitions[-1].duration
    limit = 2.0 * stated + 32.0 * EPS
    assert engines_agree(later(transition, last, difference + 0.5 * limit), 1e-12) == []
    assert engines_agree(later(transition, last, difference + 1.5 * limit), 1e-12) != []


def usual() -> Trial:
    case = {"speed_rpm": 650.0, "resolution": {"tolerance": 1e-8}}
    return Trial(0, 1, "ordinary", e62_source(), case)


def small() -> Trial:
    case = {"speed_rpm": CASE.speed_rpm, "window": "cycle", "start_index": 0.0,
            "max_collisions": 60, "resolution": {"tolerance": 1e-8}}  # fmt: skip
    return Trial(0, 1, "chain", everything(), case)


def second_run(_mechanism: Mechanism, _case: Case, solution: Solution, run: int) -> Solution:
    return later(solution, 1, EPS) if run == 1 else solution


def finer_run(_mechanism: Mechanism, case: Case, solution: Solution, _run: int) -> Solution:
    return later(solution, 1, 1e-5) if case.resolution.tolerance < 1e-8 else solution


def mirrored_run(mechanism: Mechanism, _case: Case, solution: Solution, _run: int) -> Solution:
    image = any(stop.name == "j0 lower" and stop.sense < 0.0 for stop in mechanism.stops)
    return later(solution, 1, 1e-5) if image else solution


def every_run(_mechanism: Mechanism, _case: Case, solution: Solution, _run: int) -> Solution:
    return later(solution, len(solution.events) - 1, 1e-6)


def warned(_mechanism: Mechanism, _case: Case, solution: Solution, _run: int) -> Solution:
    warnings.warn("overflow", RuntimeWarning, stacklevel=1)
    return solution


@pytest.mark.campaign
@pytest.mark.parametrize(
    ("item", "change", "kind"),
    [
        (usual, second_run, "determinism"),
        (usual, finer_run, "tolerance"),
        (small, mirrored_run, "mirror"),
        (usual, every_run, "engines"),
        (usual, warned, "traceback"),
    ],
)
def test_each_run_of_a_trial_is_compared(
    monkeypatch: pytest.MonkeyPatch, item: Callable[[], Trial], change: Callable[..., Solution],
    kind: str,
) -> None:  # fmt: skip
    """One of the runs has another event; without that the trial is right."""
    runs: list[Case] = []

    def run(mechanism: Mechanism, case: Case) -> Solution:
        solution = change(mechanism, case, simulate(mechanism, case), len(runs))
        runs.append(case)
        return solution

    assert judge(item()).word == RIGHT
    monkeypatch.setattr(judging, "simulate", run)
    verdict = judge(item())
    assert verdict.word == WRONG
    assert kind in (verdict.kind, *verdict.detail.replace(":", " ").split())


def test_errors_of_building_a_model_are_seen(monkeypatch: pytest.MonkeyPatch) -> None:
    """Gravity a ten-millionth too large from the start: all runs of the trial agree on it."""
    right = build.build_model

    def heavier(text: str, gravity: float, file: str) -> object:
        return right(text, gravity * (1.0 + 1e-7), file)

    monkeypatch.setattr(build, "build_model", heavier)
    verdict = judge(small())
    assert (verdict.word, verdict.kind) == (WRONG, "model")


def test_errors_of_derived_tables_are_seen(monkeypatch: pytest.MonkeyPatch) -> None:
    """Amplitudes a millionth too large in all runs."""
    right = Rebounds.amplitude

    def larger(self: Rebounds, event: Event, stop: str) -> float | None:
        found = right(self, event, stop)
        return None if found is None else found * (1.0 + 1e-6)

    monkeypatch.setattr(Rebounds, "amplitude", larger)
    verdict = judge(usual())
    assert (verdict.word, verdict.kind) == (WRONG, "tables")


def test_a_confession_is_wrong(monkeypatch: pytest.MonkeyPatch) -> None:
    """An error that asks for a report is a fault; one that does not is a refusal."""
    from nipper_pin.errors import SimulationError

    for words, word in (("please report this", WRONG), ("a dead centre", REFUSED)):

        def run(*_: object, text: str = words) -> Solution:
            raise SimulationError(text)

        monkeypatch.setattr(judging, "simulate", run)
        assert judge(usual()).word == word


def verdicts(word: Callable[[str, int], str], each: int = 39) -> list[Verdict]:
    families = tuple(FAMILIES)
    return [
        Verdict(n, families[n % len(families)], word(families[n % len(families)],
                n // len(families)), "InputError", "a reason", "", 0.1)
        for n in range(each * len(families))
    ]  # fmt: skip


def measured(family: str, place: int) -> str:
    """As many refusals in 39 cases as the campaign in benchmarks/README.md has."""
    return REFUSED if place < round(39 * MEASURED[family] / 385) else RIGHT


def test_every_family_has_its_measured_share() -> None:
    assert set(MEASURED) == set(FAMILIES)
    for family, refused in MEASURED.items():
        assert refused / 385 < allowed_share(family) < 1.0


def test_as_many_refusals_as_were_measured_are_no_excess() -> None:
    assert excesses(verdicts(measured)) == []


@pytest.mark.parametrize("family", sorted(FAMILIES))
def test_an_engine_that_refuses_a_family_is_found(family: str) -> None:
    """All cases of one family refused, the others as measured: that family is named, no other."""

    def refuses(name: str, place: int) -> str:
        return REFUSED if name == family else measured(name, place)

    # Three in four at dead centres are refused rightly: it takes more of them.
    each = 39 if MEASURED[family] < 200 else 390
    found = [item.family for item in excesses(verdicts(refuses, each)) if item.family != "all"]
    assert found == [family]


def test_an_engine_that_refuses_everything_fails_a_short_campaign(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Status 1 after two cases of each family, with a family and both shares in the sentence."""
    import benchmarks.stress as stress

    refused = Campaign(1, tuple(verdicts(lambda *_: REFUSED, 2)), 1.0)
    monkeypatch.setattr(stress, "run_campaign", lambda *_, **__: refused)
    assert main(["stress", "--cases", "54"]) == 1
    assert "54 of 54 cases" in capsys.readouterr().err
    assert [item["family"] for item in refused.record()["refused_too_often"]] == ["all"]
    fine = Campaign(1, tuple(verdicts(measured)), 1.0)
    monkeypatch.setattr(stress, "run_campaign", lambda *_, **__: fine)
    assert main(["stress", "--cases", "54"]) == 0


def test_verdicts_are_the_same_however_long_they_took() -> None:
    """Wall times differ from process to process; nothing else may."""
    verdict = Verdict(3, "chain", RIGHT, "COMPLETED", "", "abc", 1.0)
    assert verdict == replace(verdict, wall_s=2.0)
    for name, other in (("number", 4), ("family", "spring"), ("word", WRONG), ("kind", "energy"),
                        ("detail", "x"), ("fingerprint", "abd")):  # fmt: skip
        assert verdict != replace(verdict, **{name: other})


def test_the_machine_of_all_elements_is_in_reach_of_the_mirror() -> None:
    """Its mirror image is another machine: else the comparison above would compare nothing."""
    source = everything()
    machine = from_sources(source.name, source.urdf, source.description, source.folder)
    image = small().mirror_image()
    assert image is not None
    assert image.stop("j0 lower").sense == -machine.stop("j0 lower").sense


# Of seed 1; each ends at its largest number of collisions.
CUT_OFF = (181, 262)


@pytest.mark.campaign
@pytest.mark.parametrize("number", CUT_OFF)
@pytest.mark.parametrize(("which", "kind"), [(2, "tolerance"), (3, "mirror")])
def test_a_case_that_ends_at_its_largest_number_of_collisions_is_judged_on_what_it_has(
    monkeypatch: pytest.MonkeyPatch, number: int, which: int, kind: str
) -> None:
    """It is right as it is, and wrong if one collision of one of its runs has another impulse.

    Runs are made in this order: the case, the same again, the finer one, the mirrored one.
    """
    runs: list[Solution] = []

    def other(mechanism: Mechanism, case: Case) -> Solution:
        solution = simulate(mechanism, case)
        if len(runs) == which:
            hits = [e for e in solution.events if e.kind is EventKind.COLLISION]
            # A series may end sooner in one of two runs, so that its last collisions have no match.
            early = [e for e in hits if solution.errors[e.number - 1].impulse < 1e-3]
            solution = stronger(solution, early[len(early) // 2].number - 1, 0.1)
        runs.append(solution)
        return solution

    item = trial(1, number)
    assert judge(item).kind == Outcome.TOO_MANY_COLLISIONS.name
    monkeypatch.setattr(judging, "simulate", other)
    verdict = judge(item)
    assert len(runs) == 4
    assert (verdict.word, verdict.kind) == (WRONG, kind)
    collisions = sum(event.kind is EventKind.COLLISION for event in runs[0].events)
    assert collisions == item.case["max_collisions"]
