"""One run of the package beside the same run of the independent planar solver."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
from planar_judge.flight import Precision
from planar_judge.machine import Machine, build, read_machine
from planar_judge.record import Event, Verdict
from planar_judge.run import judge

import nipper_pin as nip

# What event times and, relatively, rates, impulses and forces may differ by.
TIME_S, SHARE = 1e-10, 1e-8
# Another resolution of the judge; where the two differ by such a share of that, the motion is too
# sensitive to be compared.
OTHER, _OWN = Precision(12, 1e-10, 1.0 / 40.0), 0.1
# Rates and impulses are known to a share of the largest of their kind.
_SMALL = 1e-6
# Time that the end of a series may take [s].
_LIMITS = 1e-6
# Nothing is known of an impulse, and of what follows it for such a part of a turn, whose error the
# package states as this share of it or more.
_NOTHING, _BEFORE = 0.5, 1e-3
_ROUND_OFF = 1e-15
# Events further apart, by what their times may differ by, are not the same ones.
_FAR = 10.0
# Times at which forces and motion are compared, in each turn.
_TIMES = 61
# Round-off of the angle by which a drive train is wound up, by the angle that it has turned.
_TWIST = 1e-14
# Forces change fast beside an event, whose time differs by round-off [turns].
_BESIDE = 1e-6


@dataclass
class Report:
    """How far two runs of one machine lie apart.

    Attributes:
        model: The model.
        refused_by_package: Why the package does not run it; empty if it does.
        refused_by_judge: Why the judge does not.
        events: Number of events that were compared.
        time: Largest difference of their times [s].
        rate: Largest relative difference of rates before and after.
        impulse: Of impulses and energies lost.
        force: Of forces of stops and drives, by their largest value in the run.
        motion: Of joint coordinates [rad or m].
        differs: What does not fit together at all: other events, another start.
        independence: How near the machine comes to a dead centre (0), by the judge.
        beyond: Largest difference of times, rates and impulses by what it may be: 1e-10 s and
            1e-8, or the error that the package states where this is more.
        sure: Time from which the package states more than that [s].
        horizon: Time from which the motion amplifies the judge's own round-off beyond use, or
            until which the two can be compared: round-off decides on the order of bounces, or on
            whether a stop is touched at all, or there are too many events [s].
    """

    model: str
    refused_by_package: str = ""
    refused_by_judge: str = ""
    events: int = 0
    time: float = 0.0
    rate: float = 0.0
    impulse: float = 0.0
    force: float = 0.0
    motion: float = 0.0
    differs: list[str] = field(default_factory=list)
    independence: float = 1.0
    beyond: float = 0.0
    sure: float = math.inf
    horizon: float = math.inf

    def cleared(self) -> None:
        """Forget all differences."""
        self.events, self.differs = 0, []
        self.time = self.rate = self.impulse = self.force = self.motion = self.beyond = 0.0
        self.sure = math.inf

    @property
    def verdict(self) -> str:
        """In two words; what agrees has the same events, within 1e-10 s and 1e-8.

        Where the package states a larger error, within that.
        """
        if self.refused_by_package and self.refused_by_judge:
            return "refused by both"
        if self.refused_by_package or self.refused_by_judge:
            return "refused by one"
        close = self.beyond <= 1.0 and self.force <= SHARE
        if not close or self.differs:
            return "DIFFER"
        return "agree" if self.horizon == math.inf else "agree in part"

    def line(self) -> str:
        """One line of a table."""
        figures = (
            f"{self.events:4d} events, time {self.time:.1e} s, rate {self.rate:.1e}, "
            f"impulse {self.impulse:.1e}, force {self.force:.1e}, motion {self.motion:.1e}"
        )
        words = [
            f"package: {self.refused_by_package}" if self.refused_by_package else "",
            f"judge: {self.refused_by_judge}" if self.refused_by_judge else "",
            f"{self.beyond:.2g} of the stated errors" if self.sure < math.inf else "",
            f"compared until {self.horizon:.6g} s" if self.horizon < math.inf else "",
            *self.differs[:3],
        ]
        return "; ".join([f"{self.model}: {self.verdict}", figures, *filter(None, words)])


def compare(
    folder: str | Path | tuple[nip.Mechanism, Machine],
    speed_rpm: float,
    drive: str = "held",
    turns: int = 1,
    *,
    start_index: float = 24.0,
    most: int = 20_000,
) -> Report:
    """Run a model folder on both and compare events, forces and motion.

    Args:
        folder: The model folder; or the machine as the package and as the judge hold it.
        speed_rpm: Speed of the input shaft [r/min].
        drive: "held" or "inertial".
        turns: Number of turns.
        start_index: Index of the start.
        most: Events after which the judge stops.
    """
    report = Report(str(folder) if isinstance(folder, str | Path) else folder[0].name)
    solution: nip.Solution | None = None
    try:
        mechanism = nip.load(str(folder)) if isinstance(folder, str | Path) else folder[0]
        case = nip.Case(
            speed_rpm=speed_rpm, window=nip.Window.CYCLE, cycles=turns, start_index=start_index,
            drive=nip.DriveMode(drive), reuse_cycles=False,
        )  # fmt: skip
        solution = nip.simulate(mechanism, case)
    except nip.NipperError as error:
        report.refused_by_package = f"{type(error).__name__}: {error}"
    machine = read_machine(folder) if isinstance(folder, str | Path) else folder[1]
    beginning: dict[str, Any] = {}
    free = _free_at_start(machine)
    if solution is not None and free > 0:
        motion = solution.trajectory.evaluate(0.0, left=True)
        names = [joint.name for joint in solution.mechanism.joints]
        beginning["coordinates"] = dict(zip(names, motion.q[0].tolist(), strict=True))
        before = solution.events[0].v_before if _at_start(solution) else motion.v[0]
        beginning["rates"] = dict(zip(names, before.tolist(), strict=True))
    verdict = judge(machine, speed_rpm, start_index, drive, turns, most=most, **beginning)
    report.independence = verdict.independence
    report.refused_by_judge = verdict.detail
    if solution is None:
        return report
    report.horizon = verdict.known
    if verdict.known < math.inf:
        report.refused_by_judge = ""
    _compared(report, solution, machine, verdict, verdict.known)
    if report.verdict == "DIFFER":
        # What the judge itself does not know is no measure: a motion may amplify round-off.
        again = judge(machine, speed_rpm, start_index, drive, turns, most=most, precision=OTHER,
                      **beginning)  # fmt: skip
        # Oscillations of an elastic drive train, and so its torque, want its shorter steps.
        report.cleared()
        report.horizon = min(again.known, verdict.known)
        _compared(report, solution, machine, again, report.horizon, verdict)
        horizon = min(_horizon(verdict, again), verdict.known, again.known)
        if report.verdict == "DIFFER" and horizon < math.inf:
            report.cleared()
            report.horizon = horizon
            _compared(report, solution, machine, verdict, horizon, again)
    return report


def both(mechanism: nip.Mechanism) -> tuple[nip.Mechanism, Machine]:
    """A machine as the package holds it, and as the judge reads it from the same two texts."""
    root = ElementTree.fromstring(mechanism.urdf)
    document: Any = mechanism.description
    # Blocks that the package has put into slots are its own way to describe them.
    for name, item in document.get("closures", {}).items():
        for part in list(root) if item.get("slot_axis") else ():
            if part.get("name") in {name, f"{name}_block"}:
                root.remove(part)
    return mechanism, build(ElementTree.tostring(root, encoding="unicode"), document)


def _compared(
    report: Report,
    solution: nip.Solution,
    machine: Machine,
    verdict: Verdict,
    horizon: float,
    other: Verdict | None = None,
) -> None:
    """Compare until a time; forces as far as another resolution of the judge gives them, too."""
    _events(report, solution, verdict, horizon)
    _forces(report, solution, machine, verdict, min(horizon, report.horizon), other)


def _horizon(one: Verdict, other: Verdict) -> float:
    """Time from which two resolutions of the judge differ by a tenth of what is asked for [s]."""
    fastest = _fastest(one.events)
    for first, second in zip(one.events, other.events, strict=False):
        same = first.kind == second.kind and first.stops == second.stops
        if same and first.kind == "collision":
            largest = max(first.impulses.values())
            same = all(
                _relative(mine, his[name], scale) <= _OWN * SHARE
                for mines, his, small in (
                    (first.before, second.before, fastest),
                    (first.after, second.after, fastest),
                    (first.impulses, second.impulses, dict.fromkeys(first.impulses, largest)),
                )
                for name, mine in mines.items()
                for scale in (_SMALL * small[name],)
            )
        if not same or abs(first.t - second.t) > _OWN * TIME_S:
            return first.t - 1e-9
    short = min(one.events, other.events, key=len)
    return math.inf if len(one.events) == len(other.events) else short[-1].t + 1e-9


def _fastest(events: list[Event]) -> dict[str, float]:
    """Fastest rate of each stop in a run, before or after a collision."""
    fastest: dict[str, float] = {}
    for item in events:
        for name, rate in item.before.items():
            fastest[name] = max(fastest.get(name, 0.0), abs(rate), abs(item.after[name]))
    return fastest


def _at_start(solution: nip.Solution) -> bool:
    return bool(solution.events) and solution.events[0].t == 0.0


def _free_at_start(machine: Machine) -> int:
    """Freedoms that drives and closed stops leave at the start."""
    rows = 2 * len(machine.pins) + len(machine.lines) + len(machine.locks)
    return 3 * len(machine.links.bodies[1:]) - rows - len(machine.drives) - len(machine.initial)


def _relative(one: float, other: float, scale: float) -> float:
    return abs(one - other) / max(abs(one), abs(other), scale) if one != other else 0.0


def _events(report: Report, solution: nip.Solution, verdict: Verdict, horizon: float) -> None:
    """Compare event by event; of series that end at their limit one may list more collisions."""
    ours = [item for item in solution.events if item.t < horizon]
    theirs = [item for item in verdict.events if item.t < horizon]
    end = verdict.t if verdict.reason else math.inf
    fastest = _fastest(theirs)
    i = j = 0
    while i < len(ours) and j < len(theirs):
        one, other = ours[i], theirs[j]
        if not _alike(solution, one, other):
            # One of the two takes the limit of a series earlier, or of all that rests at once.
            faint = all(abs(rate) <= _SMALL * fastest[n] for n, rate in other.before.items())
            resting = faint or "rest" in (one.kind.value, other.kind)
            places = _resting(solution, theirs, one, j) if resting else None
            if places is None and (faint or _unsure(solution, one)):
                # Round-off decides on what comes next.
                report.horizon = min(report.horizon, one.t, other.t) - TIME_S
                return
            if places is None:
                report.differs.append(
                    f"{one.kind.value} of {', '.join(one.stops)} at {one.t:.12g} s, then closed "
                    f"{sorted(one.closed_after)}; the judge has {other.kind} of "
                    f"{', '.join(other.stops)} at {other.t:.12g} s, {sorted(other.closed)}"
                )
                return
            number, j = places
            i = number - 1
            one, other = solution.events[i], theirs[j]
        _event(report, solution, one, other, fastest)
        i, j = i + 1, j + 1
    more = [item for item in ours[i:] if item.t < min(end, verdict.known - TIME_S)]
    late, following = theirs[j:], list(solution.events[len(ours) :])
    if verdict.known < math.inf and following and following[0].kind.value == "rest":
        # Of a series whose end the judge does not know the package has taken the limit.
        late = []
    while late and following and _alike(solution, following[0], late[0]):
        # Two times of one event lie on either side of the end of what is compared.
        _event(report, solution, following.pop(0), late.pop(0), fastest)
    if more or late:
        report.differs.append(
            f"{len(more)} events more of the package, {len(late)} more of the judge"
        )


def _alike(solution: nip.Solution, one: Any, other: Event) -> bool:
    """Whether two events may be the same one."""
    apart = _FAR * max(TIME_S, solution.errors[one.number - 1].time)
    # An impulse of round-off beside that of the stop which is struck is none.
    least = _ROUND_OFF * max(one.P_N.values(), default=0.0)
    struck = {name for name in one.stops if name in other.stops or one.P_N.get(name, 1.0) > least}
    return bool(
        one.kind.value == other.kind
        and struck == set(other.stops)
        and one.closed_after == other.closed
        and abs(one.t - other.t) <= apart
    )


def _unsure(solution: nip.Solution, one: Any) -> bool:
    """Whether the package states of an event, or of one just before it, that it knows nothing."""
    near = one.t - _BEFORE * solution.shaft.period
    stated = zip(solution.events[: one.number], solution.errors, strict=False)
    return any(item.t >= near and error.impulse >= _NOTHING for item, error in stated)


def _resting(
    solution: nip.Solution, theirs: list[Event], one: Any, j: int
) -> tuple[int, int] | None:
    """Numbers of the next rests on the same stops at the same time, the limit of one series."""
    until = max(one.t, theirs[j].t) + _LIMITS
    rests = [
        place
        for place in range(j, len(theirs))
        if theirs[place].kind == "rest" and theirs[place].t <= until
    ]
    for mine in solution.events[one.number - 1 :]:
        if mine.t > until:
            return None
        apart = max(TIME_S, solution.errors[mine.number - 1].time)
        for place in rests if mine.kind.value == "rest" else ():
            same = mine.closed_after == theirs[place].closed
            if same and abs(mine.t - theirs[place].t) <= apart:
                return mine.number, place
    return None


def _event(
    report: Report, solution: nip.Solution, one: Any, other: Event, fastest: dict[str, float]
) -> None:
    stated = solution.errors[one.number - 1]
    report.events += 1
    report.time = max(report.time, abs(one.t - other.t))
    report.beyond = max(report.beyond, abs(one.t - other.t) / max(TIME_S, stated.time))
    if max(stated.time / TIME_S, stated.impulse / SHARE) > 1.0:
        report.sure = min(report.sure, other.t)
    if other.kind != "collision" or stated.impulse >= _NOTHING:
        return
    rates = [abs(rate) for rate in (*other.before.values(), *other.after.values())]
    for name in other.before:
        stop = solution.mechanism.stop(name)
        for mine, his in (
            (stop.rate(one.v_before), other.before[name]),
            (stop.rate(one.v_after), other.after[name]),
        ):
            small, known = _SMALL * fastest[name], stated.impulse * max(rates)
            report.rate = max(report.rate, _relative(mine, his, small))
            report.beyond = max(report.beyond, _beyond(mine, his, small, known))
        mine, his = one.P_N.get(name, 0.0), other.impulses[name]
        small, known = _SMALL * max(other.impulses.values()), stated.impulses.get(name, 0.0)
        report.impulse = max(report.impulse, _relative(mine, his, small))
        report.beyond = max(report.beyond, _beyond(mine, his, small, known))
    small = _SMALL * max(item.energy_lost for item in solution.events)
    mine, his = one.energy_lost, other.lost
    report.impulse = max(report.impulse, _relative(mine, his, small))
    known = 2.0 * stated.impulse * abs(his)
    report.beyond = max(report.beyond, _beyond(mine, his, small, known))


def _beyond(one: float, other: float, scale: float, stated: float) -> float:
    """A difference by what it may be: 1e-8 relative, or the error that the package states."""
    allowed = max(SHARE * max(abs(one), abs(other), scale), stated)
    return abs(one - other) / allowed if one != other else 0.0


def _forces(
    report: Report,
    solution: nip.Solution,
    machine: Machine,
    verdict: Verdict,
    horizon: float,
    again: Verdict | None,
) -> None:
    """Compare forces and motion at times that are beside no event."""
    if not verdict.stretches or not solution.segments:
        return
    last = verdict.stretches[-1].step
    turn = solution.shaft.period
    end = min(last.t0 + last.h, solution.trajectory.span[1], horizon, report.sure)
    times = np.linspace(0.0, end, max(int(_TIMES * end / turn), 7) + 1)[1:-1] + 1.234e-4 * turn
    marks = np.array([item.t for item in solution.events] + [item.t for item in verdict.events])
    if len(marks):
        near = np.abs(times[:, None] - marks).min(axis=1)
        times = times[(near > _BESIDE * turn) & (times < end)]
    if report.differs:
        return
    forces = solution.trajectory.reactions(times)
    motion = solution.trajectory.evaluate(times)
    names = [joint.name for joint in solution.mechanism.joints]
    columns = [verdict.coordinates.index(name) for name in names]
    for row, t in enumerate(times):
        q, _ = verdict.motion(t)
        report.motion = max(report.motion, float(np.abs(q[columns] - motion.q[row]).max()))
    # What nothing pulls at has a force of round-off, beside the inertia of what moves.
    sets = [
        *((forces.stops[name], name, "stop_force") for name in forces.stops),
        *((forces.drives[name], name, "drive_force") for name in forces.drives),
    ]
    found = [
        (name, mine, *(_forces_of(v, name, kind, times) for v in (verdict, again)))
        for mine, name, kind in sets
    ]
    most = max((float(np.abs(his).max(initial=0.0)) for *_, his, _ in found), default=0.0)
    wound = _wound(solution, machine, end)
    least = max(1e-6 * _inertia_force(solution, motion.v, forces.a), 1e-9 * most)
    for name, mine, his, own in found:
        largest = max(float(np.abs(his).max(initial=0.0)), least)
        unknown = wound.get(name, 0.0) + (0.0 if again is None else np.abs(his - own))
        if largest > 0.0:
            off = np.maximum(np.abs(mine - his) - unknown, 0.0)
            report.force = max(report.force, float(off.max(initial=0.0)) / largest)


def _forces_of(verdict: Verdict | None, name: str, kind: str, times: Any) -> Any:
    """Forces of a stop or drive by the judge at these times [N or N m]."""
    return np.array([getattr(verdict, kind)(name, t) for t in times] if verdict else [])


def _wound(solution: nip.Solution, machine: Machine, end: float) -> dict[str, float]:
    """Round-off of the torques of elastic drive trains [N m], or of their forces [N], by drive."""
    if solution.case.drive is nip.DriveMode.HELD:
        return {}
    turned = solution.shaft.speed_rad_s * end
    return {
        drive.name: drive.inertia * drive.frequency**2 * _TWIST * max(turned, 1.0)
        for drive in machine.drives
    }


def _inertia_force(solution: nip.Solution, v: Any, a: Any) -> float:
    """Size of the forces that accelerate the lightest link [N], or its moments [N m]."""
    lightest = min(inertia.mass for inertia in list(solution.mechanism.model.inertias)[1:])
    reach = solution.system.body.reach_m
    fastest = float(np.abs(v).max(initial=0.0)) ** 2 + float(np.abs(a).max(initial=0.0))
    return float(lightest * min(reach, 1.0) ** 2 * fastest)
