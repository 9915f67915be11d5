"""Each limit of the judge is shown a solution that is a little beyond it, and refuses it.

The places where a check can object are read off its source, so that a check without a doctored
solution fails here, and so does one whose limit has become a hundred times too wide.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from machine_of_all_elements import CASE, everything

import benchmarks.stress as stress
from benchmarks.stress import CHECKS, violations
from benchmarks.stress.checks import invariants
from benchmarks.stress.observations import Shown, samples
from nipper_pin import Case, EventKind, Mechanism, Outcome, Solution, Window, simulate
from nipper_pin.mechanism import from_sources

_FILES = ("invariants", "impacts", "elements", "model", "rebounds", "flights")
# A doctored solution is beyond its limit by at most this factor.
_NEAR = 100.0


@dataclass(frozen=True)
class Site:
    """A place where a check objects: its text, and whether a limit belongs to it."""

    file: str
    text: str
    limited: bool

    def said(self, texts: list[str]) -> list[str]:
        ending = r": ([-\d.e+naif]+), at most ([-\d.e+naif]+)" if self.limited else ""
        pattern = re.compile(self.text + ending, re.DOTALL)
        return [text for text in texts if pattern.fullmatch(text)]


def _pattern(node: ast.expr) -> str | None:
    if isinstance(node, ast.Constant) and isinstance(node.value, str):
        return re.escape(node.value)
    if isinstance(node, ast.JoinedStr):
        parts = (
            re.escape(part.value) if isinstance(part, ast.Constant) else ".*"
            for part in node.values
        )  # fmt: skip
        return "".join(parts)
    return None


def sites() -> list[Site]:
    found = []
    for name in _FILES:
        tree = ast.parse((Path(stress.__file__).parent / f"checks/{name}.py").read_text())
        for node in ast.walk(tree):
            if isinstance(node, ast.Call) and getattr(node.func, "id", "") == "beyond":
                text, limited = _pattern(node.args[0]), True
            elif isinstance(node, ast.Yield) and node.value is not None:
                text, limited = _pattern(node.value), False
            else:
                continue
            if text is not None:
                found.append(Site(name, text, limited))
    return found


SITES = sites()


def test_sites_are_found() -> None:
    """Some fifty, of every file and of every check; else the test below would show nothing."""
    assert len(DOCTORS) == len(CHECKS)
    assert {site.file for site in SITES} == set(_FILES)
    assert len(SITES) > 45


@pytest.fixture(scope="module")
def cycle(e62: Mechanism) -> Solution:
    return simulate(e62, Case(speed_rpm=650.0, window=Window.CYCLE))


@pytest.fixture(scope="module")
def transition(e62: Mechanism) -> Solution:
    return simulate(e62, Case(speed_rpm=650.0))


@pytest.fixture(scope="module")
def chain() -> Solution:
    source = everything()
    machine = from_sources(source.name, source.urdf, source.description, source.folder)
    return simulate(machine, CASE)


Doctor = Callable[[Any], None]


class Patient:
    """Solutions to be changed, and what the checks say of them."""

    def __init__(self, cycle: Solution, chain: Solution) -> None:
        self.cycle, self.chain = cycle, chain
        self.texts: list[str] = []

    def look(self, kind: str, solution: Solution) -> None:
        self.texts += CHECKS[kind](solution)

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

    def backwards(parts: list[Any]) -> None:
        parts[1] = replace(parts[1], t_start=np.nextafter(parts[1].t_end, 1.0))

    p.segments("time order", later)
    p.segments("time order", backwards)
    p.event("time order", COLLISION, number=77)
    p.event("time order", COLLISION, t=end + 2.0 * clock)
    first = next(i for i, e in enumerate(p.cycle.events) if i and e.kind is COLLISION)
    before = p.cycle.events[first - 1].t - 4.0 * clock
    events = list(p.cycle.events)
    events[first] = replace(events[first], t=before)
    p.look("time order", replace(p.cycle, events=tuple(events)))


def outcomes(p: Patient) -> None:
    p.look("outcome", replace(p.cycle, outcome=Outcome.AT_REST, events=p.cycle.events[:3]))
    many = Outcome.TOO_MANY_COLLISIONS
    collisions = sum(event.kind is COLLISION for event in p.cycle.events)
    case = replace(p.cycle.case, max_collisions=collisions + 1)
    p.look("outcome", replace(p.cycle, outcome=many, case=case))
    slower = replace(p.cycle.shaft, speed_rad_s=p.cycle.shaft.speed_rad_s * (1.0 - 2e-14))
    p.look("outcome", replace(p.cycle, shaft=slower))
    hard = tuple(replace(stop, restitution=1.0) for stop in p.cycle.mechanism.stops)
    p.known("outcome", replace(p.cycle, mechanism=replace(p.cycle.mechanism, stops=hard)))


def phases(p: Patient) -> None:
    stops = [stop.index for stop in p.cycle.mechanism.stops]
    p.event("phase logic", COLLISION, closed_before=frozenset({"jaw", "steeve"}))
    p.event("phase logic", RELEASE, closed_after=lambda e: e.closed_before)
    p.event("phase logic", REST, closed_after=frozenset())
    p.event("phase logic", COLLISION, closed_after=frozenset({"jaw", "steeve"}), P_N={})

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
    p.event("impulse", COLLISION, v_after=moved("v_after", 2e-9))
    for by in (3e-11, 1e-12):
        p.event("impulse", COLLISION, v_after=moved("v_after", by))
    p.event("impulse", COLLISION, v_after=moved("v_after", -1e-12))
    p.event("impulse", COLLISION, P_N=lambda e: {name: -P for name, P in e.P_N.items()})
    p.event("impulse", COLLISION, energy_lost=lambda e: e.energy_lost * (1.0 + 3e-9))
    p.event("impulse", COLLISION, energy_lost=-5e-12)
    p.event("impulse", COLLISION, v_before=lambda e: np.abs(e.v_before))


def motion(p: Patient) -> None:
    def locked(parts: list[Any]) -> None:
        place = next(i for i, item in enumerate(parts) if item.panels)
        parts[place] = replace(parts[place], closed=frozenset({"j0 lower", "j0 upper", "j1 upper"}))

    changed = list(p.chain.segments)
    locked(changed)
    p.texts += [v.detail for v in violations(replace(p.chain, segments=tuple(changed)))]
    true = invariants.shown
    of = p.cycle.mechanism.stop("jaw").index
    reach = p.cycle.system.body.reach_m
    eps = np.finfo(float).eps

    def seen(change: Callable[[Shown], Shown], solution: Solution) -> None:
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(invariants, "shown", lambda *a: change(true(*a)))
            p.look("motion", solution)

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

    def ajar(at: Shown) -> Shown:
        q = at.q.copy()
        q[:, [stop.index for stop in p.cycle.mechanism.stops]] += 1e-300
        return at._replace(q=q)

    def inside(at: Shown) -> Shown:
        q = at.q.copy()
        q[:, of] -= np.abs(q[:, of]).min() + 2e-12
        return at._replace(q=q)

    def unbalanced(at: Shown) -> Shown:
        return at._replace(closures=at.closures * (1.0 + 1e-7))

    def pulling(at: Shown) -> Shown:
        return at._replace(stops={name: -1e-4 * np.abs(x) for name, x in at.stops.items()})

    for change in (infinite, open_closure, drifting, ajar, inside, unbalanced, pulling):
        seen(change, p.cycle)

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

    (spring,), (damper,), (table,) = machine.springs, machine.dampers, machine.tabulated_springs
    other(springs=(replace(spring, stiffness=spring.stiffness * (1.0 + 5e-8)),))
    other(dampers=(replace(damper, damping=damper.damping * (1.0 + 5e-9)),))
    rows = table.characteristic

    class Other:
        """The same rows, a little above both ends of them or a little shorter."""

        def __init__(self, above: float, low: float) -> None:
            self.coordinate, self.force = (low, *rows.coordinate[1:]), rows.force
            self._above = above

        def forces(self, x: Any) -> Any:
            place = min(max(int(np.searchsorted(rows.coordinate, x[0])), 1), len(rows.force) - 1)
            high = max(rows.force[place - 1 : place + 1])
            return np.array([high + self._above]) if self._above else rows.forces(x)

    looked = np.concatenate([t for _, _, t in samples(p.chain)])
    least = float(p.chain.trajectory.evaluate(looked).q[:, table.index].min())
    width = rows.coordinate[-1] - rows.coordinate[0]
    for above, low in ((1e-6, rows.coordinate[0]), (0.0, least + 1e-7 * width)):
        other(tabulated_springs=(replace(table, characteristic=Other(above, low)),))
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

    class Hit:
        def __init__(self, hit: Any, **changes: float) -> None:
            self.__dict__.update({name: getattr(hit, name) for name in (
                "number", "stop", "t", "approach_rate", "separation_rate", "impulse",
                "energy_lost", "event", "rebound_amplitude", "rebound_time")})  # fmt: skip
            self.__dict__.update(changes)

    hit = p.cycle.collisions[0]
    for name, factor in (("approach_rate", 1.0), ("separation_rate", 1.0), ("impulse", 1.0),
                         ("energy_lost", 1.0), ("rebound_amplitude", 1e7),
                         ("rebound_time", 40.0)):  # fmt: skip
        value = getattr(hit, name) * (1.0 + 1e-14 * factor)
        p.known("tables", p.cycle, collisions=(Hit(hit, **{name: value}),))
    p.known("tables", p.cycle, collisions=(Hit(hit, rebound_amplitude=-1.0),))


def model(p: Patient) -> None:
    machine = p.cycle.mechanism
    for change in (heavier, stronger_gravity):
        built = machine.model.copy()
        change(built)
        wrong = replace(p.cycle, mechanism=replace(machine, model=built))
        p.look("model", wrong)
    case = replace(p.cycle.case, speed_rpm=p.cycle.case.speed_rpm * (1.0 + 1e-14))
    p.look("model", replace(p.cycle, case=case))
    (spring,) = machine.springs
    for other in ((), (replace(spring, stiffness=spring.stiffness * (1.0 + 1e-14)),)):
        p.known("model", replace(p.cycle, mechanism=replace(machine, springs=other)),
                system=p.cycle.system)  # fmt: skip


def heavier(built: Any) -> None:
    built.inertias[3].mass *= 1.0 + 1e-8


def stronger_gravity(built: Any) -> None:
    built.gravity.linear = built.gravity.linear * (1.0 + 2e-9)


# A number of each kind of element, stop and drive; by the power of springs and dampers, too.
NUMBERS = {
    "springs": ("stiffness", "preload"), "dampers": ("damping",),
    "struts": ("stiffness", "free_length", "damping"), "tabulated_springs": ("characteristic",),
    "stops": ("restitution", "at", "sense"),
    "drives": ("reflected_inertia", "shaft_frequency_hz", "shaft_damping_ratio"),
}  # fmt: skip
ELEMENTS = ("springs", "dampers", "struts", "tabulated_springs")


@pytest.mark.parametrize(
    ("table", "number"), [(table, item) for table, items in NUMBERS.items() for item in items]
)
def test_each_number_of_the_model_is_that_of_its_text(
    chain: Solution, table: str, number: str
) -> None:
    """Larger by a millionth: seen beside the text, and of elements by their power."""

    def larger(item: Any) -> Any:
        value = getattr(item, number)
        if number == "characteristic":
            more = replace(value, force=tuple(1.000001 * x for x in value.force))
        else:
            more = 1.000001 * value
        return replace(item, **{number: more})

    items = getattr(chain.mechanism, table)
    assert any(larger(item) != item for item in items)
    wrong = replace(chain, mechanism=replace(chain.mechanism, **{table: tuple(map(larger, items))}))
    # The engine goes on with the machine that it had.
    wrong.__dict__["system"] = chain.system
    assert [*CHECKS["model"](wrong)]
    if table in ELEMENTS:
        assert [*CHECKS["springs and dampers"](wrong)]
    elif number == "at":
        # Those below their stop penetrate it, and those on it are open.
        assert [*CHECKS["motion"](wrong)]


def test_points_of_a_strut_are_those_of_its_text(chain: Solution) -> None:
    """On another frame: its power is another one."""
    struts = tuple(replace(item, frame_b="b1") for item in chain.mechanism.struts)
    wrong = replace(chain, mechanism=replace(chain.mechanism, struts=struts))
    wrong.__dict__["system"] = chain.system
    assert [*CHECKS["springs and dampers"](wrong)]


DOCTORS = (times, outcomes, phases, impacts, motion, flights, elements, continuity, balance,
           tables, model)  # fmt: skip


@pytest.fixture(scope="module")
def texts(cycle: Solution, chain: Solution) -> list[str]:
    patient = Patient(cycle, chain)
    for doctor in DOCTORS:
        doctor(patient)
    return patient.texts


@pytest.mark.parametrize("site", SITES, ids=lambda site: re.sub(r"[\\.*]+", " ", site.text)[:50])
def test_each_limit_refuses_what_is_a_little_beyond_it(site: Site, texts: list[str]) -> None:
    """A doctored solution is refused at this place, and by no more than a hundred times."""
    said = site.said(texts)
    assert said
    if site.limited:
        numbers = [re.search(r": (\S+), at most (\S+)$", text) for text in said]
        pairs = [(float(m[1]), float(m[2])) for m in numbers if m]
        assert any(most <= 0.0 or found <= _NEAR * most for found, most in pairs), said


def test_right_solutions_are_not_refused(
    cycle: Solution, transition: Solution, chain: Solution
) -> None:
    """What the doctored ones are made of."""
    assert violations(cycle) == []
    assert violations(transition) == []
    assert violations(chain) == []
