"""The same machine with its spring in another form, dampers on drives, and tables to their ends."""

from __future__ import annotations

import math
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import sprung

from nipper_pin import (
    Case,
    DriveMode,
    ElementError,
    Mechanism,
    Resolution,
    Solution,
    Window,
    load,
    load_solution,
    save,
    simulate,
    transition_table,
    turn_table,
)
from nipper_pin.mechanism import from_sources
from nipper_pin.reduced import unfit


def joint(stiffness: float, preload: float) -> dict[str, Any]:
    """A spring on the slide [N/m, mm]."""
    return {"joint": "steeve", "stiffness_N_per_m": stiffness, "preload_length_mm": preload}


def points(stiffness: float, preload: float) -> dict[str, Any]:
    """The same between the two pins."""
    free = math.hypot(67.38782025129913, 162.2487823687206) + preload
    return {"frame_a": "steeve_lower", "frame_b": "steeve_upper",
            "stiffness_N_per_m": stiffness, "free_length_mm": free}  # fmt: skip


PLACES = (-5.0, 1.0, 2.5, 8.0, 40.0)


def rows(stiffness: float, preload: float, harder: float = 0.0) -> dict[str, Any]:
    """The same as a table, or one that grows harder along the stroke."""
    forces = [1e-3 * stiffness * (preload + x) * (1.0 + harder * x) for x in PLACES]
    return {"joint": "steeve", "coordinate_mm": list(PLACES), "force_N": forces}


FORMS = {
    "points": [points(9000.0, 11.0)],
    "table": [rows(9000.0, 11.0)],
    "two springs": [joint(4000.0, -20.0), joint(5000.0, 35.8)],
    "two lines": [points(4000.0, -20.0), points(5000.0, 35.8)],
    "two tables": [rows(4000.0, -20.0), rows(5000.0, 35.8)],
    "one of each": [joint(2000.0, -30.0), rows(3000.0, 40.0), points(4000.0, 9.75)],
}
"""Springs of the steeve whose sum is that of the E62.

The slide lies along the line of the two pins, 175.7 mm apart at touch, and its coordinate is what
the line has lost; a free length 11 mm longer is the preload. Parts have 9 N/mm and 99 N.
"""
BETWEEN_POINTS = {"points": (9000.0, 11.0), "two lines": (9000.0, 11.0),
                  "one of each": (4000.0, 9.75)}  # fmt: skip


def sprung_by(springs: list[dict[str, Any]], **tables: Any) -> Mechanism:
    """The E62 with other springs on its steeve, and further tables."""
    e62 = load("e62")
    own = {"steeve": springs[0], **{f"other_{k}": item for k, item in enumerate(springs[1:])}}
    known = {key: item for key, item in e62.description.items() if key != "shortcuts"}
    return from_sources(
        "e62", e62.urdf, {**known, "springs": own, **tables}, e62.mesh_folder or "."
    )


@cache
def plain(window: Window) -> Solution:
    """The E62 with its own spring."""
    return simulate(load("e62"), Case(speed_rpm=650.0, window=window))


@pytest.mark.parametrize("kind", FORMS)
@pytest.mark.parametrize("window", [Window.TRANSITION, Window.CYCLE])
def test_same_spring_in_another_form(kind: str, window: Window) -> None:
    """Collisions of the E62 at 650 r/min agree to 1e-12 s, rates and impulses to 1e-9.

    Forces agree to 1e-5 N. Panels at 1e-12 of some milliseconds; a late, small bounce has lost
    three digits of its rate.
    A preload off by 1e-6 mm would shift the first flight by 1e-10 s.
    """
    one = plain(window)
    other = simulate(sprung_by(FORMS[kind]), one.case)
    assert len(one.events) == len(other.events) > 6
    for first, second in zip(one.collisions, other.collisions, strict=True):
        assert first.stop == second.stop
        assert second.t == pytest.approx(first.t, abs=1e-12)
        assert second.approach_rate == pytest.approx(first.approach_rate, rel=1e-9)
        assert second.impulse == pytest.approx(first.impulse, rel=1e-9)
    assert other.checks.energy_balance <= 1e-11
    for t in (0.2, 0.7):
        times = t * one.trajectory.span[1]
        there, here = one.trajectory.reactions(times), other.trajectory.reactions(times)
        stops = [*there.stops.values(), *there.drives.values(), *there.closures.values()]
        same = [*here.stops.values(), *here.drives.values(), *here.closures.values()]
        for left, right in zip(stops, same, strict=True):
            np.testing.assert_allclose(left, right, atol=1e-5)
        # Between two points the spring no longer acts through the slide, and only there.
        for name, left in there.joints.items():
            gone = np.linalg.norm((left - here.joints[name])[0])
            s = next(j.index for j in one.mechanism.joints if j.name == "steeve")
            stroke = one.trajectory.evaluate(times).q[0, s]
            k, p = BETWEEN_POINTS.get(kind, (0.0, 0.0)) if name == "steeve" else (0.0, 0.0)
            pull = k * (1e-3 * p + stroke)
            assert gone == pytest.approx(pull, abs=1e-5)


@pytest.mark.parametrize("of", ["transitions", "turns"])
def test_two_springs_on_one_joint_in_tables(of: str) -> None:
    """The reduced engine samples functions of its own for each; the direct one has a single one."""
    compute = {"transitions": transition_table, "turns": turn_table}[of]
    one, two = (
        compute(machine, speed_rpm=[500.0, 650.0], engine=engine, rest_rate=1e-3)
        for machine, engine in (
            (load("e62"), "direct"),
            (sprung_by(FORMS["two springs"]), "reduced"),
        )
    )
    names = ("duration", "rebound_amplitude") if of == "transitions" else ("energy_lost",
             "largest_clamping_force", "largest_gap", "closing_index")  # fmt: skip
    for name in names:
        np.testing.assert_allclose(getattr(two, name), getattr(one, name), rtol=1e-8)


def test_damper_on_a_driven_joint_loads_its_drive_alone() -> None:
    """A held shaft moves as before; its torque grows by c v, its work by the heat.

    Torques of 1e3 N m are exact to 1e-9. With elastic drive trains the same damper slows the shaft,
    and the balance closes to 1e-9 with the heat as a term of its own.
    """
    damping = 0.8
    plain = load("e62")
    damper = {"joint": "pendulum_shaft", "damping_N_m_s_per_rad": damping}
    damped = sprung_by([joint(9000.0, 11.0)], dampers={"shaft": damper})
    case = Case(speed_rpm=450.0, window=Window.CYCLE)
    one, other = simulate(plain, case), simulate(damped, case)
    assert [hit.t for hit in one.collisions] == [hit.t for hit in other.collisions]
    t = np.linspace(*one.trajectory.span, 50)
    shaft = next(item.index for item in plain.drives if item.name == "pendulum")
    rate = one.trajectory.evaluate(t).v[:, shaft]
    more = (
        other.trajectory.reactions(t).drives["pendulum"]
        - one.trajectory.reactions(t).drives["pendulum"]
    )
    np.testing.assert_allclose(more, damping * rate, atol=1e-6)
    assert other.energy.dissipated > 1.0
    grown = other.energy.drive_work - one.energy.drive_work
    assert grown == pytest.approx(other.energy.dissipated, rel=1e-9)
    elastic = simulate(damped, Case(speed_rpm=450.0, drive=DriveMode.INERTIAL))
    assert elastic.energy.dissipated > 0.1
    assert elastic.checks.energy_balance <= 1e-9


def test_stated_errors_hold_across_the_rows_of_a_table() -> None:
    """Collision times differ from those on tiny panels by less than twice what is stated.

    The reference has 4000 panels to a turn at 1e-14: rows lie in few of them, and in short ones.
    The table is far from a line: its transition is 2 % shorter than that of the linear spring, and
    the stroke passes two of its rows.
    """
    mechanism = sprung_by([rows(9000.0, 11.0, harder=0.02)])
    fine = Resolution(tolerance=1e-14, panels_per_turn=4000)
    exact = simulate(mechanism, Case(speed_rpm=650.0, resolution=fine))
    for tolerance in (1e-10, 1e-12, 1e-13):
        run = simulate(mechanism, Case(speed_rpm=650.0, resolution=Resolution(tolerance=tolerance)))
        assert len(run.collisions) > 4
        for hit, true in zip(run.collisions[1:], exact.collisions[1:], strict=False):
            stated = run.errors[hit.event.number - 1].time
            # The round-off of the reference's own times is some units of 1e-18 s a panel.
            assert abs(hit.t - true.t) <= 2.0 * stated + 2e-15
    linear = plain(Window.TRANSITION)
    assert run.transitions[0].duration < 0.985 * linear.transitions[0].duration


def test_motion_beyond_the_rows_is_refused() -> None:
    """The error names spring, joint, place and ends, and the time at which the last row is passed.

    With a level table of -2 N the mass reaches 30 mm at sqrt(2 m x / F).
    """
    level = '[springs.coil]\njoint = "x"\ncoordinate_mm = [-5.0, 30.0]\nforce_N = [-2.0, -2.0]\n'
    mechanism = sprung.machine([sprung.SLIDE_X], level)
    with pytest.raises(ElementError, match=r"spring coil: .*joint x .* from -5 to 30 mm") as caught:
        sprung.swing(mechanism, 1.5)
    evidence = caught.value.evidence
    passed = math.sqrt(2.0 * sprung.MASS * 0.03 / 2.0)
    # What is refused is the first state looked at beyond the end, within a panel of it.
    assert passed < evidence["t"] < passed + 0.02
    assert evidence["joint"] == "x"
    assert evidence["ends"] == (-0.005, 0.03)
    assert evidence["coordinate"] > 0.03


def test_saved_run_and_tables_of_cases(pendulum: Mechanism, tmp_path: Path) -> None:
    """A saved run comes back with all its elements; the reduced engine says what it has not got."""
    solution = sprung.swing(pendulum, 0.5)
    again = load_solution(save(solution, tmp_path / "run.npz"))
    for field in ("springs", "tabulated_springs", "dampers", "struts"):
        assert getattr(again.mechanism, field) == getattr(pendulum, field)
        assert getattr(pendulum, field)
    assert again.energy == solution.energy
    for kind, words in (
        ("points", "spring steeve between two points"),
        ("table", "table of spring"),
    ):
        mechanism = sprung_by(FORMS[kind])
        assert words in str(unfit(mechanism))
        table = transition_table(mechanism, speed_rpm=np.linspace(500.0, 650.0, 3))
        assert words in table.why
        assert (table.engine == "direct").all()
