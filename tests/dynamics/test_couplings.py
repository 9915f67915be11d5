"""Joints that follow others (<mimic>): pairs without a drive, and behind one."""

from __future__ import annotations

import copy
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from small_machines import hinge, link, machine, slide

import nipper_pin as nip
from nipper_pin.cli import main
from nipper_pin.mechanism import from_sources

CYCLE = nip.Case(speed_rpm=60.0, window=nip.Window.CYCLE)


def following(joint: str, of: str, words: str) -> str:
    return joint.replace("</joint>", f'<mimic joint="{of}" {words}/></joint>')


def test_a_pair_of_wheels_without_a_drive() -> None:
    """Two eccentric wheels, one turning twice as fast the other way: one equation of motion.

    With q2 = -2 q1 the inertia is I1 + 4 I2, and each weight acts at its own angle.
    """
    parts = [
        link("a", 1.0, 0.02, (0.1, 0.0)), hinge("p", "frame", "a"),
        link("b", 0.5, 0.01, (0.2, 0.0)),
        following(hinge("q", "frame", "b", (0.3, 0.0)), "p", 'multiplier="-2"'),
    ]  # fmt: skip
    found = nip.simulate(machine(parts, 1, gravity=9.81, initial={"p": {"at_deg": 10.0}}), CYCLE)
    times = np.linspace(0.0, 0.99, 8)
    q = found.trajectory.evaluate(times).q
    inertia = (0.02 + 0.1**2) + 4.0 * (0.01 + 0.5 * 0.2**2)

    def rates(_: float, y: Any) -> list[float]:
        first, second = 0.1 * np.cos(y[0]), 0.5 * 0.2 * np.cos(-2.0 * y[0])
        return [y[1], -9.81 * (first - 2.0 * second) / inertia]

    right = solve_ivp(
        rates, (0.0, 1.0), [np.radians(10.0), 0.0], t_eval=times, rtol=1e-12, atol=1e-13,
        method="DOP853",
    ).y[0]  # fmt: skip
    np.testing.assert_allclose(q[:, 0], right, rtol=0.0, atol=1e-10)
    np.testing.assert_allclose(q[:, 1], -2.0 * q[:, 0], rtol=0.0, atol=1e-14)


@pytest.mark.parametrize("struck", [("p",), ("q",), ("p", "q")], ids=str)
def test_a_slide_that_lifts_another_bounces_with_both_masses(struck: tuple[str, ...]) -> None:
    """1 kg falls and drives 0.5 kg sideways at twice its speed: 3 kg fall by the weight of one.

    At rest after t1 (1 + e)/(1 - e); the first impulse turns 3 kg round at the first slide, and
    half of it does at the second. With a stop on each, either does.
    """
    parts = [
        link("a", 1.0), slide("p", "frame", "a", (0.0, 1.0)), link("b", 0.5),
        following(slide("q", "frame", "b", (1.0, 0.0)), "p", 'multiplier="-2.0"'),
    ]  # fmt: skip
    sides = {"p": "lower", "q": "upper"}
    stops = {name: {"joint": name, "restitution": 0.5, "side": sides[name]} for name in struck}
    found = nip.simulate(
        machine(parts, 1, gravity=9.81, stops=stops, initial={"p": {"at_mm": 100.0}}), CYCLE
    )
    fall, mass = 9.81 / 3.0, 3.0
    first = np.sqrt(2.0 * 0.1 / fall)
    assert found.events[0].t == pytest.approx(first, abs=1e-12)
    assert found.events[-1].t == pytest.approx(3.0 * first, abs=1e-12)
    assert found.events[-1].closed_after
    impulse = 1.5 * mass * fall * first
    by_p = found.events[0].P_N.get("p", 0.0) + 2.0 * found.events[0].P_N.get("q", 0.0)
    assert by_p == pytest.approx(impulse, rel=1e-12)
    assert found.checks.energy_balance < 1e-13


@pytest.fixture(scope="module")
def combers() -> tuple[nip.Mechanism, nip.Mechanism, float]:
    """The E62, and one whose tension shaft follows the pendulum shaft by its URDF."""
    plain = nip.load("e62")
    document: dict[str, Any] = copy.deepcopy(dict(plain.description))
    ratio = float(document["drives"].pop("tension")["ratio"])
    document["degrees_of_freedom"] = 2
    start = plain.urdf.index('<joint name="tension_shaft"')
    place = plain.urdf.index("</joint>", start)
    mimic = f'<mimic joint="pendulum_shaft" multiplier="{ratio!r}"/>'
    urdf = plain.urdf[:place] + mimic + plain.urdf[place:]
    document["shortcuts"] = {}
    return plain, from_sources("e62", urdf, document, plain.mesh_folder), ratio


@pytest.mark.parametrize("window", [nip.Window.TRANSITION, nip.Window.CYCLE])
def test_a_shaft_geared_by_the_urdf_is_one_geared_by_the_drive(
    combers: tuple[nip.Mechanism, nip.Mechanism, float], window: nip.Window
) -> None:
    """Motion, impacts, reactions; the one drive has the torque of both, geared."""
    plain, coupled, ratio = combers
    one, two = (
        nip.simulate(item, nip.Case(speed_rpm=650.0, window=window)) for item in (plain, coupled)
    )
    assert len(one.events) == len(two.events) > 5
    for first, second in zip(one.events, two.events, strict=True):
        assert second.t == pytest.approx(first.t, abs=1e-13)
        np.testing.assert_allclose(second.q, first.q, rtol=0.0, atol=1e-13)
        # The rate of the follower is one of the motion, to its tolerance of 1e-10.
        np.testing.assert_allclose(second.v_after, first.v_after, rtol=0.0, atol=1e-10)
    times = np.linspace(0.0, 0.99 * one.trajectory.span[1], 7)
    here, there = (item.trajectory.reactions(times) for item in (one, two))
    for joint, wrench in here.joints.items():
        np.testing.assert_allclose(there.joints[joint], wrench, rtol=0.0, atol=1e-9)
    torque = here.drives["pendulum"] + ratio * here.drives["tension"]
    np.testing.assert_allclose(there.drives["pendulum"], torque, rtol=0.0, atol=1e-9)


@pytest.mark.slow
def test_tables_of_a_coupled_machine(combers: tuple[nip.Mechanism, nip.Mechanism, float]) -> None:
    plain, coupled, _ = combers
    one, two = (
        nip.transition_table(item, speed_rpm=[600.0, 650.0], engine="reduced")
        for item in combers[:2]
    )
    assert plain.degrees_of_freedom == coupled.degrees_of_freedom + 1
    assert (one.collisions == two.collisions).all()
    np.testing.assert_allclose(two.duration, one.duration, rtol=0.0, atol=1e-11)


PAIR = (link("a"), hinge("p", "frame", "a"), link("b"))


def test_joints_that_follow_one_another() -> None:
    """A circle of them is refused, and so is a drive of both; a chain of them is none."""
    p = following(hinge("p", "frame", "a"), "q", "")
    q = following(hinge("q", "frame", "b"), "p", "")
    with pytest.raises(nip.ModelError, match=r"mimic of joint p.*mimic of joint q"):
        machine([link("a"), p, link("b"), q], 1)
    turn = {"law": "constant_speed", "ratio": 1.0}
    drives = {"one": {"joint": "p", **turn}, "two": {"joint": "q", **turn}}
    with pytest.raises(nip.ModelError, match=r"mimic of joint q.*drive two"):
        machine([*PAIR, q], 1, drives=drives)
    third = following(hinge("r", "frame", "c"), "q", 'multiplier="3"')
    chain = machine([*PAIR, q, link("c"), third], 1, drives={"one": drives["one"]})
    start, end = nip.simulate(chain, CYCLE).trajectory.evaluate(np.array([0.0, 0.5])).q
    np.testing.assert_allclose(end - start, [np.pi, np.pi, 3.0 * np.pi], rtol=1e-12)


def test_check_names_what_a_joint_follows(tmp_path: Any, capsys: Any) -> None:
    folder = tmp_path / "pair"
    main(["new", f"{tmp_path / 'drawn'}"])
    main(["export", f"{tmp_path / 'drawn'}", str(folder)])
    urdf = folder / "pair.urdf"
    text = urdf.read_text(encoding="utf-8")
    wheel = link("wheel", 0.1, 1e-4) + following(
        hinge("wheel_hinge", "frame", "wheel"), "crank", 'multiplier="-1.5"'
    )
    name = text.partition('<joint name="')[2].partition('"')[0]
    urdf.write_text(text.replace("</robot>", f"{wheel.replace('crank', name)}</robot>"))
    capsys.readouterr()
    assert main(["check", str(folder)]) == 0
    assert f"-1.5 times {name}" in " ".join(capsys.readouterr().out.split())
