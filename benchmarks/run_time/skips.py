"""Computations that a simulation skips, each measured with and without the skip.

``with`` is the time with the skip in force, as the package runs; ``without`` the same work with the
thing done after all. A skip without a comparable version is not listed.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import coal
import numpy as np
import pinocchio as pin
from scipy.integrate import DOP853

from nipper_pin.arrays import FloatArray
from nipper_pin.dynamics.multipliers import Multipliers, multipliers
from nipper_pin.dynamics.system import System
from nipper_pin.hybrid.case import Case, Window
from nipper_pin.hybrid.result.solution import Solution
from nipper_pin.hybrid.result.trajectory import closure_residuals
from nipper_pin.hybrid.segment import Segment
from nipper_pin.hybrid.simulate import simulate
from nipper_pin.mechanism import Mechanism, collision_model

from .imports import left_out
from .phase_cost import again
from .timing import timed

Pictures = Callable[[Solution, Path], object]

SPEED_RPM = 650.0
_SAMPLES = 1000


@dataclass(frozen=True)
class Skip:
    """One thing that is left out.

    Attributes:
        what: What, and in which work.
        with_ms: Time with the skip [ms].
        without_ms: Time without it [ms].
    """

    what: str
    with_ms: float
    without_ms: float


def skips(
    mechanism: Mechanism, *, quick: bool, repeats: int, pictures: Pictures | None = None
) -> list[Skip]:
    """Measure the list.

    Args:
        mechanism: The E62.
        quick: Fewer turns and fresh interpreters.
        repeats: Runs after the first.
        pictures: Draws a solution into a folder; without it that line is left out.
    """
    found = [
        _kinematic(mechanism, repeats),
        _repeating(mechanism, 10 if quick else 100, max(1, repeats // 5)),
        *_asked_for(mechanism, repeats),
        *_prescribed(mechanism, repeats),
        _refinement(mechanism, repeats),
        _contact_search(mechanism, repeats),
        _dead_rows(mechanism, repeats),
    ]
    if pictures is not None:
        found.append(_plots(mechanism, pictures, 1 if quick else 3))
    libraries = left_out(2 if quick else 5)
    return found + [
        Skip(f"import of {name} (start of the command)", *ms) for name, *ms in libraries
    ]


def _kinematic(mechanism: Mechanism, repeats: int) -> Skip:
    """Phases 1 and 2 solved node by node; without: integrated as equations of motion.

    The integrator is SciPy's DOP853 with the same accelerations and the engine's default accuracy;
    it is spared event location, dense output and forces, and the engine is not.
    """
    solution = simulate(mechanism, Case(speed_rpm=SPEED_RPM, window=Window.CYCLE))
    segments = [item for item in solution.segments if item.kinematic]
    done = timed(lambda: [again(solution, item) for item in segments], repeats)
    integrated = timed(
        lambda: [integrate(solution, item) for item in segments], max(1, repeats // 3)
    )
    return Skip(
        "integration of kinematic phases (phases 1 and 2 of a turn; without: DOP853)",
        done.median_ms,
        integrated.median_ms,
    )


def integrate(solution: Solution, segment: Segment) -> tuple[FloatArray, FloatArray]:
    """Follow a segment by DOP853 and return q and v at its end, each of shape (nv,)."""
    system, nv = solution.system, solution.system.body.nv
    phase = system.constraint_set(segment.closed)
    tolerance = solution.case.resolution.tolerance

    def right_side(t: float, y: FloatArray) -> FloatArray:
        q, v = y[None, :nv], y[None, nv:]
        a = system.accelerations(system.shaft.driven(np.array([t])), q, v, phase)
        return np.concatenate([v[0], a[0]])

    first = segment.panels[0]
    start = np.concatenate([first.q[0], first.v[0]])
    solver = DOP853(
        right_side, segment.t_start, start, segment.t_end, rtol=max(tolerance, 1e-13), atol=1e-12
    )
    while solver.status == "running":
        solver.step()
    return solver.y[:nv], solver.y[nv:]


def _repeating(mechanism: Mechanism, turns: int, repeats: int) -> Skip:
    times = [
        timed(
            lambda: simulate(
                mechanism,
                Case(
                    speed_rpm=SPEED_RPM,
                    window=Window.CYCLE,
                    cycles=turns,
                    reuse_cycles=reuse,  # noqa: B023
                ),
            ),
            repeats,
        ).median_ms
        for reuse in (True, False)
    ]
    return Skip(f"turns that repeat exactly ({turns} turns)", *times)


def _asked_for(mechanism: Mechanism, repeats: int) -> list[Skip]:
    """Properties of a solution that are computed at their first use."""
    transition = Case(speed_rpm=SPEED_RPM)
    turn = Case(speed_rpm=SPEED_RPM, window=Window.CYCLE)

    def sampled(solution: Solution) -> FloatArray:
        return np.linspace(*solution.trajectory.span, _SAMPLES)

    asked: list[tuple[str, Case, Callable[[Solution], object]]] = [
        ("amplitudes and rebound times (transition)", transition, lambda s: s.collisions),
        (
            f"dense motion, {_SAMPLES} samples (turn)",
            turn,
            lambda s: s.trajectory.evaluate(sampled(s)),
        ),
        (
            f"reactions in all joints, {_SAMPLES} samples (turn)",
            turn,
            lambda s: s.trajectory.reactions(sampled(s)),
        ),
        ("stated errors of all events (transition)", transition, lambda s: s.errors),
        ("energy balance (turn)", turn, lambda s: s.energy),
        (
            "closure check (turn)",
            turn,
            lambda s: closure_residuals(s.system, s.segments),
        ),
    ]
    bare = {
        case: timed(lambda: simulate(mechanism, case), repeats).median_ms  # noqa: B023
        for case in (transition, turn)
    }
    return [
        Skip(
            what,
            bare[case],
            timed(lambda: question(simulate(mechanism, case)), repeats).median_ms,  # noqa: B023
        )
        for what, case, question in asked
    ]


def _prescribed(mechanism: Mechanism, repeats: int) -> list[Skip]:
    """Links that the drives move as prescribed: a flight leaves out what only they matter for.

    That is the torques on them and their bearing reactions. Without the skip these are computed at
    the nodes of the motion. A reaction needs all forces further out, so the package only has a
    function for all joints at once. The system is at hand beforehand, as in a run.
    """
    case = Case(speed_rpm=SPEED_RPM)
    system = simulate(mechanism, case).system

    def torques() -> None:
        for segment in simulate(mechanism, case).segments:
            node_forces(system, segment)

    def reactions() -> None:
        for segment in simulate(mechanism, case).segments:
            for panel, forces in zip(segment.panels, node_forces(system, segment), strict=True):
                for state in zip(panel.q, panel.v, panel.a, forces.la_g, strict=True):
                    system.body.joint_wrenches(*state)

    bare = timed(lambda: simulate(mechanism, case), repeats).median_ms
    return [
        Skip(f"links whose motion is prescribed: {what}", bare, timed(work, repeats).median_ms)
        for what, work in (
            ("torques (transition)", torques),
            ("torques and reactions (transition; all joints at once)", reactions),
        )
    ]


def _refinement(mechanism: Mechanism, repeats: int) -> Skip:
    """Accelerations of light bodies are refined; of a machine without them, they are not."""
    solution = simulate(mechanism, Case(speed_rpm=SPEED_RPM))
    system = solution.system
    nodes = [
        (system.constraint_set(segment.closed), system.shaft.driven(panel.times), panel)
        for segment in solution.segments
        for panel in segment.panels
    ]

    def plain() -> None:
        for rows, motion, panel in nodes:
            system.accelerations(motion, panel.q, panel.v, rows)

    def refined() -> None:
        for rows, motion, panel in nodes:
            a = system.accelerations(motion, panel.q, panel.v, rows)
            system.body.refined(panel.q, panel.v, a, rows.armature)

    return Skip(
        "refinement of accelerations (dynamics at the nodes of a transition)",
        timed(plain, repeats).median_ms,
        timed(refined, repeats).median_ms,
    )


def node_forces(system: System, segment: Segment) -> list[Multipliers]:
    """Forces of constraint at the nodes of a segment, drive torques among them, panel by panel."""
    phase = system.constraint_set(segment.closed)
    return [
        multipliers(
            system,
            system.shaft.driven(panel.times),
            panel.q,
            panel.v,
            panel.a,
            system.body.closures(panel.q)[1],
            phase,
            panel.split,
        )
        for panel in segment.panels
    ]


def _plots(mechanism: Mechanism, pictures: Pictures, repeats: int) -> Skip:
    case = Case(speed_rpm=SPEED_RPM)
    bare = timed(lambda: simulate(mechanism, case), repeats)
    with tempfile.TemporaryDirectory() as folder:
        drawn = timed(lambda: pictures(simulate(mechanism, case), Path(folder)), repeats)
    return Skip("plots (transition)", bare.median_ms, drawn.median_ms)


def _contact_search(mechanism: Mechanism, repeats: int) -> Skip:
    """The contact of the lips is found once, at load; without: a query at every evaluation."""
    case = Case(speed_rpm=SPEED_RPM)
    solution = simulate(mechanism, case)
    geometry, lips = _lips(mechanism)
    data = mechanism.model.createData()
    states = [panel.q[node] for segment in solution.segments for panel in segment.panels
              for node in range(panel.order)]  # fmt: skip
    pair, request, result = lips, coal.DistanceRequest(), coal.DistanceResult()
    shapes = [geometry.geometryObjects[number] for number in pair]

    def query(q: FloatArray) -> float:
        pin.forwardKinematics(mechanism.model, data, q)
        places = [data.oMi[shape.parentJoint] * shape.placement for shape in shapes]
        first, second = (coal.Transform3s(item.rotation, item.translation) for item in places)
        result.clear()
        return float(
            coal.distance(shapes[0].geometry, first, shapes[1].geometry, second, request, result)
        )

    def searched() -> Solution:
        run = simulate(mechanism, case)
        for number in range(run.evaluations):
            query(states[number % len(states)])
        return run

    return Skip(
        "search for the contact of the lips (transition; without: coal at every evaluation)",
        timed(lambda: simulate(mechanism, case), repeats).median_ms,
        timed(searched, repeats).median_ms,
    )


def _lips(mechanism: Mechanism) -> tuple[pin.GeometryModel, tuple[int, int]]:
    """The collision shapes, and the two at the jaw that come nearest when it is shut."""
    geometry, _ = collision_model(mechanism)
    stop = mechanism.stop(mechanism.transition_stop)
    joint = next(item for item in mechanism.joints if item.index == stop.index)
    upper = mechanism.model.getJointId(joint.name)
    lower = mechanism.model.parents[upper]
    items = list(enumerate(geometry.geometryObjects))
    data = mechanism.model.createData()
    pin.forwardKinematics(mechanism.model, data, pin.neutral(mechanism.model))

    def distance(pair: tuple[int, int]) -> float:
        shapes = [geometry.geometryObjects[number] for number in pair]
        places = [data.oMi[shape.parentJoint] * shape.placement for shape in shapes]
        first, second = (coal.Transform3s(item.rotation, item.translation) for item in places)
        request, result = coal.DistanceRequest(), coal.DistanceResult()
        return abs(
            float(
                coal.distance(
                    shapes[0].geometry, first, shapes[1].geometry, second, request, result
                )
            )
        )

    pairs = [
        (a, b)
        for a, one in items
        for b, other in items
        if one.parentJoint == lower and other.parentJoint == upper
    ]
    return geometry, min(pairs, key=distance)


def _dead_rows(mechanism: Mechanism, repeats: int) -> Skip:
    """Impact with two planar rows for each pin; without: all three, damped to be solvable.

    The rows out of the plane are dead: they carry nothing, and without damping the impulses of the
    larger system are not determined.
    """
    model, data = pin.Model(mechanism.model), mechanism.model.createData()
    solution = simulate(mechanism, Case(speed_rpm=SPEED_RPM))
    event = solution.events[0]
    _, planar = solution.system.body.closures(event.q[None])
    stop = np.zeros((1, model.nv))
    stop[0, mechanism.stop(mechanism.transition_stop).index] = 1.0
    few = np.vstack([planar[0], stop])
    many = np.vstack([planar[0], np.zeros((len(mechanism.closures), model.nv)), stop])
    batch = range(1000)

    def impacts(rows: FloatArray, damping: float) -> None:
        for _ in batch:
            pin.impulseDynamics(model, data, event.q, event.v_before, rows, 0.0, damping)

    return Skip(
        "out-of-plane rows of the cut pins (1000 impacts)",
        timed(lambda: impacts(few, 0.0), repeats).median_ms,
        timed(lambda: impacts(many, 1e-12), repeats).median_ms,
    )
