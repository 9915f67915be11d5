"""Stops on either side of a joint, and the law of those that touch."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from rows_of_balls import row
from small_machines import hinge, link, machine, slide

from nipper_pin import (
    Case,
    InputError,
    Mechanism,
    Window,
    check,
    load,
    load_solution,
    save,
    simulate,
)
from nipper_pin.cli import main
from nipper_pin.mechanism import Stop, with_numbers
from nipper_pin.mechanism.files import toml
from nipper_pin.reduced import build, transition, unfit
from tests.refusals.bases import model

PARTS = [link("cart"), slide("x", "frame", "cart"), link("arm"), hinge("turn", "cart", "arm")]


def test_places_and_sides_are_read_in_their_units() -> None:
    """Millimetres of a slide, degrees of a hinge; a stop without them is the lower one at zero.

    The findings about a model say which limit of which joint each stop is.
    """
    mechanism = machine(PARTS, 2, stops={
        "wall": {"joint": "x", "restitution": 0.5, "side": "upper", "at_mm": 120.0},
        "floor": {"joint": "x", "restitution": 0.5},
        "turned": {"joint": "turn", "restitution": 0.25, "at_deg": -90.0},
    })  # fmt: skip
    found = {stop.name: (stop.sense, stop.at) for stop in mechanism.stops}
    assert found == {"wall": (-1.0, 0.12), "floor": (1.0, 0.0), "turned": (1.0, -np.pi / 2.0)}
    assert [stop.plain for stop in mechanism.stops] == [False, True, False]
    assert check(mechanism, 60.0).record()["stops"] == {
        "wall": {"joint": "x", "side": "upper", "at": 0.12, "restitution": 0.5},
        "floor": {"joint": "x", "side": "lower", "at": 0.0, "restitution": 0.5},
        "turned": {"joint": "turn", "side": "lower", "at": -np.pi / 2.0, "restitution": 0.25},
    }


@pytest.mark.parametrize("sense", [1.0, -1.0])
@pytest.mark.parametrize("at", [0.0, 0.1, -1.0 / 3.0])
def test_gap_and_rate_count_from_the_stop(sense: float, at: float) -> None:
    """g_N is zero to the last bit at the stop and grows away from it, on whichever side that is.

    The neighbouring number of ``at`` on the free side is a positive gap of one unit in the last
    place: the difference of nearby numbers is exact.
    """
    stop = Stop(name="s", index=1, restitution=0.0, contact=None, sense=sense, at=at)
    q = np.array([7.0, at, 7.0])
    assert stop.gap(q) == 0.0
    near = np.nextafter(at, sense * np.inf)
    assert stop.gap(np.array([7.0, near, 7.0])) == abs(near - at) > 0.0
    many = np.array([q, q + sense * 0.25])
    assert stop.gaps(many) == pytest.approx([0.0, 0.25], abs=1e-16)
    v = np.array([[7.0, 3.0, 7.0]])
    assert (stop.rate(v[0]), stop.rates(v).tolist()) == (sense * 3.0, [sense * 3.0])


def test_a_stop_beyond_its_contact_at_the_start_is_refused() -> None:
    """A coordinate of zero above an upper stop at -5 mm lies in the wall: by 0.005 m, with advice.

    With that stop closed in the initial phase the joint starts at the stop instead.
    """
    stops = {"a": {"joint": "x", "restitution": 0.5, "side": "upper", "at_mm": -5.0}}
    case = Case(speed_rpm=60.0, window=Window.CYCLE, start_index=0.0)
    with pytest.raises(InputError, match=r"stop 'a' would be 5 mm beyond its contact"):
        simulate(machine(PARTS, 2, stops=stops), case)
    closed = [{"number": 1, "name": "at the wall", "closed": ["a"]}]
    springs = {"k": {"joint": "x", "stiffness_N_per_m": 5.0, "preload_length_mm": -10.0}}
    solution = simulate(machine(PARTS, 2, stops=stops, phases=closed, springs=springs), case)
    q = solution.trajectory.evaluate([0.0, 0.5, 1.0]).q
    assert (q[:, 0] == -0.005).all()
    force = solution.trajectory.reactions(0.5).stops["a"][0]
    assert force == pytest.approx(5.0 * (0.010 + 0.005), rel=1e-12)


def test_a_transition_needs_a_stop_that_is_closed_at_touch() -> None:
    """A transition starts where its stop collides; one that stands open there is told so."""
    stops = {"a": {"joint": "x", "restitution": 0.5, "at_mm": -5.0}}
    with pytest.raises(InputError, match=r"stop 'a' stands open by 5 mm .*whole turns"):
        simulate(machine(PARTS, 2, stops=stops), Case(speed_rpm=60.0))


def test_the_reduced_engine_leaves_other_stops_to_the_direct_one(
    e62: Mechanism, tmp_path: Path
) -> None:
    """An upper stop, or one away from zero, is a reason in one sentence; plain ones are not."""
    assert unfit(e62) is None
    limit = '[stops.limit]\njoint = "jaw"\nrestitution = 0.2\nside = "upper"\nat_deg = 60.0\n'
    limited = load(model("e62", ("[stops.jaw]", f"{limit}[stops.jaw]"), tmp_path))
    assert "'limit'" in (unfit(limited) or "")
    with pytest.raises(InputError, match=r"lower stops at coordinate zero.*use the direct engine"):
        build(limited)
    wide, plain = (simulate(item, Case(speed_rpm=450.0)).transitions[0] for item in (limited, e62))
    assert wide.duration == pytest.approx(plain.duration, rel=1e-12)


FALL = Case(speed_rpm=20.0, window=Window.CYCLE, start_index=0.0, max_collisions=1)


@pytest.fixture
def cannon(tmp_path: Path) -> Path:
    """3 kg below 1 kg, both falling: a model folder that does not write the choice."""
    made = row([3.0, 1.0], 1.0, wall=True, gravity=9.81, initial={"z0": {"at_mm": 200.0}})
    folder = tmp_path / "cannon"
    folder.mkdir()
    (folder / "cannon.urdf").write_text(made.urdf, encoding="utf-8")
    tables = {key: value for key, value in made.description.items() if key != "simultaneous"}
    (folder / "cannon.toml").write_text(toml(tables), encoding="utf-8")
    return folder


def _upper(mechanism: Mechanism) -> float:
    """Speed of the upper ball after the strike, by that before it."""
    hit = next(event for event in simulate(mechanism, FALL).events if event.t > 0.0)
    return float(hit.v_after.sum() / -hit.v_before.sum())


def test_it_may_be_left_out_written_and_changed(cannon: Path) -> None:
    """At once both leave with the speed of the fall; in sequence the upper one with twice that."""
    plain = load(cannon)
    assert plain.simultaneous == "newton"
    changed = load(cannon, {"simultaneous": "sequential"})
    assert changed.simultaneous == "sequential"
    assert [_upper(plain), _upper(changed)] == pytest.approx([1.0, 2.0], rel=1e-14)
    file = cannon / "cannon.toml"
    file.write_text('simultaneous = "sequential"\n' + file.read_text(encoding="utf-8"))
    written = load(cannon)
    assert written.simultaneous == "sequential"
    assert load(cannon, {"simultaneous": "newton"}).simultaneous == "newton"
    assert with_numbers(written, {"stops.s0.restitution": 0.5}).simultaneous == "sequential"


def test_a_saved_run_keeps_it(cannon: Path, tmp_path: Path) -> None:
    solution = simulate(load(cannon, {"simultaneous": "sequential"}), FALL)
    save(solution, tmp_path / "run.npz")
    again = load_solution(tmp_path / "run.npz")
    assert again.mechanism.simultaneous == "sequential"
    assert again.warnings == solution.warnings != ()


def test_the_command_line_says_it(
    cannon: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """`check` where it is not the usual one, `simulate` where the outcome depends on it."""
    sequential = ["--set", "simultaneous=sequential"]
    said = {}
    for words in ([], sequential):
        assert main(["check", str(cannon), *words]) == 0
        said[len(words)] = " ".join(capsys.readouterr().out.split())
        document = tmp_path / "run.json"
        cycle = ["--window", "cycle", "--speed", "20", "--start-index", "0"]
        assert main(["simulate", str(cannon), *cycle, *words, "--json", str(document)]) == 0
        (warning,) = json.loads(document.read_text(encoding="utf-8"))["warnings"]
        assert " ".join(warning.split()) in " ".join(capsys.readouterr().out.split())
    assert "impulses pass from contact to contact" in said[2]
    assert "stops struck together" not in said[0]


@pytest.mark.slow
def test_laws_agree_in_the_reduced_engine(e62: Mechanism) -> None:
    """One freedom, in which the strike at the jaw throws the steeve off: both laws are one."""
    other = with_numbers(e62, {"simultaneous": "sequential"})
    found = [transition(build(item, turn=False), speed_rpm=450.0).table for item in (e62, other)]
    assert np.array_equal(*found)
    runs = [simulate(item, Case(speed_rpm=450.0)) for item in (e62, other)]
    for one, two in zip(*(run.events for run in runs), strict=True):
        assert np.array_equal(one.v_after, two.v_after)
    assert [run.warnings for run in runs] == [(), ()]
