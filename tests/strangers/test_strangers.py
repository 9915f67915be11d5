"""Small machines as other people write them: each does what it has to, or says what is wrong."""

from __future__ import annotations

import math
import re
import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import brentq

import nipper_pin as nip
from nipper_pin.cli import main

HERE = Path(__file__).parent
GRAVITY = 9.81
# Every mistake of these files, and the words that have to name it.
REFUSED = {
    "fb_noaxis": r"fb_noaxis\.urdf: joint O axis = .*1 0 0.* A, C ",
    "fb_zaxis": r"fb_zaxis\.toml: closures .* dead centre.*plane of x and y of the URDF",
    "limit_not_a_number": r"limit_not_a_number\.urdf: joint trolley limit upper = '0\.2m'.* in m",
    "lip_on_third_body": r"stops\.s\.contact\.lower = .*peg of link frame.* arm and flap,",
    "mesh_scale1": r"mesh_scale1\.urdf: link crank visual crank_0 mesh scale = '0\.001'",
    "mimic_passive": r"mimic_passive\.toml: drives\.pair\.of .*<mimic> in the URDF.*'finger'",
    "print_hammer_linear": r"springs\.magnet\.stiffness_N_per_m = -600.* by the rows of a table",
    "no_ts": r"no_ts\.toml: transition_stop is missing: .*floor",
    "u12_single_link": r"u12_single_link\.urdf: joints that move",
    "u14_2f_macro": r"u14_2f_macro\.urdf: xacro = '<xacro:include>'",
    "xacro_arg": r"xacro_arg\.urdf: xacro = '<xacro:finger>'",
}


def run(name: str) -> nip.Solution:
    """One turn of a machine at its rated speed."""
    solution = nip.simulate(nip.load(HERE / name), window="cycle")
    assert solution.checks.closure_m < 1e-12 * solution.mechanism.reach_m
    assert abs(solution.checks.energy_balance) < 1e-9
    return solution


def bounces_of_a_ball(name: str, height_m: float, restitution: float, *stops: str) -> None:
    """It rests at t1 (1 + e) / (1 - e), each of several balls at its own time."""
    solution = run(name)
    fall = math.sqrt(2.0 * height_m / GRAVITY)
    rest = fall * (1.0 + restitution) / (1.0 - restitution)
    ends = {
        stop: event.t
        for event in solution.events
        if event.kind is nip.EventKind.REST
        for stop in event.stops
    }
    assert ends == {stop: pytest.approx(rest, rel=1e-12) for stop in stops}
    for hit in solution.collisions:
        assert hit.approach_rate < 0.0 < hit.impulse
    # Of a ball that loses next to nothing not all bounces are computed, and the run says so.
    assert ["summed up" in text for text in solution.warnings] == [True] * (restitution > 0.99)


def each_ball_as_alone(name: str) -> None:
    """Ball i falls from 100 + i mm, strikes 13 times and rests at three times its first strike."""
    solution = run(name)
    places = {stop.name: i for i, stop in enumerate(solution.mechanism.stops)}
    falls = [math.sqrt(2.0 * (0.1 + 0.001 * i) / GRAVITY) for i in range(40)]
    strikes: list[list[float]] = [[] for _ in falls]
    for hit in solution.collisions:
        strikes[places[hit.stop]].append(hit.t)
    np.testing.assert_allclose([times[0] for times in strikes], falls, rtol=1e-12)
    assert [len(times) for times in strikes] == [13] * 40
    rests = [event for event in solution.events if event.kind is nip.EventKind.REST]
    for event in rests:
        for stop in event.stops:
            assert event.t == pytest.approx(3.0 * falls[places[stop]], rel=1e-12)
    assert sorted(stop for event in rests for stop in event.stops) == sorted(places)


def losses(name: str) -> None:
    """Each of three balls loses m g h (1 - e^2) at its first strike."""
    first = {}
    for hit in run(name).collisions:
        first.setdefault(hit.stop, hit.energy_lost)
    mass, restitution = np.array([1.0, 2.0, 3.0]), np.array([0.3, 0.6, 0.9])
    expected = mass * GRAVITY * 0.2 * (1.0 - restitution**2)
    assert list(first) == ["s1", "s2", "s3"]
    np.testing.assert_allclose(list(first.values()), expected, rtol=1e-13)


def mirrored_jaws(name: str) -> None:
    """Both jaws do the same, each struck in the other's instants, and rest within the turn."""
    strikes: dict[str, list[tuple[float, ...]]] = {"left": [], "right": []}
    solution = run(name)
    for hit in solution.collisions:
        strikes[hit.stop].append((hit.t, hit.approach_rate, hit.impulse, hit.energy_lost))
    assert len(strikes["left"]) > 10
    np.testing.assert_allclose(strikes["left"], strikes["right"], rtol=1e-11)
    assert solution.outcome is nip.Outcome.COMPLETED


def grips(name: str, place_m: float, *stops: str) -> None:
    """Jaws of 0.2 and 0.3 kg on one rack, drawn by 300 N/m with 30 mm of preload to a stop, or two.

    x = l (cos(w t) - 1), w^2 = k / m, after a rebound x = -l + A cos(w t - phase): so are all
    flights, whose times add up.
    """
    preload, omega, restitution = 0.03, math.sqrt(300.0 / 0.5), 0.3
    above = preload - place_m
    t = math.acos(above / preload) / omega
    rate = omega * math.sqrt(preload**2 - above**2)
    solution = run(name)
    first = solution.collisions[0]
    assert first.t == pytest.approx(t, rel=1e-12)
    assert sum(first.event.P_N.values()) == pytest.approx(1.3 * 0.5 * rate, rel=1e-12)
    while rate > 1e-12:
        rate *= restitution
        t += 2.0 * math.atan2(rate, omega * above) / omega
    (rest,) = (event for event in solution.events if event.kind is nip.EventKind.REST)
    assert sorted(rest.stops) == sorted(stops)
    assert rest.t == pytest.approx(t, rel=1e-11)
    forces = solution.trajectory.reactions(0.5).contacts
    whole = 300.0 * above / len(stops)
    assert [forces[stop][0] for stop in stops] == pytest.approx([whole] * len(stops), rel=1e-12)
    share = nip.turn_table(solution.mechanism, speed_rpm=60.0, turns=1).clamped_share[0]
    assert share == pytest.approx((1.0 - t) * ("s1" in stops), rel=1e-9)


def lies_down(name: str) -> None:
    """A parallelogram strikes at 145.768 ms and rests at 284.838 ms, with one stop or with two."""
    solution = run(name)
    assert solution.collisions[0].t == pytest.approx(0.145768, abs=5e-7)
    (rest,) = (event for event in solution.events if event.kind is nip.EventKind.REST)
    assert rest.stops == tuple(stop.name for stop in solution.mechanism.stops)
    assert rest.t == pytest.approx(0.284838, abs=5e-7)
    (transition,) = solution.transitions
    assert transition.duration == pytest.approx(0.139070, abs=5e-7)
    share = nip.turn_table(solution.mechanism, speed_rpm=60.0, turns=1).clamped_share[0]
    assert share == pytest.approx(0.71516, abs=5e-6)


def falls(name: str) -> None:
    """What nothing stops falls by g t^2 / 2."""
    solution = run(name)
    times = np.linspace(0.0, solution.shaft.period, 7)
    fallen = solution.trajectory.evaluate(times).q[:, 0]
    np.testing.assert_allclose(fallen, -0.5 * GRAVITY * times**2, rtol=0.0, atol=1e-12)


def stays(name: str) -> None:
    """In an equilibrium nothing moves."""
    solution = run(name)
    assert np.abs(solution.trajectory.evaluate(np.array([0.7])).q).max() < 1e-12


def coordinates(solution: nip.Solution, turns: float = 1.0) -> dict[str, np.ndarray]:
    """Fifty values of every coordinate from the start on, by joint."""
    times = np.linspace(0.0, turns * solution.shaft.period, 50)
    return solution.trajectory.evaluate(times).joints


def meeting(pin: np.ndarray, base: complex, coupler: float, bar: float) -> np.ndarray:
    """From the rocker's pin to where circles about it and about the crank's pin meet, x + i z."""
    side = base - pin
    along = (coupler**2 - bar**2 + np.abs(side) ** 2) / (2.0 * np.abs(side))
    return side / np.abs(side) * (along + 1j * np.sqrt(coupler**2 - along**2)) - side


def four_bar(name: str, sense: float = 1.0) -> None:
    """The rocker is where the points of the file have it."""
    q = coordinates(run(name))
    crank, arm = sense * q["O"], 0.01 + 0.09j
    end = meeting((0.03 + 0.04j) * np.exp(1j * crank), 0.12, abs(0.1 + 0.05j), abs(arm))
    turned = np.exp(1j * sense * q["C"])
    np.testing.assert_allclose(turned, end / arm, rtol=0.0, atol=1e-12)
    assert crank[-1] - crank[0] == pytest.approx(sense * 2.0 * math.pi, rel=1e-12)


def clamps(name: str) -> None:
    """The lip bounces and rests once a turn, at every speed."""
    run(name)
    mechanism = nip.load(HERE / name)
    for speed in np.linspace(60.0, 600.0, 28):
        solution = nip.simulate(mechanism, speed_rpm=float(speed), window="cycle")
        assert {hit.stop for hit in solution.collisions} >= {"lip"}
        assert solution.outcome is nip.Outcome.COMPLETED


def rounded_four_bar(name: str) -> None:
    """Five digits: the motion of the same machine with all of them, to 1e-3 rad."""
    found, whole = run(name), run("sw_fourbar_16")
    right = coordinates(whole)
    for joint, values in coordinates(found).items():
        np.testing.assert_allclose(values, right[joint], rtol=0.0, atol=1e-3)
    assert "0.00421 mm" in found.warnings[0]
    assert whole.warnings == ()


def whole_four_bar(name: str) -> None:
    """The coupler's end stays where crank and rocker have it: lengths of the drawing, in m."""
    q = coordinates(run(name))
    crank = math.radians(62.0) + q["crank_joint"]
    end = meeting(0.06 * np.exp(1j * crank), 0.21 + 0.03j, 0.17, 0.13)
    turned = np.exp(1j * q["rocker_joint"])
    np.testing.assert_allclose(turned, end / end[0], rtol=0.0, atol=1e-12)


def five_bar(name: str) -> None:
    """Six digits: an independent integration of the whole file in maximal coordinates."""
    solution = run(name)
    q = solution.trajectory.evaluate(1.0).joints
    assert q["motor1"] == pytest.approx(0.16869084, abs=1e-5)
    assert q["motor2"] == pytest.approx(-0.08508413, abs=1e-5)
    assert "0.00179 mm" in solution.warnings[0]


def turned_yoke(name: str) -> None:
    """The slot's line, 12 degrees off the upright, goes through the pin of the crank."""
    solution = run(name)
    q = coordinates(solution, 0.5)
    pin = (0.026188 + 0.022765j) * np.exp(1j * q["Rev1"])
    slope = math.tan(math.radians(12.0))
    expected = pin.real - slope * (pin.imag - 0.003202) - 0.02203
    # Six decimals: half a micrometre of each length, and of the angle by the length of the slot.
    np.testing.assert_allclose(q["Slide"], expected, rtol=0.0, atol=3e-6)
    assert "0.000248 mm" in solution.warnings[0]


def carried(name: str, force_N: float, lever: float) -> None:
    """The lip carries what the moments of the weight ask, and opens with that lever."""
    solution = run(name)
    (stop,) = solution.mechanism.stops
    assert stop.contact is not None
    assert stop.contact.normal == pytest.approx([0.0, 0.0, 1.0], abs=1e-9)
    # Files in single precision hold meshes to 6e-8, and the search finds lips to 1e-12 m.
    assert stop.contact.lever_m == pytest.approx(lever, rel=1e-9)
    reactions = solution.trajectory.reactions(0.5 * solution.shaft.period)
    assert reactions.contacts[stop.name] == pytest.approx(force_N, rel=1e-9)
    # The joint carries what the lip leaves of the weight; a slide keeps the rod from turning.
    (joint,) = reactions.joints.values()
    assert joint[0, :2] == pytest.approx([0.0, 2.0 * GRAVITY - force_N], abs=1e-8)
    if solution.mechanism.joints[0].kind == "revolute":
        assert joint[0, 2] == pytest.approx(0.0, abs=1e-8)


def falls_on_a_peg(name: str) -> None:
    """The rod strikes with the rate of its fall, and the peg takes (1 + e) I w / d."""
    solution = run(name)
    inertia, distance, restitution = 2.0 * 0.9**2 / 3.0, 0.6, 0.4
    rate = math.sqrt(3.0 * GRAVITY / 0.9 * math.sin(math.radians(30.0)))
    first = solution.collisions[0]
    assert first.approach_rate == pytest.approx(-rate, rel=1e-12)
    impulse = (1.0 + restitution) * inertia * rate / distance
    assert first.impulse == pytest.approx(impulse, rel=1e-9)
    # The peg is at the centre of percussion.
    impulses = solution.trajectory.impulses(solution.events[0])
    assert impulses.contacts == {"peg": pytest.approx(impulse, rel=1e-9)}
    assert impulses.joints["hinge"] == pytest.approx(np.zeros(3), abs=1e-7)
    rest = next(event.t for event in solution.events if event.kind is nip.EventKind.REST)
    assert (first.t, rest) == (pytest.approx(0.266664, abs=1e-6), pytest.approx(0.596752, abs=1e-6))


def stays_shut(name: str) -> None:
    """A flap lies on a lip of the arm that swings below it."""
    solution = run(name)
    assert [segment.closed for segment in solution.segments] == [frozenset({"s"})]


def barely_jumps(name: str) -> None:
    """1e-8 above the speed of its jump a follower leaves for 8 sqrt(1e-8 / (w^2 - k/m))."""
    solution = run(name)
    released, landed, *others = solution.events
    assert released.kind is nip.EventKind.RELEASE
    omega = solution.shaft.speed_rad_s
    flight = 8.0 * math.sqrt(1e-8 / (omega**2 - 900.0 / 0.8))
    assert landed.t - released.t == pytest.approx(flight, rel=1e-3)
    assert -1e-10 < landed.v_before[1] < 0.0
    assert others[-1].kind is nip.EventKind.REST
    motion = solution.trajectory.evaluate(np.linspace(released.t, others[-1].t, 100))
    assert np.abs(motion.q[:, 1]).max() < 1e-16
    assert solution.outcome is nip.Outcome.COMPLETED


def jumps(name: str) -> None:
    """The eccentric's force is zero at 133.6 deg; the flight from there lands 47.6 ms later."""
    released, landed = run(name).events[:2]
    assert released.kind is nip.EventKind.RELEASE
    assert released.t == pytest.approx(34.260200506e-3, abs=1e-12)
    assert landed.t == pytest.approx(81.900900221e-3, abs=1e-12)
    assert landed.v_before[1] == pytest.approx(-0.941472214542, abs=1e-11)


def outlasts_the_window(name: str) -> None:
    """All bounces before the end of the window are there, and no rest that comes after it."""
    solution = run(name)
    restitution, fall, number = 0.995, math.sqrt(2.0 / GRAVITY), np.arange(219)
    bounced = restitution * (1.0 - restitution**number) / (1.0 - restitution)
    times = fall * (1.0 + 2.0 * bounced)
    # Each flight depends on the one before: its relative errors add up.
    np.testing.assert_allclose([hit.t for hit in solution.collisions], times, rtol=1e-10)
    assert [event.kind for event in solution.events] == [nip.EventKind.COLLISION] * 219
    assert solution.outcome is nip.Outcome.STILL_BOUNCING
    assert not solution.warnings
    left = 120.0 - times[-1]
    rate = GRAVITY * fall * restitution**219
    height = rate * left - 0.5 * GRAVITY * left**2
    assert solution.trajectory.evaluate(120.0).q[0, 0] == pytest.approx(height, rel=1e-8)


def bends(name: str) -> None:
    """Three rows with a kink: the smooth curve through them is told of."""
    assert "interpolation" in run(name).warnings[0]


def lowest_m(solution: nip.Solution) -> float:
    """Coordinate at which the motion turns back [m]."""
    motion = solution.trajectory.evaluate
    times = np.linspace(0.0, solution.shaft.period, 4001)
    lowest = int(motion(times).q[:, 0].argmin())
    turns = brentq(lambda t: motion(np.array([t])).v[0, 0], *times[[lowest - 1, lowest + 1]])
    return float(motion(np.array([turns])).q[0, 0])


def depth_m(mass: float, stiffness: float, fall: float) -> float:
    """Energy at the lowest point: m g (fall + d) = k d^2 / 2."""
    static = mass * GRAVITY / stiffness
    return static + math.sqrt(static * static + 2.0 * static * fall)


def sinks_in(name: str) -> None:
    """A fourth row next to the kink leaves nothing of it but a micrometre."""
    solution = run(name)
    assert solution.warnings == ()
    assert lowest_m(solution) == pytest.approx(-depth_m(1.3, 1600.0, 0.45), abs=1e-6)


def slows_too_little(name: str) -> None:
    """A light ball between heavy ones: the limit is far off, and nobody says that there is none."""
    with pytest.raises(nip.ImpactError, match=r"g1, g2 still pass .* light beside") as caught:
        run(name)
    assert caught.value.evidence["strikes"] >= 10_000


def shares_a_name(name: str) -> None:
    """A drive and a stop of one name: each has its own quantities."""
    table = nip.turn_table(nip.load(HERE / name), speed_rpm=650.0, torques=True)
    assert table.clamped_share[0] == pytest.approx(0.39441887, abs=1e-8)
    assert table.collisions["cam"][0] == 7
    assert table.largest_torque["cam"][0] > 0.0


def cannot_start(name: str) -> None:
    """At 70 degrees of one arm no links close the loop with two other joints at 0."""
    words = (
        r"phase 1 swinging \(no stop closed\), arm1_joint where \[initial\] says, "
        r"plate_joint, fore2_joint at 0, as nothing says where: \[initial\] has to give other"
    )
    with pytest.raises(nip.ConvergenceError, match=words) as caught:
        run(name)
    assert caught.value.evidence["residual"] == pytest.approx(22.6e-3, abs=5e-5)
    # There is no drive, so no index is another place.
    assert "drive" not in caught.value.message
    assert "start_index" not in caught.value.message


RIGHT: dict[str, Callable[[str], None]] = {
    "ball_contact": lambda name: bounces_of_a_ball(name, 0.1, 0.5, "floor"),
    "ball_e0": lambda name: bounces_of_a_ball(name, 1.0, 0.0, "floor"),
    "ball_e05": lambda name: bounces_of_a_ball(name, 1.0, 0.5, "floor"),
    "bungee_3rows": bends,
    "ball_e0999": lambda name: bounces_of_a_ball(name, 1.0, 0.999, "floor"),
    "clamp": clamps,
    "crlf_bom": lambda name: bounces_of_a_ball(name, 1.0, 0.5, "floor"),
    "ecc_graze": barely_jumps,
    "ecc_jump_stopname": jumps,
    "fb_yaxis": lambda name: four_bar(name, -1.0),
    "grip_both_closed": lambda name: grips(name, 0.012, "s1", "s2"),
    "grip_first": lambda name: grips(name, 0.011, "s2"),
    "grip_same": lambda name: grips(name, 0.012, "s1", "s2"),
    "lip_on_parent": stays_shut,
    "lips_mesh_mesh_slide": lambda name: carried(name, 2.0 * GRAVITY, 1.0),
    "forty_balls_apart": each_ball_as_alone,
    "mirror_gripper": mirrored_jaws,
    "name_clash": shares_a_name,
    "onshape_fivebar_6": five_bar,
    "par_one_stop": lies_down,
    "par_two_stops": lies_down,
    "sequential_heavy_light": slows_too_little,
    "spring_pad_3rows": bends,
    "spring_pad_4rows": sinks_in,
    "sw_fourbar_16": whole_four_bar,
    "sw_fourbar_5": rounded_four_bar,
    "rod_falls_away": falls_on_a_peg,
    "rod_falls_on_peg": falls_on_a_peg,
    "three_same_time": losses,
    "twin_jaws": lambda name: bounces_of_a_ball(name, 0.2, 0.4, "left", "right"),
    "u03_cartpole": stays,
    "u08_pendulum": stays,
    "u10_prismatic": falls,
    "urdf_limit": falls,
    "volc_pasted": cannot_start,
    "window_before_rest": outlasts_the_window,
    "yoke_6dec": turned_yoke,
} | dict.fromkeys(
    (
        "fb_jointprops",
        "fb_latin",
        "fb_ns",
        "in_mm",
        "leak_limit_pi",
        "limit_partial",
        "mat_no_name",
        "no_limit_rev",
        "tiny_frame_mass",
        "two_inertials",
    ),
    four_bar,
)
RIGHT |= dict.fromkeys(
    ("rod_gap_1nm", "rod_gap_1um", "rod_on_peg", "rod_rest_neg"),
    lambda name: carried(name, 2.0 * GRAVITY * 0.45 / 0.7, 0.7),
)
RIGHT |= dict.fromkeys(
    ("lips_box_wedge", "lips_mesh_mesh", "lips_mesh_mesh_neg", "lips_mesh_wedge"),
    lambda name: carried(name, 2.0 * GRAVITY * 0.45 / 0.6875, 0.6875),
)


def test_every_machine_has_its_value_or_its_refusal() -> None:
    folders = {item.parent.name for item in HERE.glob("*/*.urdf")}
    assert folders == RIGHT.keys() | REFUSED.keys()


@pytest.mark.parametrize("name", RIGHT)
def test_machine_does_what_it_has_to(name: str) -> None:
    RIGHT[name](name)


@pytest.mark.parametrize("name", REFUSED)
def test_mistake_is_named(name: str) -> None:
    with pytest.raises(nip.InputError, match=REFUSED[name]):
        nip.load(HERE / name)


@pytest.mark.parametrize(
    ("name", "mass", "stiffness", "fall", "before"),
    [("spring_pad_3rows", 1.3, 1600.0, 0.45, 0.0), ("bungee_3rows", 70.0, 45.0, 6.0, 6.0)],
)
def test_rows_joined_by_lines(
    name: str, mass: float, stiffness: float, fall: float, before: float, tmp_path: Path
) -> None:
    """Straight lines are exact; the first strikes at 0."""
    folder = tmp_path / name
    shutil.copytree(HERE / name, folder)
    file = folder / f"{name}.toml"
    text = re.sub("(?m)^joint =", 'interpolation = "linear"\njoint =', file.read_text())
    file.write_text(text, encoding="utf-8")
    solution = run(str(folder))
    assert solution.warnings == ()
    assert lowest_m(solution) == pytest.approx(-before - depth_m(mass, stiffness, fall), rel=1e-9)


def test_rows_of_a_spring_that_falls(tmp_path: Path) -> None:
    """A magnet of -600 N/m: x = 4 mm (1 - cosh(w t)) + v / w sinh(w t) is 0.9 mm at the strike."""
    folder = tmp_path / "rows"
    shutil.copytree(HERE / "print_hammer_linear", folder)
    file = folder / "print_hammer_linear.toml"
    rows = "coordinate_mm = [-1.0, 3.0]\nforce_N = [3.0, 0.6]\n"
    text = re.sub("stiffness_N_per_m.*\npreload_length_mm.*\n", rows, file.read_text())
    file.write_text(text, encoding="utf-8")
    first = run(str(folder)).collisions[0]
    assert (first.stop, first.t) == ("paper", pytest.approx(0.70410694e-3, abs=5e-12))
    assert first.approach_rate == pytest.approx(-1.07450986, abs=5e-9)


def test_phases_have_the_names_of_the_file(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Without a start of its own the arm hangs with all ten stops open, and that has a name."""
    folder = tmp_path / "hanging"
    shutil.copytree(HERE / "volc_pasted", folder)
    file = folder / "volc_pasted.toml"
    file.write_text(file.read_text().replace("at_deg = 70.0", "at_deg = 0.0"), encoding="utf-8")
    assert main(["simulate", str(folder), "--window", "cycle"]) == 0
    said = capsys.readouterr().out
    assert "1 swinging  none" in said
    assert "off its stop" not in said


def test_the_lever_of_a_slide_is_no_length(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["check", str(HERE / "lips_mesh_mesh_slide")]) == 0
    assert "lever 1 of the travel" in " ".join(capsys.readouterr().out.split())
