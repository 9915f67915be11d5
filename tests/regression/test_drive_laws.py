"""Where pieces of a drive's law meet, and where a follower just leaves its cam."""

from __future__ import annotations

import math

import numpy as np
import pytest
from driven_machines import GRAVITY, LAWS, MACHINES, Law, follower
from scipy.optimize import minimize_scalar
from small_machines import SLED, link, machine, slide, turn

import nipper_pin as nip
from benchmarks.stress.machines.small_machines import e62 as e62_source
from nipper_pin import Case, Mechanism, Resolution, Window, simulate
from nipper_pin.arrays import FloatArray
from nipper_pin.mechanism import from_sources

GUIDE = "oscillating guide"

PAIRS = [
    (machine, law)
    for machine in MACHINES
    for law in LAWS
    # A guide rocks a shaft.
    if law != GUIDE or machine not in ("follower", "carriage")
]


def turns_of(mechanism: nip.Mechanism, speed: float, cycles: int = 1) -> nip.Solution:
    """So many turns, each of them computed."""
    case = nip.Case(speed_rpm=speed, window=nip.Window.CYCLE, cycles=cycles, reuse_cycles=False)
    return nip.simulate(mechanism, case)


def moves_as_its_law(solution: nip.Solution) -> None:
    """What the law moves is where the law has it, at every place of the turn."""
    mechanism = solution.mechanism
    begin, end = solution.trajectory.span
    assert end == pytest.approx(solution.shaft.period, rel=1e-12)
    motion = solution.trajectory.evaluate(np.linspace(begin, end, 101))
    drive = mechanism.drives[0]
    expected = drive.law.evaluate(motion.cylinder_angle)[0] - drive.law_at_touch
    np.testing.assert_allclose(motion.q[:, drive.index], expected, atol=1e-13)


FEW_OR_MANY = [
    (79.62235533730035, 200.0, 352.0053691993546),
    pytest.param(np.geomspace(40.0, 900.0, 200), marks=pytest.mark.campaign),
]


@pytest.mark.sampled(7)
@pytest.mark.parametrize("speeds", FEW_OR_MANY, ids=["few", "many"])
@pytest.mark.parametrize(("machine", "law"), PAIRS)
def test_no_law_stops_the_machine(machine: str, law: str, speeds: FloatArray) -> None:
    """Where a piece ended in a dwell "the step falls to 2.4e-13 s", at half of all speeds."""
    mechanism = MACHINES[machine](LAWS[law])
    for speed in speeds:
        moves_as_its_law(turns_of(mechanism, float(speed)))


@pytest.mark.sampled(2)
@pytest.mark.parametrize("law", ["modified_sine, dwells", "12 rows"])
def test_no_number_of_turns_stops_the_machine(law: str) -> None:
    """Round-off of the angle grows with the turns, and moves what the law has at the nodes."""
    solution = turns_of(MACHINES["rocker"](LAWS[law]), 333.3, cycles=40)
    assert solution.outcome is nip.Outcome.COMPLETED


@pytest.mark.parametrize("beside", [0.0, 1e-15, -1e-14, 1e-12, -1e-12, -0.9e-9, 1.1e-9])
def test_a_run_may_start_beside_the_end_of_a_piece(beside: float) -> None:
    """An angle before it the first panel lies on what follows, and behind it, too."""
    mechanism = follower(LAWS["polynomial_345, dwells"])
    for knot in mechanism.drive_knots_rad:
        index = (24.0 + (knot + beside) * 40.0 / math.tau) % 40.0
        case = nip.Case(speed_rpm=127.0, window=nip.Window.CYCLE, start_index=index)
        assert nip.simulate(mechanism, case).outcome is nip.Outcome.COMPLETED


def tabulated(count: int, noise: float) -> Mechanism:
    """The E62-class model, its pendulum's motion in so many rows, each off by some noise [rad]."""
    source = e62_source()
    drive = source.description["drives"]["pendulum"]
    angle = np.linspace(0.0, 360.0, count + 1)
    crank, guide = np.array(drive["crank_axis_mm"]), np.array(drive["guide_axis_mm"])
    turn = np.radians(angle)
    along = (
        crank + drive["crank_radius_mm"] * np.stack([np.cos(turn), np.sin(turn)], axis=1) - guide
    )
    rows = np.unwrap(np.arctan2(along[:, 1], along[:, 0]))
    rows += noise * np.sin(37.0 * np.arange(count + 1.0) ** 2)
    rows[-1] = rows[0]
    kept = {
        key: drive[key]
        for key in ("joint", "reflected_inertia_kg_m2", "shaft_frequency_hz", "shaft_damping_ratio")
    }
    table = {"cylinder_angle_deg": angle.tolist(), "coordinate_rad": rows.tolist()}
    source.description["drives"]["pendulum"] = {**kept, "law": "table", **table}
    return from_sources(source.name, source.urdf, source.description, source.folder)


@pytest.fixture(scope="module")
def rough() -> Mechanism:
    """24 rows, each off by up to 1 mrad."""
    return tabulated(24, 1e-3)


def test_panels_end_at_the_knots(rough: Mechanism) -> None:
    """Every knot that the turn passes lies on a border of two panels, to round-off of an angle.

    24 knots on about as many panels: without them borders lie anywhere, and times were wrong.
    """
    solution = simulate(rough, Case(speed_rpm=492.0, window=Window.CYCLE))
    borders = [panel.t for segment in solution.segments for panel in segment.panels]
    borders += [segment.t_end for segment in solution.segments]
    angles = np.degrees(solution.shaft.angle(np.array(borders)))
    knots = np.arange(24.0) * 15.0
    away = np.abs((angles[None, :] - knots[:, None] + 180.0) % 360.0 - 180.0).min(axis=1)
    assert away.max() <= 1e-7


def test_a_finer_tolerance_costs_no_more_than_it_must(rough: Mechanism) -> None:
    """Last coefficients that are only round-off advised ever shorter panels, 400 times as many."""
    work = [
        simulate(
            rough,
            Case(speed_rpm=492.0, window=Window.CYCLE, resolution=Resolution(tolerance=tolerance)),
        ).evaluations
        for tolerance in (1e-10, 1e-13)
    ]
    assert work[1] < 3 * work[0]


def test_limits_of_bounces_do_not_reach_across_knots() -> None:
    """Knots every 7 deg: the jaw passes one while it bounces, and comes to rest 0.05 deg behind it.

    Three collisions behind the knot show the limit. With those before it the time of rest was off
    from a finer run's by 0.96 of what both state.
    """
    mechanism = tabulated(52, 1e-4)
    coarse, fine = (
        simulate(mechanism, Case(speed_rpm=680.0, resolution=Resolution(tolerance=tolerance)))
        for tolerance in (1e-12, 6e-14)
    )
    angles = np.degrees([hit.cylinder_angle for hit in coarse.collisions])
    knot = 20.0 * 360.0 / 52.0
    assert (angles > knot).sum() == 4
    assert (angles < knot).sum() >= 3
    stated = coarse.errors[-1].time + fine.errors[-1].time
    assert abs(coarse.events[-1].t - fine.events[-1].t) <= 0.1 * stated


def test_no_limit_is_taken_before_a_knot_that_it_lies_behind() -> None:
    """A ball bounces on a table that stands still, and begins to rise 5 ms before its rest.

    Without the rise that would come after t_1 (1 + e) / (1 - e); the coarse run knows it long
    before, and has to follow the bounces all the same.
    """
    still = 3.0 * math.sqrt(2.0 * 0.05 / GRAVITY)
    rise = {"law": "cam", "motion": "cycloidal", "start_deg": 360.0 * (still - 5e-3),
            "rise_deg": 60.0, "return_deg": 60.0, "lift_mm": 20.0}  # fmt: skip
    ball = machine(
        [link("table"), slide("lift", "frame", "table", (0.0, 1.0)),
         link("ball"), slide("gap", "table", "ball", (0.0, 1.0))], 2, gravity=GRAVITY,
        drives={"cam": {"joint": "lift", **rise, **SLED}}, initial={"gap": {"at_mm": 50.0}},
        stops={"table": {"joint": "gap", "restitution": 0.5}},
    )  # fmt: skip
    coarse, fine = (turn(ball, tolerance=tolerance) for tolerance in (1e-6, 1e-13))
    rests = [
        next((event.t, run.errors[event.number - 1].time) for event in run.events
             if event.kind is nip.EventKind.REST) for run in (coarse, fine)
    ]  # fmt: skip
    (t, stated), (right, rest) = rests
    assert abs(t - right) <= stated + rest < 1e-6
    assert abs(right - still) > 1e-5


MASS, STIFFNESS, PRELOAD, ECCENTRICITY = 0.8, 900.0, 0.012, 0.018

ECCENTRIC: Law = {"law": "fourier", "mean": 0.5, "cosine": [-0.5], "sine": [0.0]}

NEAR = np.geomspace(1e-12, 1e-5, 40)

FEW_OR_ALL = [NEAR[::6], pytest.param(NEAR, marks=pytest.mark.campaign)]


def _turn(mechanism: nip.Mechanism, rpm: float) -> nip.Solution:
    solution = nip.simulate(mechanism, nip.Case(speed_rpm=rpm, window=nip.Window.CYCLE))
    assert solution.outcome is nip.Outcome.COMPLETED
    return solution


def _flight(mechanism: nip.Mechanism, rpm: float) -> float:
    """Time from the first release to the landing [s]; the bounces after it end in a rest."""
    released, landed, *others = _turn(mechanism, rpm).events
    assert released.kind is nip.EventKind.RELEASE
    assert landed.kind is nip.EventKind.COLLISION
    assert others[-1].kind is nip.EventKind.REST
    return landed.t - released.t


@pytest.mark.parametrize("nears", FEW_OR_ALL, ids=["few", "all"])
@pytest.mark.parametrize("sprung", [True, False])
def test_a_follower_leaves_an_eccentric_for_as_long_as_its_force_tells(
    sprung: bool, nears: FloatArray
) -> None:
    """At w (1 + d) the force is m (c s^2 / 2 - 2 e w^2 d) about the top, c = e w^2 (w^2 - k/m).

    It is below zero up to a time T = sqrt(4 e w^2 d / c); what leaves at -T, lands at 3 T. At most
    of these speeds "the motion cannot be resolved", or the flight was left out.
    """
    k = STIFFNESS if sprung else 0.0
    weight = MASS * GRAVITY + k * (PRELOAD + 2.0 * ECCENTRICITY)
    omega = math.sqrt(weight / (MASS * ECCENTRICITY))
    mechanism = follower(ECCENTRIC, sprung=sprung)
    for near in nears:
        below = (1.0 - near) * omega * 60.0 / math.tau
        assert not _turn(mechanism, below).events
        flight = _flight(mechanism, (1.0 + near) * omega * 60.0 / math.tau)
        expected = 8.0 * math.sqrt(near / (omega**2 - k / MASS))
        # The next term is of the order of the angle turned; round-off of a force of 64 m/s2 times
        # the mass is 1e-14 of it, beside the part d that is missing.
        allowed = omega * expected + 1e-14 / near
        assert flight == pytest.approx(expected, rel=allowed), near


def _jump_rpm(mechanism: nip.Mechanism, k: float) -> float:
    """Speed at which the least force of the cam is zero [r/min]."""
    law = mechanism.drives[0].law

    def square(psi: FloatArray | float) -> FloatArray:
        lift, _, bend = law.evaluate(np.asarray(psi))
        force = GRAVITY + k / MASS * (PRELOAD + lift)
        return np.divide(-force, bend, out=np.full_like(bend, math.inf), where=bend < 0.0)

    grid = np.linspace(0.0, math.tau, 20_001)
    place = grid[int(np.argmin(square(grid)))]
    bounds = place - 4e-4, place + 4e-4
    found = minimize_scalar(square, bounds=bounds, method="bounded", options={"xatol": 1e-14})
    # The least may lie where two pieces meet.
    least = min(float(found.fun), *square(np.array(law.knots_rad)))
    return math.sqrt(least) * 60.0 / math.tau


@pytest.mark.sampled(3)
@pytest.mark.parametrize("nears", FEW_OR_ALL, ids=["few", "all"])
@pytest.mark.parametrize("sprung", [True, False])
@pytest.mark.parametrize(
    "law", ["cycloidal, dwells", "modified_sine, dwells", "polynomial_4567, late", "12 rows"]
)
def test_flights_grow_with_the_root_of_what_the_force_lacks(
    law: str, sprung: bool, nears: FloatArray
) -> None:
    """Without a spring a modified sine has its least force where two of its pieces meet."""
    mechanism = follower(LAWS[law], sprung=sprung)
    rpm = _jump_rpm(mechanism, STIFFNESS if sprung else 0.0)
    for near in nears:
        assert not _turn(mechanism, rpm * (1.0 - near)).events
    flights = np.array([_flight(mechanism, rpm * (1.0 + near)) for near in nears])
    # The speed of the jump is known to some 1e-14, of which the least distance is 1e-12.
    np.testing.assert_allclose(
        flights / np.sqrt(nears), flights[-1] / math.sqrt(nears[-1]), rtol=0.02
    )
