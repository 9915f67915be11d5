"""Each check of the judge is shown solutions that are a little wrong, and refuses every one.

A limit that has become a hundred times too wide no longer refuses what is planted beside it.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from machine_of_all_elements import CASE, everything

from benchmarks.stress import CHECKS, violations
from benchmarks.stress.checks import invariants
from benchmarks.stress.checks.agreement import bits, mirror_images
from benchmarks.stress.machines.mirror import mirrored
from benchmarks.stress.machines.parts import Source
from benchmarks.stress.machines.small_machines import e62 as e62_source
from benchmarks.stress.machines.small_machines import flaps
from benchmarks.stress.observations import Shown
from nipper_pin import Case, EventKind, Mechanism, Outcome, Solution, Window, simulate
from nipper_pin.hybrid.result.rebounds import Rebounds
from nipper_pin.mechanism import from_sources

# A planted error is beyond the limit that it breaks by at most this factor.
_NEAR = 100.0


@pytest.fixture(scope="module")
def cycle(e62: Mechanism) -> Solution:
    return simulate(e62, Case(speed_rpm=650.0, window=Window.CYCLE))


@pytest.fixture(scope="module")
def transition(e62: Mechanism) -> Solution:
    return simulate(e62, Case(speed_rpm=650.0))


@pytest.fixture(scope="module")
def chain() -> Solution:
    return simulate(built(everything()), CASE)


def built(source: Source) -> Mechanism:
    return from_sources(source.name, source.urdf, source.description, source.folder)


Doctor = Callable[[Any], None]


class Patient:
    """Solutions to be changed, each of which a check has to refuse."""

    def __init__(self, cycle: Solution, chain: Solution) -> None:
        self.cycle, self.chain = cycle, chain

    def look(self, kind: str, solution: Solution, word: str = "") -> None:
        said = [text for text in CHECKS[kind](solution) if word in text]
        assert said
        limits = [re.search(r": (\S+), at most (\S+)$", text) for text in said]
        near = [float(m[1]) <= _NEAR * float(m[2]) or float(m[2]) <= 0.0 for m in limits if m]
        assert any(near) or not near, said

    def event(self, kind: str, of: EventKind, solution: Solution | None = None,
              **changes: Any) -> None:  # fmt: skip
        """Change fields of the first event of a kind; a function gets the event."""
        solution = solution or self.cycle
        events = list(solution.events)
        place = next(i for i, event in enumerate(events) if event.kind is of)
        new = {k: v(events[place]) if callable(v) else v for k, v in changes.items()}
        events[place] = replace(events[place], **new)
        self.look(kind, replace(solution, events=tuple(events)))

    def known(self, kind: str, solution: Solution, **values: Any) -> None:
        """A solution that takes these for its properties."""
        changed = replace(solution)
        changed.__dict__.update({"system": solution.system, **values})
        self.look(kind, changed)

    def segments(self, kind: str, change: Callable[[list[Any]], None],
                 solution: Solution | None = None) -> None:  # fmt: skip
        solution = solution or self.cycle
        parts = list(solution.segments)
        change(parts)
        self.look(kind, replace(solution, segments=tuple(parts)))


COLLISION, REST, RELEASE = EventKind.COLLISION, EventKind.REST, EventKind.RELEASE


def times(p: Patient) -> None:
    end = p.cycle.segments[-1].t_end
    clock = 16.0 * np.finfo(float).eps * end

    def later(parts: list[Any]) -> None:
        parts[1] = replace(parts[1], t_start=parts[1].t_start + 4.0 * clock)

    p.segments("time order", later)
    p.event("time order", COLLISION, number=77)
    p.event("time order", COLLISION, t=end + 2.0 * clock)


def outcomes(p: Patient) -> None:
    p.look("outcome", replace(p.cycle, outcome=Outcome.AT_REST, events=p.cycle.events[:3]))
    slower = replace(p.cycle.shaft, speed_rad_s=p.cycle.shaft.speed_rad_s * (1.0 - 2e-14))
    p.look("outcome", replace(p.cycle, shaft=slower))


def phases(p: Patient) -> None:
    stops = [stop.index for stop in p.cycle.mechanism.stops]
    p.event("phase logic", COLLISION, closed_before=frozenset({"jaw", "steeve"}))
    p.event("phase logic", RELEASE, closed_after=lambda e: e.closed_before)

    def off(event: Any) -> Any:
        q = event.q.copy()
        q[stops] += 1e-300
        return q

    def enters(event: Any) -> Any:
        v = event.v_after.copy()
        v[stops] = -1e-300
        return v

    p.event("phase logic", REST, q=off)
    p.event("phase logic", COLLISION, v_after=enters)

    def out_of_turn(parts: list[Any]) -> None:
        parts[-1] = replace(parts[-1], closed=frozenset({"no"}))

    p.segments("phase logic", out_of_turn)


def impacts(p: Patient) -> None:
    driven = p.cycle.system.driven

    def moved(name: str, by: float, place: Any = None) -> Callable[[Any], Any]:
        def change(event: Any) -> Any:
            values = getattr(event, name).copy()
            struck = p.cycle.mechanism.stop(event.stops[0]).index
            values[struck if place is None else place] += by
            return values

        return change

    p.event("impulse", COLLISION, delta=moved("delta", 1e-20, driven))
    p.event("impulse", COLLISION, P_g=lambda e: e.P_g * (1.0 + 3e-9))
    p.event("impulse", COLLISION, delta=moved("delta", 1e-9))
    p.event("impulse", COLLISION, v_after=moved("v_after", 1e-12))
    p.event("impulse", COLLISION, P_N=lambda e: {name: -P for name, P in e.P_N.items()})
    p.event("impulse", COLLISION, energy_lost=lambda e: e.energy_lost * (1.0 + 3e-9))


def motion(p: Patient) -> None:
    def locked(parts: list[Any]) -> None:
        place = next(i for i, item in enumerate(parts) if item.panels)
        parts[place] = replace(parts[place], closed=frozenset({"j0 lower", "j0 upper", "j1 upper"}))

    changed = list(p.chain.segments)
    locked(changed)
    assert violations(replace(p.chain, segments=tuple(changed)))
    true = invariants.shown
    of = p.cycle.mechanism.stop("jaw").index
    reach = p.cycle.system.body.reach_m
    eps = np.finfo(float).eps

    def seen(change: Callable[[Shown], Shown], word: str) -> None:
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(invariants, "shown", lambda *a: change(true(*a)))
            p.look("motion", p.cycle, word)

    def infinite(at: Shown) -> Shown:
        return at._replace(v=at.v + np.inf)

    def open_closure(at: Shown) -> Shown:
        # The steeve's rod is moved, a stop's coordinate is not.
        q = at.q.copy()
        q[:, 0] += 3000.0 * eps * reach
        return at._replace(q=q)

    def drifting(at: Shown) -> Shown:
        v = at.v.copy()
        v[:, 0] += 1e-9 * np.abs(v).max()
        return at._replace(v=v)

    def inside(at: Shown) -> Shown:
        q = at.q.copy()
        q[:, of] -= np.abs(q[:, of]).min() + 2e-12
        return at._replace(q=q)

    def unbalanced(at: Shown) -> Shown:
        return at._replace(closures=at.closures * (1.0 + 1e-7))

    def pulling(at: Shown) -> Shown:
        return at._replace(stops={name: -1e-4 * np.abs(x) for name, x in at.stops.items()})

    for change, word in (
        (infinite, "not finite"), (open_closure, "closure gap"), (drifting, "closure rate"),
        (inside, "penetrates"), (unbalanced, "segment"), (pulling, "segment"),
    ):  # fmt: skip
        seen(change, word)

    def other_slope(parts: list[Any]) -> None:
        place = next(i for i, s in enumerate(parts) if s.kinematic and s.t_end - s.t_start > 1e-3)
        panel = parts[place].panels[0]
        wrong = replace(panel, a=panel.a + 1e-4 * np.abs(panel.a).max())
        parts[place] = replace(parts[place], panels=(wrong, *parts[place].panels[1:]))

    p.segments("motion", other_slope)


def flights(p: Patient) -> None:
    def beside(parts: list[Any]) -> None:
        for i, item in enumerate(parts):
            wrong = tuple(replace(x, a=x.a * (1.0 + 1e-6)) for x in item.panels)
            parts[i] = replace(item, panels=wrong)

    p.segments("flights", beside, p.chain)


def elements(p: Patient) -> None:
    machine, system = p.chain.mechanism, p.chain.system

    def other(**changes: Any) -> None:
        p.known("springs and dampers", replace(p.chain, mechanism=replace(machine, **changes)),
                system=system)  # fmt: skip

    (spring,), (damper,) = machine.springs, machine.dampers
    other(springs=(replace(spring, stiffness=spring.stiffness * (1.0 + 5e-8)),))
    other(dampers=(replace(damper, damping=damper.damping * (1.0 + 5e-9)),))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(type(system), "dissipation", lambda _s, q, _v: np.full(len(q), -1e-12))
        p.look("springs and dampers", p.chain)


def continuity(p: Patient) -> None:
    jaw = p.cycle.mechanism.stop("jaw").index

    def jump(parts: list[Any]) -> None:
        for place, item in enumerate(parts):
            flying = [i for i, x in enumerate(item.panels) if x.integrated]
            if flying:
                panels = list(item.panels)
                panel = panels[flying[0]]
                q = panel.q.copy()
                q[:, jaw] += 2e-10
                panels[flying[0]] = replace(panel, q=q)
                parts[place] = replace(item, panels=tuple(panels))

    p.segments("continuity", jump)


def balance(p: Patient) -> None:
    energy = p.cycle.energy
    scale = abs(energy.drive_work) + energy.kinetic_peak
    wrong = replace(energy, impact_losses=energy.impact_losses + 1e-6 * scale)
    p.known("energy", p.cycle, energy=wrong)


def tables(p: Patient) -> None:
    interval = p.cycle.phases[1]
    late = replace(interval, t_start=np.nextafter(interval.t_end, 1.0))
    p.known("tables", p.cycle, phases=(late,))
    p.event("tables", REST, series_error=np.nan)

    hit = p.cycle.collisions[0]
    for name in ("approach_rate", "separation_rate", "impulse", "energy_lost"):
        wrong = replace(hit, **{name: getattr(hit, name) * (1.0 + 1e-14)})
        p.known("tables", p.cycle, collisions=(wrong,))
    amplitude = Rebounds.amplitude
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Rebounds, "amplitude", lambda *at: (1.0 + 1e-7) * (amplitude(*at) or 0.0))
        p.look("tables", replace(p.cycle))


def model(p: Patient) -> None:
    machine = p.cycle.mechanism
    for change in (heavier, stronger_gravity):
        built = machine.model.copy()
        change(built)
        wrong = replace(p.cycle, mechanism=replace(machine, model=built))
        p.look("model", wrong)
    case = replace(p.cycle.case, speed_rpm=p.cycle.case.speed_rpm * (1.0 + 1e-14))
    p.look("model", replace(p.cycle, case=case))
    stops = tuple(replace(stop, restitution=stop.restitution * 1.000001) for stop in machine.stops)
    p.known("model", replace(p.cycle, mechanism=replace(machine, stops=stops)),
            system=p.cycle.system)  # fmt: skip
    (spring,) = machine.springs
    for other in ((), (replace(spring, stiffness=spring.stiffness * (1.0 + 1e-14)),)):
        p.known("model", replace(p.cycle, mechanism=replace(machine, springs=other)),
                system=p.cycle.system)  # fmt: skip


def heavier(built: Any) -> None:
    built.inertias[3].mass *= 1.0 + 1e-8


def stronger_gravity(built: Any) -> None:
    built.gravity.linear = built.gravity.linear * (1.0 + 2e-9)


DOCTORS = {
    "time order": times, "outcome": outcomes, "phase logic": phases, "impulse": impacts,
    "motion": motion, "flights": flights, "springs and dampers": elements,
    "continuity": continuity, "energy": balance, "tables": tables, "model": model,
}  # fmt: skip


def test_every_check_has_its_planted_errors() -> None:
    assert DOCTORS.keys() == CHECKS.keys()


@pytest.mark.parametrize("doctor", DOCTORS.values())
def test_a_planted_error_is_refused(doctor: Doctor, cycle: Solution, chain: Solution) -> None:
    """By the check that it is for, which objects to something little beyond its limit."""
    doctor(Patient(cycle, chain))


def test_right_solutions_are_not_refused(
    cycle: Solution, transition: Solution, chain: Solution
) -> None:
    """What the doctored ones are made of: stops struck on both sides, and heat in dampers."""
    assert {hit.stop for hit in chain.collisions} >= {"j0 lower", "j0 upper", "j1 upper"}
    assert chain.energy.dissipated > 0.01
    for solution in (cycle, transition, chain):
        assert violations(solution) == []


# --- mirror images -------------------------------------------------------------------------------


def test_mirror_images_move_alike(chain: Solution) -> None:
    """All events of the mirror image are those of the machine; hinges have turned their stops.

    Twice mirrored is the model itself, number by number.
    """
    image = mirrored(everything())
    assert image is not None
    assert image.description["stops"]["j0 lower"]["side"] == "upper"
    assert image.description["stops"]["j1 upper"]["side"] == "upper"
    twice = mirrored(image)
    assert twice is not None
    assert bits(simulate(built(twice), CASE)) == bits(chain)
    seen = simulate(built(image), CASE)
    assert [(e.kind, e.stops) for e in seen.events] == [(e.kind, e.stops) for e in chain.events]
    assert mirror_images(chain, seen) == []


def wrong_place(image: Source) -> None:
    image.description["stops"]["j0 upper"]["at_deg"] *= 1.0 + 1e-6


def unturned_drive(image: Source) -> None:
    drive = image.description["drives"]["shaft"]
    drive["sine_rad"] = [-x for x in drive["sine_rad"]]


@pytest.mark.parametrize("wrong", [wrong_place, unturned_drive])
def test_a_mirror_image_with_a_wrong_sign_is_caught(
    chain: Solution, wrong: Callable[[Source], None]
) -> None:
    """What an engine with a wrong sign at one side would do to the image."""
    image = mirrored(everything())
    assert image is not None
    wrong(image)
    found = mirror_images(chain, simulate(built(image), CASE))
    assert {item.kind for item in found} == {"mirror"}


def of_another_law(document: dict[str, Any]) -> None:
    document["drives"]["arm"]["law"] = "oscillating_guide"


def of_shapes(document: dict[str, Any]) -> None:
    document["stops"]["flap1"]["contact"] = {}


@pytest.mark.parametrize("change", [of_another_law, of_shapes])
def test_what_has_no_mirror_image(change: Callable[[dict[str, Any]], None]) -> None:
    """Laws and shapes that would have to be drawn anew; the nipper of the package has both."""
    source = flaps(2, (0.3,), 0.2, 5.0, 3.0, 9.81)
    assert mirrored(source) is not None
    change(source.description)
    assert mirrored(source) is None
    assert mirrored(e62_source()) is None
