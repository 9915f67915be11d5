"""Each comparison of the judge is made, at the width that is said, and refusals have limits."""

from __future__ import annotations

import hashlib
import json
import warnings
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import mpmath
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
    Excess,
    Trial,
    Verdict,
    excesses,
    judge,
    judging,
    trial,
    violations,
)
from benchmarks.stress.checks.agreement import bits, mirror_images, within_errors
from benchmarks.stress.checks.engines import engines_agree
from benchmarks.stress.machines.small_machines import (
    e62 as e62_source,
)
from benchmarks.stress.refusals import MEASURED, allowed_share
from nipper_pin import (
    Case,
    Event,
    EventKind,
    Mechanism,
    Outcome,
    SimulationError,
    Solution,
    Window,
    simulate,
)
from nipper_pin.dynamics import Elements
from nipper_pin.hybrid.result.rebounds import Rebounds
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


def test_events_that_only_one_run_has(e62: Mechanism) -> None:
    """A series that ends earlier, at a rest, is the same; a collision less in its midst is not."""
    run = simulate(e62, Case(speed_rpm=650.0, window=Window.CYCLE, cycles=2))
    kinds = [event.kind for event in run.events]
    rest = kinds.index(EventKind.REST)
    release = kinds.index(EventKind.RELEASE, rest)
    for left_out, alike in (
        ({rest - 1}, True), ({rest - 2, rest - 1}, True), ({release - 1}, True), ({1}, False),
        ({rest}, False), ({release}, False),
    ):  # fmt: skip
        kept = [place for place in range(len(kinds)) if place not in left_out]
        other = replace(run, events=tuple(run.events[place] for place in kept))
        other.__dict__["errors"] = [run.errors[place] for place in kept]
        for pair in ((run, other), (other, run)):
            assert (within_errors(*pair) == []) is alike, left_out


def test_nothing_is_compared_after_a_rate_that_is_all_error(transition: Solution) -> None:
    """It is undecided whether the stop is reached: no collision says more."""
    other = later(stronger(transition, 2, 0.5), 3, 1e-3)
    assert within_errors(other, transition) != []
    errors = list(transition.errors)
    errors[1] = replace(errors[1], impulse=1.0)
    other.__dict__["errors"] = errors
    assert within_errors(other, transition) == within_errors(transition, other) == []


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


Change = Callable[[Mechanism, Case, Solution, int], Solution]


def second_run(_mechanism: Mechanism, _case: Case, solution: Solution, run: int) -> Solution:
    return later(solution, 1, EPS) if run == 1 else solution


def finer_run(_mechanism: Mechanism, case: Case, solution: Solution, _run: int) -> Solution:
    return later(solution, 1, 1e-5) if case.resolution.tolerance < 1e-8 else solution


def mirrored_run(mechanism: Mechanism, _case: Case, solution: Solution, _run: int) -> Solution:
    image = any(stop.name == "j0 lower" and stop.sense < 0.0 for stop in mechanism.stops)
    return later(solution, 1, 1e-5) if image else solution


def every_run(_mechanism: Mechanism, _case: Case, solution: Solution, _run: int) -> Solution:
    return later(solution, len(solution.events) - 1, 1e-6)


def lossy(_mechanism: Mechanism, _case: Case, solution: Solution, _run: int) -> Solution:
    events = (replace(solution.events[0], energy_lost=1.0), *solution.events[1:])
    return replace(solution, events=events)


def warned(_mechanism: Mechanism, _case: Case, solution: Solution, _run: int) -> Solution:
    warnings.warn("overflow", RuntimeWarning, stacklevel=1)
    return solution


def broken(_mechanism: Mechanism, _case: Case, _solution: Solution, _run: int) -> Solution:
    message = "a shape"
    raise ValueError(message)


def saying(text: str) -> Change:
    def refused(_mechanism: Mechanism, _case: Case, _solution: Solution, _run: int) -> Solution:
        raise SimulationError(text)

    return refused


@pytest.fixture
def engine(monkeypatch: pytest.MonkeyPatch) -> Callable[[Change], list[Solution]]:
    """Puts another engine, one that changes its solutions, in front of the judge."""

    def take(change: Change) -> list[Solution]:
        runs: list[Solution] = []

        def run(mechanism: Mechanism, case: Case) -> Solution:
            runs.append(simulate(mechanism, case))
            return change(mechanism, case, runs[-1], len(runs) - 1)

        monkeypatch.setattr(judging, "simulate", run)
        return runs

    return take


Engine = Callable[[Change], list[Solution]]


@pytest.mark.parametrize(
    ("item", "change", "word", "kind"),
    [
        (usual, second_run, WRONG, "determinism"),
        (usual, finer_run, WRONG, "tolerance"),
        (small, mirrored_run, WRONG, "mirror"),
        (usual, every_run, WRONG, "engines"),
        (usual, lossy, WRONG, "self-check"),
        (usual, warned, WRONG, "RuntimeWarning: overflow"),
        (usual, broken, WRONG, "ValueError: a shape"),
        (usual, saying("please report it"), WRONG, "confession"),
        (usual, saying(""), WRONG, "confession"),
        (usual, saying("a dead centre"), REFUSED, "SimulationError"),
    ],
)
def test_what_an_engine_does_is_judged(
    engine: Engine, item: Callable[[], Trial], change: Change, word: str, kind: str
) -> None:
    """One of its runs has another event, or it says or warns of what is no answer."""
    engine(change)
    verdict = judge(item())
    assert verdict.word == word
    assert kind in f"{verdict.kind}: {verdict.detail}"


@pytest.mark.sampled(4)
@pytest.mark.parametrize(
    ("tolerance", "evaluations", "tolerances"),
    [
        (1e-8, 100_000, [1e-8, 1e-8, 6.25e-10, 1e-8]),
        (1e-8, 100_001, [1e-8]),
        (1.5e-14, 100_000, [1.5e-14, 1.5e-14, 1e-14, 1.5e-14]),
        (1e-14, 100_000, [1e-14, 1e-14, 1e-14]),
    ],
)
def test_a_trial_is_run_again_finer_and_mirrored(
    engine: Engine, tolerance: float, evaluations: int, tolerances: list[float]
) -> None:
    """Without a change it is right; one of many evaluations is run once, the finest not finer."""
    item = small()
    item.case["resolution"] = {"tolerance": tolerance}
    runs = engine(lambda _m, _c, solution, _run: replace(solution, evaluations=evaluations))
    verdict = judge(item)
    assert (verdict.word, verdict.kind, verdict.detail) == (RIGHT, "COMPLETED", "")
    assert verdict.fingerprint == hashlib.sha256(bits(runs[0])).hexdigest()
    assert [run.case.resolution.tolerance for run in runs] == tolerances
    images = [run.mechanism.stop("j0 lower").sense < 0.0 for run in runs]
    assert sum(images) == images[-1] == (len(runs) > 1)


def test_runs_that_may_be_refused(engine: Engine) -> None:
    """A finer or mirrored run that ends with an error is an answer; nothing is compared then."""

    def refused(_m: Mechanism, _c: Case, solution: Solution, run: int) -> Solution:
        if run < 2:
            return solution
        message = "a tolerance finer than round-off"
        raise SimulationError(message)

    runs = engine(refused)
    assert judge(small()).word == RIGHT
    assert len(runs) == 4


def without_heat(_: Elements, q: np.ndarray, _v: np.ndarray) -> np.ndarray:
    return np.zeros(len(q))


def pushing(_: Elements, q: np.ndarray, v: np.ndarray) -> np.ndarray:
    return np.zeros_like(q) + 0.01 * v


def with_more_energy(_: Elements, q: np.ndarray) -> np.ndarray:
    return np.abs(q).sum(axis=1)


def heavier(
    text: str, gravity: float, file: str, right: Callable[..., Any] = build.build_model
) -> Any:
    return right(text, gravity * (1.0 + 1e-7), file)


def higher(
    self: Rebounds, event: Event, stop: str, right: Callable[..., Any] = Rebounds.amplitude
) -> float | None:
    found = right(self, event, stop)
    return None if found is None else found * (1.0 + 1e-6)


@pytest.mark.sampled(5)
@pytest.mark.parametrize(
    ("item", "place", "name", "wrong", "kinds"),
    [
        (small, build, "build_model", heavier, ("model",)),
        (usual, Rebounds, "amplitude", higher, ("tables",)),
        (small, Elements, "dissipation", without_heat, ("springs and dampers", "energy")),
        (small, Elements, "forces", pushing, ("springs and dampers", "energy")),
        (small, Elements, "energy", with_more_energy, ("energy",)),
    ],
)
def test_a_fault_of_all_runs_is_seen(
    monkeypatch: pytest.MonkeyPatch, engine: Engine, item: Callable[[], Trial], place: Any,
    name: str, wrong: Any, kinds: tuple[str, ...],
) -> None:  # fmt: skip
    """Gravity, heights, heat, forces or energies that are wrong from the start: by one run."""
    monkeypatch.setattr(place, name, wrong)
    runs = engine(lambda _m, _c, solution, _run: replace(solution, evaluations=100_001))
    assert judge(item()).word == WRONG
    # The verdict names the first few of its violations.
    assert set(kinds) <= {found.kind for found in violations(runs[0])}


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


def test_measured_refusals_are_the_published_ones() -> None:
    """All families, as in the table of benchmarks/README.md; of none may all be refused."""
    text = (Path(__file__).parents[3] / "benchmarks/README.md").read_text(encoding="utf-8")
    table = text.partition("| family | what varies | refused |\n")[2].partition("\n\n")[0]
    rows = [[cell.strip() for cell in line.split("|")[1:-1]] for line in table.splitlines()[1:]]
    assert {name: int(refused) for name, _, refused in rows} == MEASURED
    assert set(MEASURED) == set(FAMILIES)
    for family, refused in MEASURED.items():
        assert refused / 385 < allowed_share(family) < 1.0


@pytest.mark.parametrize(("family", "cases"), [("spring", 40), ("grazing", 60), ("reach", 385)])
def test_excesses_are_those_of_the_binomial_law(family: str, cases: int) -> None:
    """From so many refusals on as chance brings once in a million, in 40 digits.

    A fifth and 0.02 more may be refused than were measured of 385, never beyond half the way.
    """
    one = MEASURED[family] / 385
    assert allowed_share(family) == pytest.approx(min(1.2 * one + 0.02, 0.5 * (1.0 + one)))
    with mpmath.workdps(40):
        share = mpmath.mpf(allowed_share(family))
        terms = [
            mpmath.binomial(cases, k) * share**k * (1 - share) ** (cases - k)
            for k in range(cases + 1)
        ]
        least = next(k for k in range(cases + 1) if mpmath.fsum(terms[k:]) < 1e-6)
    for refused in (least - 1, least):
        words = [REFUSED] * refused + [RIGHT] * (cases - refused)
        given = [Verdict(n, family, word, "", "", "", 0.1) for n, word in enumerate(words)]
        found = [item for item in excesses(given) if item.family == family]
        assert found == ([Excess(family, least, cases, float(share))] if refused == least else [])


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
    assert main(["stress", "--cases", "54", "--json", "-"]) == 0
    assert json.loads(capsys.readouterr().out) == fine.record()


def test_verdicts_are_the_same_however_long_they_took() -> None:
    """Wall times differ from process to process; nothing else may."""
    verdict = Verdict(3, "chain", RIGHT, "COMPLETED", "", "abc", 1.0)
    assert verdict == replace(verdict, wall_s=2.0)
    for name, other in (("number", 4), ("family", "spring"), ("word", WRONG), ("kind", "energy"),
                        ("detail", "x"), ("fingerprint", "abd")):  # fmt: skip
        assert verdict != replace(verdict, **{name: other})


# Of seed 1; each ends at its largest number of collisions.
CUT_OFF = (181, 262)


@pytest.mark.campaign
@pytest.mark.parametrize("number", CUT_OFF)
@pytest.mark.parametrize(("which", "kind"), [(2, "tolerance"), (3, "mirror")])
def test_a_case_that_ends_at_its_largest_number_of_collisions_is_judged_on_what_it_has(
    engine: Engine, number: int, which: int, kind: str
) -> None:
    """It is right as it is, and wrong if one collision of one of its runs has another impulse.

    Runs are made in this order: the case, the same again, the finer one, the mirrored one.
    """

    def other(_m: Mechanism, _c: Case, solution: Solution, run: int) -> Solution:
        if run != which:
            return solution
        hits = [e for e in solution.events if e.kind is EventKind.COLLISION]
        # A series may end sooner in one of two runs, so that its last collisions have no match.
        early = [e for e in hits if solution.errors[e.number - 1].impulse < 1e-3]
        return stronger(solution, early[len(early) // 2].number - 1, 0.1)

    item = trial(1, number)
    assert judge(item).kind == Outcome.TOO_MANY_COLLISIONS.name
    runs = engine(other)
    verdict = judge(item)
    assert len(runs) == 4
    assert (verdict.word, verdict.kind) == (WRONG, kind)
    collisions = sum(event.kind is EventKind.COLLISION for event in runs[0].events)
    assert collisions == item.case["max_collisions"]
