"""Each check of the judge is shown solutions that are a little wrong, and refuses every one.

A limit that has become a hundred times too wide no longer refuses what is planted beside it.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import fields, replace
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
from nipper_pin.hybrid.result.tables import Rebounds
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


def put(item: Any, path: tuple[Any, ...], change: Callable[[Any], Any]) -> Any:
    """A copy with something else at a path, of fields and of properties that are kept.

    Of a tuple one is chosen by its place, the first event by its kind, or all by a condition.
    """
    if not path:
        return change(item)
    step, *rest = path
    if isinstance(step, EventKind):
        step = next(place for place, event in enumerate(item) if event.kind is step)
    if isinstance(step, str):
        value = put(getattr(item, step), tuple(rest), change)
        if step in {field.name for field in fields(item)}:
            changed = replace(item, **{step: value})
            # The system of the machine that was simulated, if only its description is another one.
            if path[-1] != "model" and hasattr(item, "system"):
                changed.__dict__["system"] = item.system
            return changed
        changed = replace(item)
        changed.__dict__[step] = value
        return changed
    chosen = [*map(step, item)] if callable(step) else [x is item[step] for x in item]
    return tuple(
        put(x, tuple(rest), change) if asked else x for x, asked in zip(item, chosen, strict=True)
    )


def more(share: float) -> Callable[[Any], Any]:
    return lambda value: value * (1.0 + share)


def raised(places: Any, by: float) -> Callable[[Any], Any]:
    """An array that is larger at some coordinates."""

    def change(values: Any) -> Any:
        values = values.copy()
        values[..., places] += by
        return values

    return change


def heavier(model: Any) -> Any:
    model = model.copy()
    model.inertias[3].mass *= 1.0 + 1e-8
    return model


def pulled_down(model: Any) -> Any:
    model = model.copy()
    model.gravity.linear = model.gravity.linear * (1.0 + 2e-9)
    return model


def every(_: Any) -> bool:
    return True


def long(part: Any) -> bool:
    return bool(part.kinematic and part.t_end - part.t_start > 1e-3)


def integrated(panel: Any) -> bool:
    return bool(panel.integrated)


Doctor = Callable[[Any], Any]
HIT: tuple[Any, ...] = ("events", COLLISION)
# A check, where something is wrong, and what.
PLANTED: list[tuple[str, tuple[Any, ...], Doctor]] = [
    ("time order", ("segments", 1, "t_start"), lambda t: t + 6.0 * EPS),
    ("time order", (*HIT, "number"), lambda _: 77),
    ("time order", (*HIT, "t"), lambda _: 60.0 / 650.0 * (1.0 + 32.0 * EPS)),
    ("outcome", ("outcome",), lambda _: Outcome.AT_REST),
    ("outcome", ("shaft", "speed_rad_s"), more(-2e-14)),
    ("phase logic", (*HIT, "closed_before"), lambda _: frozenset({"jaw", "steeve"})),
    ("phase logic", ("events", RELEASE, "closed_after"), lambda _: frozenset({"no"})),
    ("phase logic", ("events", REST, "q"), raised([JAW, STEEVE], 1e-300)),
    ("phase logic", (*HIT, "v_after"), lambda v: -np.abs(v)),
    ("phase logic", ("segments", -1, "closed"), lambda _: frozenset({"no"})),
    ("impulse", (*HIT, "delta"), raised(DRIVEN, 1e-20)),
    ("impulse", (*HIT, "P_g"), more(3e-9)),
    ("impulse", (*HIT, "delta"), raised(STEEVE, 1e-9)),
    ("impulse", (*HIT, "v_after"), raised(STEEVE, 1e-12)),
    ("impulse", (*HIT, "P_N"), lambda all_of: {n: -P for n, P in all_of.items()}),
    ("impulse", (*HIT, "energy_lost"), more(3e-9)),
    ("motion", ("segments", long, "panels", every, "a"),
     lambda a: a + 1e-4 * np.abs(a).max()),
    ("continuity", ("segments", every, "panels", integrated, "q"), raised(JAW, 2e-10)),
    ("energy", ("energy",), lambda energy: replace(
        energy, impact_losses=energy.impact_losses + 1e-6 * (
            abs(energy.drive_work) + energy.kinetic_peak))),
    ("tables", ("phases",), lambda phases: (replace(
        phases[1], t_start=np.nextafter(phases[1].t_end, 1.0)),)),
    ("tables", ("events", REST, "series_error"), lambda _: np.nan),
    *(("tables", ("collisions", 0, name), more(1e-14)) for name in
      ("approach_rate", "separation_rate", "impulse", "energy_lost")),
    ("model", ("mechanism", "model"), heavier),
    ("model", ("mechanism", "model"), pulled_down),
    ("model", ("case", "speed_rpm"), more(1e-14)),
    ("model", ("mechanism", "stops", every, "restitution"), more(1e-6)),
    ("model", ("mechanism", "springs", every, "stiffness"), more(1e-14)),
    ("model", ("mechanism", "springs"), lambda _: ()),
]  # fmt: skip
PLANTED_IN_CHAIN: list[tuple[str, tuple[Any, ...], Doctor]] = [
    ("flights", ("segments", every, "panels", every, "a"), more(1e-6)),
    ("springs and dampers", ("mechanism", "springs", every, "stiffness"), more(5e-8)),
    ("springs and dampers", ("mechanism", "dampers", every, "damping"), more(5e-9)),
]


def test_every_check_refuses_what_is_planted_for_it(runs: dict[str, Solution]) -> None:
    for name, planted in (("e62", PLANTED), ("chain", PLANTED_IN_CHAIN)):
        for kind, path, change in planted:
            refused(kind, put(runs[name], path, change))
    assert {kind for kind, *_ in (*PLANTED, *PLANTED_IN_CHAIN)} == CHECKS.keys()


def test_stops_that_the_closures_do_not_let_close(runs: dict[str, Solution]) -> None:
    closed = frozenset({"j0 lower", "j0 upper", "j1 upper"})
    assert violations(put(runs["chain"], ("segments", 0, "closed"), lambda _: closed))


Change = Callable[[Any], Any]


def shown(change: Change) -> Change:
    """The motion that the judge is shown is another one."""
    return lambda true: lambda *asked: change(true(*asked))


def through(at: Any) -> Any:
    """The jaw goes through its stop."""
    return at._replace(q=raised(JAW, -np.abs(at.q[:, JAW]).min() - 2e-12)(at.q))


SHOWN: list[tuple[Change, str]] = [
    (lambda at: at._replace(v=at.v + np.inf), "not finite"),
    # A part of a metre is the machine's reach.
    (lambda at: at._replace(q=raised(0, 3000.0 * EPS)(at.q)), "closure gap"),
    (lambda at: at._replace(v=raised(0, 1e-9 * np.abs(at.v).max())(at.v)), "closure rate"),
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
    assert violations(simulate(turned, window=Window.CYCLE)) == []


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
