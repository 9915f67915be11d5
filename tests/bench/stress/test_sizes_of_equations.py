"""The judge's own equations and the round-off that it expects of them, worked out anew.

Places, masses and Jacobians come from other algorithms of Pinocchio, or from its model link by
link; all sums of sizes are written out.
"""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pinocchio as pin
import pytest
from made_up_runs import EPS

from benchmarks.stress.machines.chains import Chain
from benchmarks.stress.machines.parts import (
    SHAFT,
    frame,
    hinge,
    link,
)
from benchmarks.stress.machines.small_machines import four_bar
from benchmarks.stress.mechanics.chain_sizes import ChainSizes
from benchmarks.stress.mechanics.equations import Equations
from benchmarks.stress.mechanics.planar_tree import PlanarTree
from nipper_pin.mechanism import Mechanism, from_sources

AXES, BODY = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED, pin.FrameType.BODY
PLANE = [0, 2]


def tied(tie: str, slides: bool) -> Mechanism:
    """A chain on a driven base, with an element of every kind and a loop, or without one."""
    rng = np.random.default_rng(11)
    machine = Chain()
    machine.add_base(rng, "swing" if tie != "slot" else "yoke")
    machine.add_link(rng, True, 1.5)
    machine.add_link(rng, not slides, 0.5)
    machine.add_link(rng, True, 20.0)
    if tie == "pin":
        name, (x, z) = machine.links[-1]
        machine.parts += [frame("tip", name, (0.2, 0.1)),
                          frame("anchor", "frame", (x + 0.2, z + 0.1))]  # fmt: skip
        machine.tables["closures"]["pin"] = {"frame_a": "anchor", "frame_b": "tip"}
        machine.freedom -= 2
    else:
        machine.tie(rng, tie)
    machine.stop("j0", "lower", -0.2, 0.6)
    machine.stop("j2", "upper", 0.1, 0.4)
    machine.spring("coil", "j0", 4.0, 0.3)
    machine.spring("other", "j1", 50.0, -0.2)
    machine.table("cushion", "j2", ([-3.0, -0.1, 0.02, 3.0], [-90.0, -3.0, 1.0, 95.0]))
    machine.damper("oil", "j1", 0.8)
    machine.damper("grease", "j2", 0.1)
    machine.strut(rng, "strut", 40.0, 1.5, 0.3)
    machine.strut(rng, "spring", 7.0, None, 0.05)
    machine.tables["drives"]["shaft"] |= {
        "reflected_inertia_kg_m2": 2.5, "shaft_frequency_hz": 7.0, "shaft_damping_ratio": 0.3,
    }  # fmt: skip
    return built(machine, "tied")


def built(machine: Chain, name: str, gravity: float = 9.81) -> Mechanism:
    source = machine.source(name, gravity, [])
    return from_sources(source.name, source.urdf, source.description, source.folder)


MACHINES = {"links": ("links", True), "slot": ("slot", False), "open": ("none", True),
            "pin": ("pin", True)}  # fmt: skip


@pytest.fixture(scope="module")
def machines() -> dict[str, Mechanism]:
    return {name: tied(*what) for name, what in MACHINES.items()}


def states(nv: int) -> list[tuple[Any, Any, Any]]:
    """Of both signs; the last one stands still, and moves in one coordinate alone."""
    found = []
    for seed in range(3):
        rng = np.random.default_rng(seed)
        q, v, a = rng.normal(size=(3, nv)) * np.array([[0.2], [3.0], [40.0]])
        v[seed], a[seed + 1] = -20.0, -300.0
        found.append((q, v, a))
    return [*found, (found[0][0], np.zeros(nv), np.eye(nv)[0])]


class Ways:
    """Of a machine link by link: joints below it, and the ways from each of them."""

    def __init__(self, machine: Mechanism, q: Any) -> None:
        self.machine, self.model, self.q = machine, machine.model, q
        self.slides = {
            self.model.getJointId(joint.name): joint.kind == "prismatic" for joint in machine.joints
        }

    def of(self, link: int, beyond: float) -> dict[int, float]:
        """From each joint, by its number, to a point beyond the last one."""
        found = {}
        while link:
            if self.slides[link]:
                beyond += abs(self.q[self.model.joints[link].idx_v])
            found[link] = beyond
            beyond += float(np.linalg.norm(self.model.jointPlacements[link].translation))
            link = self.model.parents[link]
        return found

    def point(self, v: Any, a: Any, link: int, beyond: float) -> tuple[float, float]:
        """Sizes of the acceleration of a point and of the angular one."""
        ways = self.of(link, beyond)
        at = {joint: self.model.joints[joint].idx_v for joint in ways}
        turning = sum(abs(v[at[j]]) for j in ways if not self.slides[j])
        sliding = sum(abs(v[at[j]]) for j in ways if self.slides[j])
        moved = sum(abs(a[at[j]]) * (1.0 if self.slides[j] else ways[j]) for j in ways)
        moved += 2.0 * turning * sliding + turning**2 * max(ways.values(), default=0.0)
        return moved, sum(abs(a[at[j]]) for j in ways if not self.slides[j])

    def cuts(self) -> list[list[tuple[int, float]]]:
        """Links and distances of the frames of each closure."""
        pairs = [(item.frame_a, item.frame_b) for item in self.machine.closures]
        frames = [[self.model.frames[self.model.getFrameId(n, BODY)] for n in p] for p in pairs]
        return [
            [(f.parentJoint, float(np.linalg.norm(f.placement.translation))) for f in pair]
            for pair in frames
        ]

    def lever(self, link: int) -> float:
        return float(np.linalg.norm(self.model.inertias[link].lever))

    def reach(self) -> float:
        links = range(1, self.model.njoints)
        ends = [(k, self.lever(k)) for k in links]
        ends += [end for pair in self.cuts() for end in pair]
        return max(max(self.of(*end).values(), default=0.0) for end in ends)

    def forces(self, v: Any, a: Any) -> Any:
        found, gravity = np.zeros(len(v)), float(np.linalg.norm(self.model.gravity.linear))
        for body in range(1, self.model.njoints):
            inertia = self.model.inertias[body]
            moved, turned = self.point(v, a, body, self.lever(body))
            for joint, way in self.of(body, self.lever(body)).items():
                lever = 1.0 if self.slides[joint] else way
                of_turn = 0.0 if self.slides[joint] else inertia.inertia[1, 1] * turned
                force = inertia.mass * lever * (gravity + moved) + of_turn
                found[self.model.joints[joint].idx_v] += force
        return found

    def opened(self, v: Any, a: Any) -> list[float]:
        sums = [sum(self.point(v, a, *end)[0] for end in pair) for pair in self.cuts()]
        return [number for number in sums for _ in range(2)]


@pytest.mark.parametrize("name", MACHINES)
def test_sizes_of_chains(machines: dict[str, Mechanism], name: str) -> None:
    machine = machines[name]
    sizes = ChainSizes(PlanarTree.of(machine))
    parents = machine.model.parents
    longest = 0
    for body in range(machine.model.njoints):
        joint, count = body, 0
        while joint:
            joint, count = parents[joint], count + 1
        longest = max(longest, count)
    assert sizes.longest == longest
    for q, v, a in states(machine.model.nv):
        ways = Ways(machine, q)
        assert sizes.reach(q) == pytest.approx(ways.reach(), rel=1e-13, abs=0.0)
        forces, opened = sizes.of(q, v, a)
        assert forces == pytest.approx(ways.forces(v, a), rel=1e-12, abs=0.0)
        assert opened.tolist() == pytest.approx(ways.opened(v, a), rel=1e-12, abs=0.0)
        levers = np.ones(len(q))
        for joint, slides in ways.slides.items():
            levers[machine.model.joints[joint].idx_v] = ways.reach() if slides else 1.0
        largest = max(abs(a) / levers)
        assert sizes.still(q, a) == pytest.approx(largest * levers, rel=1e-13, abs=0.0)


class Plain:
    """The equations of a machine, from other algorithms of Pinocchio, with round-off by hand."""

    def __init__(self, machine: Mechanism, held: bool) -> None:
        self.machine, self.held, self.model = machine, held, machine.model
        self.data = self.model.createData()
        self.driven = [drive.index for drive in machine.drives]
        shares = np.array([1.0, -0.25][: len(self.driven)])
        self.law = np.multiply.outer([[0.3], [-2.0], [15.0]], shares)
        shaft = SimpleNamespace(driven=lambda t: tuple(self.law * (1.0 + t[0])))
        self.solution: Any = SimpleNamespace(
            mechanism=machine, system=SimpleNamespace(held=held), shaft=shaft
        )

    def look(self, q: Any, v: Any) -> None:
        """Mass matrix, forces that are held back, Jacobians and how they change."""
        pin.computeAllTerms(self.model, self.data, q, v)
        pin.computeJointJacobiansTimeVariation(self.model, self.data, q, v)
        pin.updateFramePlacements(self.model, self.data)
        upper = np.triu(self.data.M)
        self.M = upper + np.triu(upper, 1).T
        self.h, self.v = self.data.nle.copy(), v
        self.ways = Ways(self.machine, q)

    def at(self, name: str) -> tuple[Any, Any, Any]:
        """Place, Jacobian and its change times v of a frame."""
        frame = self.model.getFrameId(name, BODY)
        place = self.data.oMf[frame].translation[PLANE].copy()
        rows = pin.getFrameJacobian(self.model, self.data, frame, AXES)[PLANE]
        other = pin.getFrameJacobianTimeVariation(self.model, self.data, frame, AXES)[PLANE]
        return place, rows, other @ self.v

    def closures(self) -> tuple[Any, Any, Any]:
        ends = [(self.at(item.frame_a), self.at(item.frame_b)) for item in self.machine.closures]
        gaps = [a[0] - b[0] for a, b in ends]
        nv = self.model.nv
        return (np.concatenate([np.zeros(0), *gaps]),
                np.concatenate([np.zeros((0, nv)), *(a[1] - b[1] for a, b in ends)]),
                np.concatenate([np.zeros(0), *(a[2] - b[2] for a, b in ends)]))  # fmt: skip

    def elements(self, q: Any, v: Any) -> tuple[Any, Any]:
        tau, size = np.zeros(len(q)), np.zeros(len(q))
        for spring in self.machine.springs:
            x, at, k = q[spring.index], spring.index, spring.stiffness
            tau[at] += -k * spring.preload - k * x
            size[at] += k * abs(spring.preload) + k * abs(x)
        for damper in self.machine.dampers:
            tau[damper.index] -= damper.damping * v[damper.index]
            size[damper.index] += damper.damping * abs(v[damper.index])
        for table in self.machine.tabulated_springs:
            x = q[table.index]
            pull, beside = table.characteristic.forces(np.array([x, x * (1.0 + EPS)]))
            tau[table.index] -= pull
            size[table.index] += abs(pull) + abs(beside - pull) / EPS
        for strut in self.machine.struts:
            first, second = self.at(strut.frame_a), self.at(strut.frame_b)
            line, rows = second[0] - first[0], second[1] - first[1]
            length, reach = float(np.hypot(*line)), self.ways.reach()
            along = line / length
            tension = strut.stiffness * (length - strut.free_length)
            tension += strut.damping * float(along @ rows @ v)
            tau -= tension * (along @ rows)
            levers = np.maximum(abs(rows[0]), abs(rows[1]))
            rate = strut.damping * sum(levers * abs(v))
            pulled = strut.stiffness * reach + strut.stiffness * strut.free_length + rate
            size += (pulled + (abs(tension) + rate) * reach / length) * levers
        return tau, size

    def trains(self, t: float, q: Any, v: Any) -> tuple[Any, Any]:
        tau, size = np.zeros(len(q)), np.zeros(len(q))
        place, rate, rise = (self.law * (1.0 + t))[:, 0]
        for k, drive in enumerate(self.machine.drives):
            inertia, turning = drive.reflected_inertia, 2.0 * np.pi * drive.shaft_frequency_hz
            stiffness = inertia * turning**2
            damping = 2.0 * drive.shaft_damping_ratio * turning * inertia
            at = drive.index
            terms = (inertia * rise[k], stiffness * place[k], -stiffness * q[at],
                     damping * rate[k], -damping * v[at])  # fmt: skip
            tau[at] += sum(terms)
            size[at] += sum(map(abs, terms))
        return tau, size

    def loose(self, closed: frozenset[str]) -> list[int]:
        given = [stop.index for stop in self.machine.stops if stop.name in closed]
        return [k for k in range(self.model.nv)
                if k not in given and not (self.held and k in self.driven)]  # fmt: skip

    def mass(self) -> Any:
        M = self.M.copy()
        for drive in () if self.held else self.machine.drives:
            M[drive.index, drive.index] += drive.reflected_inertia
        return M

    def solved(self, t: float, q: Any, v: Any, closed: frozenset[str]) -> tuple[Any, ...]:
        """Accelerations and closure forces, the matrix, and sizes of applied forces."""
        self.look(q, v)
        loose, (_, G, opening), M = self.loose(closed), self.closures(), self.mass()
        tau, size = self.elements(q, v)
        given = np.zeros(len(q))
        if self.held:
            given[self.driven] = (self.law * (1.0 + t))[2, 0]
        else:
            more, sizes = self.trains(t, q, v)
            tau, size = tau + more, size + sizes
        n, m = len(loose), len(G)
        matrix = np.zeros((n + m, n + m))
        matrix[:n, :n], matrix[n:, :n] = M[np.ix_(loose, loose)], G[:, loose]
        matrix[:n, n:] = G[:, loose].T
        right = np.concatenate([(tau - self.h - M @ given)[loose], -opening - G @ given])
        unknowns = np.linalg.solve(matrix, right)
        a = given.copy()
        a[loose] = unknowns[:n]
        return a, unknowns, matrix, G, size

    def roundings(self) -> float:
        return 2.0 * EPS * (ChainSizes(PlanarTree.of(self.machine)).longest + 2.0)

    def round_off(self, t: float, q: Any, v: Any, closed: frozenset[str]) -> Any:
        a, unknowns, matrix, G, size = self.solved(t, q, v, closed)
        loose = self.loose(closed)
        n = len(loose)
        pulled = [sum(abs(row[k] * x) for row, x in zip(G, unknowns[n:], strict=True))
                  for k in range(len(q))]  # fmt: skip
        pushed = (self.ways.forces(v, a) + size + pulled)[loose]
        opened = np.full(len(G), max(self.ways.opened(v, a), default=0.0))
        opened += abs(G[:, loose]) @ (abs(np.linalg.pinv(matrix[:n, :n])) @ pushed)
        wrong, eliminated = np.concatenate([pushed, opened]), 1.5 * EPS * (n + len(G))
        wrong = self.roundings() * wrong + eliminated * (abs(matrix) @ abs(unknowns))
        unsure = eliminated * ChainSizes(PlanarTree.of(self.machine)).still(q, a)
        unsure[[k for k in range(len(q)) if k not in loose]] = 0.0
        unsure[loose] += (abs(np.linalg.inv(matrix)) @ wrong)[:n]
        return unsure

    def condition(self, q: Any, closed: frozenset[str]) -> float:
        """Of G M^-1 G', each pin scaled by its mean, each stop by itself."""
        self.look(q, np.zeros(len(q)))
        moving = [k for k in range(len(q)) if not (self.held and k in self.driven)]
        stops = [np.eye(len(q))[s.index] for s in self.machine.stops if s.name in closed]
        rows = np.array([*self.closures()[1], *stops]).reshape(-1, len(q))[:, moving]
        if not len(rows):
            return 1.0
        matrix = rows @ np.linalg.inv(self.mass()[np.ix_(moving, moving)]) @ rows.T
        scale, pins = [], 2 * len(self.machine.closures)
        for k in range(len(rows)):
            pair = [k, k ^ 1] if k < pins else [k]
            scale.append(1.0 / np.sqrt(np.mean([matrix[i, i] for i in pair])))
        values = np.linalg.svd(np.diag(scale) @ matrix @ np.diag(scale), compute_uv=False)
        return float(values[0] / values[-1])


CLOSED = [frozenset(), frozenset({"j0 lower"}), frozenset({"j2 upper", "j0 lower"})]


@pytest.mark.parametrize("held", [True, False], ids=["held", "inertial"])
@pytest.mark.parametrize("name", MACHINES)
def test_equations_and_their_round_off(
    machines: dict[str, Mechanism], name: str, held: bool
) -> None:
    plain = Plain(machines[name], held)
    equations = Equations(plain.solution)
    nv = plain.model.nv
    for closed in CLOSED:
        loose = plain.loose(closed)
        rows = 2 * len(machines[name].closures)
        assert equations.loose(closed) == loose
        assert sorted(equations.prescribed(closed)) == [k for k in range(nv) if k not in loose]
        assert equations.freedom(closed) == len(loose) - rows
        if equations.freedom(closed) < 0:
            continue
        for t, (q, v, _) in enumerate(states(nv)):
            a, *_ = plain.solved(t, q, v, closed)
            told = equations.accelerations(t, q, v, closed)
            assert told == pytest.approx(a, rel=1e-8, abs=1e-8 * max(abs(a)) + 1e-11)
            unsure = plain.round_off(t, q, v, closed)
            assert equations.round_off(t, q, v, closed) == pytest.approx(unsure, rel=1e-6, abs=0.0)
            assert equations.condition(q, closed) == pytest.approx(
                plain.condition(q, closed), rel=1e-6, abs=0.0
            )


@pytest.mark.parametrize("name", MACHINES)
def test_places_of_cuts_and_struts(machines: dict[str, Mechanism], name: str) -> None:
    """Gaps go from frame b to frame a, lines of struts from their first point to the second."""
    plain = Plain(machines[name], True)
    asked = Equations(plain.solution)
    for q, v, _ in states(plain.model.nv):
        plain.look(q, v)
        gaps, G, opening = plain.closures()
        told = *asked.closures(q), asked.tree.closure(q, v, np.zeros(len(q)), world=True)[2]
        for one, other in zip(told, (gaps, G, opening), strict=True):
            assert one.shape == other.shape
            assert one == pytest.approx(other, rel=1e-9, abs=1e-9)
        pulls = asked.forces.pulls(q, v)
        for strut, pull in zip(plain.machine.struts, pulls, strict=True):
            first, second = plain.at(strut.frame_a), plain.at(strut.frame_b)
            assert pull.strut is strut
            assert pull.line == pytest.approx((second[0] - first[0]) @ [1.0, 1.0j], abs=1e-12)
            assert pull.jacobian == pytest.approx([1.0, 1.0j] @ (second[1] - first[1]), abs=1e-12)
            assert pull.length == pytest.approx(abs(pull.line), rel=1e-14, abs=0.0)


@pytest.mark.parametrize("name", MACHINES)
def test_sizes_of_places_and_of_what_is_open(machines: dict[str, Mechanism], name: str) -> None:
    plain = Plain(machines[name], True)
    equations = Equations(plain.solution)
    for q, v, _ in states(plain.model.nv):
        plain.look(q, v)
        reach = plain.ways.reach()
        signs = [(-1.0) ** k for k in range(len(q))]
        assert equations.sizes(q) == pytest.approx(signs * (abs(q) + reach), rel=1e-13, abs=0.0)
        gaps, G, _ = plain.closures()
        for closed in CLOSED[:2]:
            loose, wanted = plain.loose(closed), np.zeros(len(q))
            wanted[loose] = abs(np.linalg.pinv(G[:, loose])) @ (
                abs(gaps) + plain.roundings() * reach
            )
            assert equations.opened(q, closed) == pytest.approx(wanted, rel=1e-9, abs=0.0)


def test_largest_pull_of_struts(machines: dict[str, Mechanism]) -> None:
    """The largest one of all states."""
    plain = Plain(machines["open"], True)
    forces = Equations(plain.solution).forces
    q, v, _ = np.array(states(plain.model.nv)[:3]).swapaxes(0, 1)
    pulls = []
    for place, rate in zip(q, v, strict=True):
        plain.look(place, rate)
        for strut in plain.machine.struts:
            first, second = plain.at(strut.frame_a), plain.at(strut.frame_b)
            line = second[0] - first[0]
            length = float(np.hypot(*line))
            opening = float(line @ (second[1] - first[1]) @ rate) / length
            pull = strut.stiffness * (length - strut.free_length) + strut.damping * opening
            pulls.append(abs(pull))
    assert forces.tension(q, v) == pytest.approx(max(pulls), rel=1e-12, abs=0.0)


def small(rng: np.random.Generator, links: int) -> Mechanism:
    """Links without weight and elements, a few centimetres long."""
    machine = Chain()
    name, place = "frame", (0.0, 0.0)
    for number in range(links):
        body = f"b{number}"
        centre = tuple(rng.uniform(-0.02, 0.02, 2).tolist())
        machine.parts += [link(body, 1.0 + number, 1e-3, centre),
                          hinge(f"j{number}", name, body, place)]  # fmt: skip
        machine.joints[f"j{number}"] = True
        name, place, machine.freedom = body, (0.03, 0.01), links
    drive = {"joint": "j0", "law": "constant_speed", "ratio": 1.0, **SHAFT}
    if links > 1:
        machine.tables["drives"]["shaft"] = drive
    machine.stop(f"j{links - 1}", "lower", -0.2, 0.6)
    return built(machine, "small", 0.0)


@pytest.mark.parametrize("links", [1, 2, 3])
def test_small_machines(links: int) -> None:
    """Lengths, forces and accelerations below one: no size has a least one."""
    plain = Plain(small(np.random.default_rng(links), links), True)
    plain.law = plain.law * 1e-3
    sizes, equations = ChainSizes(PlanarTree.of(plain.machine)), Equations(plain.solution)
    rng = np.random.default_rng(4)
    q, v, a = 1e-2 * rng.normal(size=(3, links))
    ways = Ways(plain.machine, q)
    assert sizes.reach(q) == pytest.approx(ways.reach(), rel=1e-13, abs=0.0)
    assert ways.reach() < 0.2
    forces, opened = sizes.of(q, v, a)
    assert forces == pytest.approx(ways.forces(v, a), rel=1e-12, abs=0.0)
    assert opened.shape == (0,)
    assert sizes.still(q, a) == pytest.approx(np.full(links, max(abs(a))), rel=1e-13, abs=0.0)
    assert equations.sizes(q).tolist() == [x * (-1.0) ** k for k, x in enumerate(abs(q))]
    assert equations.forces.tension(q[None], v[None]) == 0.0
    unsure = plain.round_off(0.5, q, v, frozenset())
    told = equations.round_off(0.5, q, v, frozenset())
    assert told == pytest.approx(unsure, rel=1e-6, abs=1e-300)
    assert equations.condition(q, frozenset()) == 1.0


def test_trains_of_two_drives(e62: Mechanism) -> None:
    """Each has its own terms."""
    plain = Plain(e62, False)
    rng = np.random.default_rng(2)
    q, v = rng.normal(size=(2, plain.model.nv))
    torques, sizes = Equations(plain.solution).forces.of_trains(0.5, q, v)
    wanted, size = plain.trains(0.5, q, v)
    assert len(plain.driven) == len(torques) == len(sizes) == 2
    assert torques == pytest.approx(wanted[plain.driven], rel=1e-12)
    assert sizes == pytest.approx(size[plain.driven], rel=1e-12)


def test_a_small_loop() -> None:
    """A slow four-bar of ten centimetres: its closures open by less than one of any unit."""
    source = four_bar(0.1, 0.03, 0.09, 0.07, (1.0, 2.0, 3.0))
    source.description["gravity_m_s2"] = 0.0
    machine = from_sources(source.name, source.urdf, source.description, source.folder)
    plain = Plain(machine, True)
    plain.law = plain.law * 1e-3
    equations = Equations(plain.solution)
    q, v = np.array([0.1, -0.2, 0.3]), np.array([1e-3, -2e-2, 1e-2])
    a, *_ = plain.solved(0.0, q, v, frozenset())
    opened = plain.ways.opened(v, a)
    assert 0.0 < max(opened) < 0.1
    told = ChainSizes(PlanarTree.of(machine)).of(q, v, a)[1]
    assert told.tolist() == pytest.approx(opened, rel=1e-12, abs=0.0)
    unsure = plain.round_off(0.0, q, v, frozenset())
    assert equations.round_off(0.0, q, v, frozenset()) == pytest.approx(unsure, rel=1e-6, abs=0.0)
    condition = plain.condition(q, frozenset())
    assert equations.condition(q, frozenset()) == pytest.approx(condition, rel=1e-6, abs=0.0)


@pytest.mark.parametrize("name", MACHINES)
def test_forces_of_elements_and_trains(machines: dict[str, Mechanism], name: str) -> None:
    """Their sums, and the sizes of all terms."""
    plain = Plain(machines[name], False)
    forces = Equations(plain.solution).forces
    for t, (q, v, _) in enumerate(states(plain.model.nv)):
        plain.look(q, v)
        for one, other in zip(forces.of_elements(q, v), plain.elements(q, v), strict=True):
            assert one == pytest.approx(other, rel=1e-9, abs=1e-9 * max(abs(other)))
        for one, other in zip(forces.of_trains(t, q, v), plain.trains(t, q, v), strict=True):
            assert one == pytest.approx(other[plain.driven], rel=1e-12, abs=0.0)
            assert np.count_nonzero(other) == len(plain.driven)


def test_conditions_that_are_none(machines: dict[str, Mechanism]) -> None:
    """A pin that nothing can move, in one direction or both, has a condition without bounds."""
    plain = Plain(machines["links"], True)
    equations: Any = Equations(plain.solution)
    q, mass = np.zeros(plain.model.nv), equations.tree.mass_matrix
    for moved in (0.0, 1.0):
        rows = np.zeros((2, len(q)))
        rows[1, 2] = moved
        equations.tree = SimpleNamespace(
            closure_jacobian=lambda *_, G=rows, **__: G, mass_matrix=mass
        )
        assert equations.condition(q, frozenset()) == np.inf
