"""Each check of the judge is shown solutions that are a little wrong, and refuses every one.

A limit that has become a hundred times too wide no longer refuses what is planted beside it.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pinocchio as pin
import pytest
from any_plane import rewritten
from machine_of_all_elements import CASE, everything

from benchmarks.stress import CHECKS, violations
from benchmarks.stress.checks import invariants
from benchmarks.stress.checks.agreement import bits, mirror_images
from benchmarks.stress.machines.mirror import mirrored
from benchmarks.stress.machines.parts import Source
from benchmarks.stress.machines.small_machines import e62 as e62_source
from benchmarks.stress.machines.small_machines import flaps
from nipper_pin import Case, EventKind, Mechanism, Outcome, Solution, Window, simulate
from nipper_pin.dynamics import System
from nipper_pin.hybrid.result.rebounds import Rebounds
from nipper_pin.mechanism import from_sources, gallery

# A planted error is beyond the limit that it breaks by at most this factor.
_NEAR = 100.0
EPS = float(np.finfo(float).eps)
COLLISION, REST, RELEASE = EventKind.COLLISION, EventKind.REST, EventKind.RELEASE
# Coordinates of the E62; the steeve is struck first.
DRIVEN, JAW, STEEVE = [0, 6], 2, 4


@pytest.fixture(scope="module")
def runs(e62: Mechanism) -> dict[str, Solution]:
    """A turn of the E62, its transition, and a chain with an element of every kind."""
    return {
        "e62": simulate(e62, Case(speed_rpm=650.0, window=Window.CYCLE)),
        "transition": simulate(e62, Case(speed_rpm=650.0)),
        "chain": simulate(built(everything()), CASE),
    }


def built(source: Source) -> Mechanism:
    return from_sources(source.name, source.urdf, source.description, source.folder)


def refused(kind: str, solution: Solution, word: str = "") -> None:
    """By the check that it is for, which objects to something little beyond its limit."""
    said = [text for text in CHECKS[kind](solution) if word in text]
    assert said
    limits = [re.search(r": (\S+), at most (\S+)$", text) for text in said]
    near = [float(m[1]) <= _NEAR * float(m[2]) or float(m[2]) <= 0.0 for m in limits if m]
    assert any(near) or not near, said


# --- planted errors ------------------------------------------------------------------------------

Doctor = Callable[[Solution], Solution]


def event(kind: EventKind, **changes: Callable[[Any], Any]) -> Doctor:
    """Fields of the first event of a kind."""

    def doctor(run: Solution) -> Solution:
        events = list(run.events)
        place = next(i for i, item in enumerate(events) if item.kind is kind)
        wrong = {name: change(events[place]) for name, change in changes.items()}
        events[place] = replace(events[place], **wrong)
        return replace(run, events=tuple(events))

    return doctor


def raised(name: str, places: Any, by: float) -> Callable[[Any], Any]:
    """An array of an event or of a panel, larger at some coordinates."""

    def change(item: Any) -> Any:
        values = getattr(item, name).copy()
        values[..., places] += by
        return values

    return change


def panels(a: Callable[[Any], Any] | None = None, q: Callable[[Any], Any] | None = None,
           of: Callable[[Any, Any], bool] = lambda *_: True) -> Doctor:  # fmt: skip
    """Accelerations or coordinates of panels, by segment and panel those that are asked for."""
    changes = {name: change for name, change in (("a", a), ("q", q)) if change is not None}

    def doctor(run: Solution) -> Solution:
        return replace(run, segments=tuple(
            replace(part, panels=tuple(
                replace(x, **{name: change(x) for name, change in changes.items()})
                if of(part, x) else x for x in part.panels))
            for part in run.segments))  # fmt: skip

    return doctor


def segment(place: int, **changes: Callable[[Solution], Any]) -> Doctor:
    """Fields of one segment."""

    def doctor(run: Solution) -> Solution:
        parts = list(run.segments)
        wrong = {name: change(run) for name, change in changes.items()}
        parts[place] = replace(parts[place], **wrong)
        return replace(run, segments=tuple(parts))

    return doctor


def property_of(name: str, change: Callable[[Solution], Any]) -> Doctor:
    """What a solution takes for one of its properties."""

    def doctor(run: Solution) -> Solution:
        changed = replace(run)
        changed.__dict__[name] = change(run)
        return changed

    return doctor


def machine(**changes: Callable[[Mechanism], Any]) -> Doctor:
    """Another machine than the one that was simulated."""

    def doctor(run: Solution) -> Solution:
        wrong = {name: change(run.mechanism) for name, change in changes.items()}
        changed = replace(run, mechanism=replace(run.mechanism, **wrong))
        changed.__dict__["system"] = run.system
        return changed

    return doctor


def element(kind: str, name: str, share: float) -> Doctor:
    """A number of all springs, dampers or stops, larger by a share."""
    return machine(**{kind: lambda machine: tuple(
        replace(item, **{name: getattr(item, name) * (1.0 + share)})
        for item in getattr(machine, kind))})  # fmt: skip


def model(change: Callable[[Any], None]) -> Doctor:
    """Another model of Pinocchio."""

    def doctor(run: Solution) -> Solution:
        built = run.mechanism.model.copy()
        change(built)
        return replace(run, mechanism=replace(run.mechanism, model=built))

    return doctor


def heavier(model: Any) -> None:
    model.inertias[3].mass *= 1.0 + 1e-8


def pulled_down(model: Any) -> None:
    model.gravity.linear = model.gravity.linear * (1.0 + 2e-9)


def out_of_balance(run: Solution) -> Any:
    scale = abs(run.energy.drive_work) + run.energy.kinetic_peak
    return replace(run.energy, impact_losses=run.energy.impact_losses + 1e-6 * scale)


def collision(name: str) -> Doctor:
    """A number in the table of collisions."""
    return property_of("collisions", lambda run: (
        replace(run.collisions[0], **{name: getattr(run.collisions[0], name) * (1.0 + 1e-14)}),
    ))  # fmt: skip


PLANTED: list[tuple[str, Doctor]] = [
    ("time order", segment(1, t_start=lambda run: run.segments[1].t_start
                           + 64.0 * EPS * run.segments[-1].t_end)),
    ("time order", event(COLLISION, number=lambda _: 77)),
    ("time order", lambda run: event(
        COLLISION, t=lambda _: run.segments[-1].t_end * (1.0 + 32.0 * EPS))(run)),
    ("outcome", lambda run: replace(run, outcome=Outcome.AT_REST, events=run.events[:3])),
    ("outcome", lambda run: replace(run, shaft=replace(
        run.shaft, speed_rad_s=run.shaft.speed_rad_s * (1.0 - 2e-14)))),
    ("phase logic", event(COLLISION, closed_before=lambda _: frozenset({"jaw", "steeve"}))),
    ("phase logic", event(RELEASE, closed_after=lambda item: item.closed_before)),
    ("phase logic", event(REST, q=raised("q", [JAW, STEEVE], 1e-300))),
    ("phase logic", event(COLLISION, v_after=lambda item: -np.abs(item.v_after))),
    ("phase logic", segment(-1, closed=lambda _: frozenset({"no"}))),
    ("impulse", event(COLLISION, delta=raised("delta", DRIVEN, 1e-20))),
    ("impulse", event(COLLISION, P_g=lambda item: item.P_g * (1.0 + 3e-9))),
    ("impulse", event(COLLISION, delta=raised("delta", STEEVE, 1e-9))),
    ("impulse", event(COLLISION, v_after=raised("v_after", STEEVE, 1e-12))),
    ("impulse", event(COLLISION, P_N=lambda item: {n: -P for n, P in item.P_N.items()})),
    ("impulse", event(COLLISION, energy_lost=lambda item: item.energy_lost * (1.0 + 3e-9))),
    ("motion", panels(a=lambda x: x.a + 1e-4 * np.abs(x.a).max(),
                      of=lambda part, _: part.kinematic and part.t_end - part.t_start > 1e-3)),
    ("continuity", panels(q=raised("q", JAW, 2e-10), of=lambda _, panel: panel.integrated)),
    ("energy", property_of("energy", out_of_balance)),
    ("tables", property_of("phases", lambda run: (replace(
        run.phases[1], t_start=np.nextafter(run.phases[1].t_end, 1.0)),))),
    ("tables", event(REST, series_error=lambda _: np.nan)),
    *(("tables", collision(name)) for name in
      ("approach_rate", "separation_rate", "impulse", "energy_lost")),
    ("model", model(heavier)),
    ("model", model(pulled_down)),
    ("model", lambda run: replace(run, case=replace(run.case, speed_rpm=650.0 * (1.0 + 1e-14)))),
    ("model", element("stops", "restitution", 1e-6)),
    ("model", element("springs", "stiffness", 1e-14)),
    ("model", machine(springs=lambda _: ())),
]  # fmt: skip
PLANTED_IN_CHAIN: list[tuple[str, Doctor]] = [
    ("flights", panels(a=lambda x: x.a * (1.0 + 1e-6))),
    ("springs and dampers", element("springs", "stiffness", 5e-8)),
    ("springs and dampers", element("dampers", "damping", 5e-9)),
]


def test_every_check_refuses_what_is_planted_for_it(runs: dict[str, Solution]) -> None:
    for name, planted in (("e62", PLANTED), ("chain", PLANTED_IN_CHAIN)):
        for kind, doctor in planted:
            refused(kind, doctor(runs[name]))
    assert {kind for kind, _ in (*PLANTED, *PLANTED_IN_CHAIN)} == CHECKS.keys()


def test_stops_that_the_closures_do_not_let_close(runs: dict[str, Solution]) -> None:
    closed = frozenset({"j0 lower", "j0 upper", "j1 upper"})
    assert violations(segment(0, closed=lambda _: closed)(runs["chain"]))


Change = Callable[[Any], Any]


def shown(change: Change) -> Change:
    """The motion that the judge is shown is another one."""
    return lambda true: lambda *asked: change(true(*asked))


def through(at: Any) -> Any:
    """The jaw goes through its stop."""
    return at._replace(q=raised("q", JAW, -np.abs(at.q[:, JAW]).min() - 2e-12)(at))


SHOWN: list[tuple[Change, str]] = [
    (lambda at: at._replace(v=at.v + np.inf), "not finite"),
    # A part of a metre is the machine's reach.
    (lambda at: at._replace(q=raised("q", 0, 3000.0 * EPS)(at)), "closure gap"),
    (lambda at: at._replace(v=raised("v", 0, 1e-9 * np.abs(at.v).max())(at)), "closure rate"),
    (through, "penetrates"),
    (lambda at: at._replace(closures=at.closures * (1.0 + 1e-7)), "segment"),
    (lambda at: at._replace(stops={n: -1e-4 * abs(x) for n, x in at.stops.items()}), "segment"),
]


@pytest.mark.parametrize(
    ("kind", "run", "owner", "name", "change", "word"),
    [
        *(("motion", "e62", invariants, "shown", shown(one), word) for one, word in SHOWN),
        ("springs and dampers", "chain", System, "dissipation",
         lambda _: lambda _s, q, _v: np.full(len(q), -1e-12), ""),
        ("tables", "e62", Rebounds, "amplitude",
         lambda true: lambda *at: (1.0 + 1e-7) * (true(*at) or 0.0), ""),
    ],
)  # fmt: skip
def test_what_the_judge_is_shown_is_refused(
    runs: dict[str, Solution], monkeypatch: pytest.MonkeyPatch, kind: str, run: str, owner: Any,
    name: str, change: Change, word: str,
) -> None:  # fmt: skip
    monkeypatch.setattr(owner, name, change(getattr(owner, name)))
    refused(kind, replace(runs[run]), word)


@pytest.mark.parametrize("name", ["sieve", "scotch_yoke", "relay", "valve_train"])
def test_right_turns_are_not_refused(name: str) -> None:
    """Of machines in another plane, all of whose frames are turned, slots and blocks among them."""
    rng = np.random.default_rng(7)
    turn = pin.rpy.rpyToMatrix(*rng.uniform(-3.0, 3.0, 3))
    drawn = gallery.drawn(name).mechanism()
    urdf = rewritten(drawn.urdf, turn, {}, rng)
    turned = from_sources(name, urdf, drawn.description, ".")
    case = Case(speed_rpm=drawn.cylinder.rated_speed_rpm, window=Window.CYCLE)
    assert violations(simulate(turned, case)) == []


def test_right_solutions_are_not_refused(runs: dict[str, Solution]) -> None:
    """What the doctored ones are made of: stops struck on both sides, and heat in dampers."""
    chain = runs["chain"]
    assert {hit.stop for hit in chain.collisions} >= {"j0 lower", "j0 upper", "j1 upper"}
    assert chain.energy.dissipated > 0.01
    assert [violations(solution) for solution in runs.values()] == [[], [], []]


# --- mirror images -------------------------------------------------------------------------------


def test_mirror_images_move_alike(runs: dict[str, Solution]) -> None:
    """All events of the mirror image are those of the machine; hinges have turned their stops.

    Twice mirrored is the model itself, number by number.
    """
    chain, image = runs["chain"], mirrored(everything())
    assert image is not None
    assert image.description["stops"]["j0 lower"]["side"] == "upper"
    assert image.description["stops"]["j1 upper"]["side"] == "upper"
    twice = mirrored(image)
    assert twice is not None
    assert bits(simulate(built(twice), CASE)) == bits(chain)
    seen = simulate(built(image), CASE)
    assert [(e.kind, e.stops) for e in seen.events] == [(e.kind, e.stops) for e in chain.events]
    assert mirror_images(chain, seen) == []


def test_a_mirror_image_with_a_wrong_sign_is_caught(runs: dict[str, Solution]) -> None:
    """What an engine with a wrong sign at one side would do to the image."""
    for wrong in ("place", "drive"):
        image = mirrored(everything())
        assert image is not None
        if wrong == "place":
            image.description["stops"]["j0 upper"]["at_deg"] *= 1.0 + 1e-6
        else:
            drive = image.description["drives"]["shaft"]
            drive["sine_rad"] = [-x for x in drive["sine_rad"]]
        found = mirror_images(runs["chain"], simulate(built(image), CASE))
        assert {item.kind for item in found} == {"mirror"}


def test_what_has_no_mirror_image() -> None:
    """Laws and shapes that would have to be drawn anew; the nipper of the package has both."""
    for table, name, key, value in (
        ("drives", "arm", "law", "oscillating_guide"), ("stops", "flap1", "contact", {}),
    ):  # fmt: skip
        source = flaps(2, (0.3,), 0.2, 5.0, 3.0, 9.81)
        assert mirrored(source) is not None
        source.description[table][name][key] = value
        assert mirrored(source) is None
    assert mirrored(e62_source()) is None
