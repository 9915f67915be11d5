"""Springs, dampers and stops: what those of a file become, forces of a table, laws of impacts."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from rows_of_balls import row
from small_machines import hinge, link, machine, slide

import nipper_pin as nip
from nipper_pin.cli import main
from nipper_pin.mechanism import (
    Characteristic,
    Damper,
    Stop,
    Strut,
    changed,
)
from nipper_pin.mechanism.files import toml
from nipper_pin.reduced import build, transition
from tests.refusals.bases import PARTS

TIE = {"frame_a": "a", "frame_b": "b"}

RAIL, PIVOT = {"joint": "rail"}, {"joint": "pivot"}

TABLES: dict[str, Any] = {
    "springs": {
        "tie": {**TIE, "stiffness_N_per_m": 9000.0, "free_length_mm": 186.5},
        "lid": {**PIVOT, "coordinate_deg": [-90, 0, 180], "torque_N_m": [1, 2, 4]},
    },
    "dampers": {
        "oil": {**RAIL, "damping_N_s_per_m": 12.0},
        "lid": {**PIVOT, "damping_N_m_s_per_rad": 0.3},
        "stay": {**TIE, "damping_N_s_per_m": 5},
    },
}


def test_elements_in_si_units() -> None:
    mechanism = machine(PARTS, 3, **TABLES)
    index = {joint.name: joint.index for joint in mechanism.joints}
    assert mechanism.springs == ()
    assert mechanism.dampers == (
        Damper(name="oil", index=index["rail"], damping=12.0),
        Damper(name="lid", index=index["pivot"], damping=0.3),
    )
    assert mechanism.struts == (
        Strut(name="tie", kind="spring", frame_a="a", frame_b="b", stiffness=9000.0,
              free_length=pytest.approx(0.1865)),
        Strut(name="stay", kind="damper", frame_a="a", frame_b="b", damping=5.0),
    )  # fmt: skip
    (table,) = mechanism.tabulated_springs
    assert (table.name, table.index) == ("lid", index["pivot"])
    assert table.characteristic.coordinate == pytest.approx((-0.5 * math.pi, 0.0, math.pi))
    assert table.characteristic.force == (1.0, 2.0, 4.0)


ROWS = Characteristic(coordinate=(-2.0, 0.0, 1.0, 4.0, 5.0), force=(-4.0, 0.0, 0.5, 8.0, 30.0))


def test_characteristic_keeps_to_its_rows() -> None:
    """Rows are met, and between two of them a table that rises never falls nor overshoots.

    A cubic spline through these rows falls between the second and the third. One-sided differences
    at the inner rows meet as the step goes to zero; linear ones do not.
    """
    x = np.linspace(-2.0, 5.0, 7001)
    f = ROWS.forces(x)
    np.testing.assert_allclose(ROWS.forces(np.array(ROWS.coordinate)), ROWS.force, rtol=1e-15)
    assert (np.diff(f) > 0.0).all()
    h = 1e-6
    for knot in ROWS.coordinate[1:-1]:
        before, here, after = ROWS.forces(knot + h * np.array([-1.0, 0.0, 1.0]))
        assert (after - here) / h == pytest.approx((here - before) / h, abs=1e-3)


def test_energy_is_the_integral_of_the_force() -> None:
    """Gauss quadrature with 8 points between rows, exact for cubics: 1e-14 of the energy."""
    points, weights = np.polynomial.legendre.leggauss(8)
    total = 0.0
    for low, high in zip(ROWS.coordinate, ROWS.coordinate[1:], strict=False):
        x = low + 0.5 * (high - low) * (points + 1.0)
        total += 0.5 * (high - low) * float(weights @ ROWS.forces(x))
        assert ROWS.energies(np.array([high]))[0] == pytest.approx(total, abs=1e-13)


def test_rows_on_a_line_are_the_line() -> None:
    """Force and energy of uneven rows on 3 (x + 0.2), to the round-off of some operations.

    Beyond the ends for the length of the table, then the force grows no more. The energy is the
    integral from the first row.
    """
    rows = np.array([-1.0, -0.3, 0.1, 2.0, 2.1])
    line = Characteristic(coordinate=tuple(rows), force=tuple(3.0 * (rows + 0.2)))
    assert line.reach == pytest.approx((-4.1, 5.2), rel=1e-15)
    # The cubic between rows that are 0.1 apart goes on for 3.1: an eps grows by (3.1 / 0.1)^3.
    for low, high, error in ((-1.0, 2.1, 1e-14), (-4.1, 5.2, 2e-11)):
        x = np.linspace(low, high, 101)
        np.testing.assert_allclose(line.forces(x), 3.0 * (x + 0.2), rtol=0.0, atol=error)
        energy = 1.5 * ((x + 0.2) ** 2 - 0.64)
        np.testing.assert_allclose(line.energies(x), energy, rtol=0.0, atol=3.1 * error)
    ends = line.forces(np.array([-9.0, 9.0]))
    np.testing.assert_allclose(ends, [-11.7, 16.2], rtol=0.0, atol=error)


def test_a_slope_that_is_nearly_none() -> None:
    """Its reciprocal overflows, which would be a warning; the force stays between its rows."""
    flat = Characteristic(coordinate=(0.0, 1.0, 2.0), force=(0.0, 1e-310, 1.0))
    assert flat.forces(np.array([0.5, 1.0])).max() <= 1e-310
    assert 0.0 < flat.forces(np.array([1.5]))[0] < 1.0


CART = [link("cart"), slide("x", "frame", "cart"), link("arm"), hinge("turn", "cart", "arm")]


def test_places_and_sides_are_read_in_their_units() -> None:
    """Millimetres of a slide, degrees of a hinge; a stop without them is the lower one at zero."""
    mechanism = machine(CART, 2, stops={
        "wall": {"joint": "x", "restitution": 0.5, "side": "upper", "at_mm": 120.0},
        "floor": {"joint": "x", "restitution": 0.5},
        "turned": {"joint": "turn", "restitution": 0.25, "at_deg": -90.0},
    })  # fmt: skip
    found = {stop.name: (stop.sense, stop.at) for stop in mechanism.stops}
    assert found == {"wall": (-1.0, 0.12), "floor": (1.0, 0.0), "turned": (1.0, -np.pi / 2.0)}
    assert [stop.plain for stop in mechanism.stops] == [False, True, False]


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
    case = nip.Case(speed_rpm=60.0, window=nip.Window.CYCLE, start_index=0.0)
    with pytest.raises(nip.InputError, match=r"stop 'a' would be 5 mm beyond its contact"):
        nip.simulate(machine(CART, 2, stops=stops), case)
    closed = [{"number": 1, "name": "at the wall", "closed": ["a"]}]
    springs = {"k": {"joint": "x", "stiffness_N_per_m": 5.0, "preload_length_mm": -10.0}}
    solution = nip.simulate(machine(CART, 2, stops=stops, phases=closed, springs=springs), case)
    q = solution.trajectory.evaluate([0.0, 0.5, 1.0]).q
    assert (q[:, 0] == -0.005).all()
    force = solution.trajectory.reactions(0.5).stops["a"][0]
    assert force == pytest.approx(5.0 * (0.010 + 0.005), rel=1e-12)


FALL = nip.Case(speed_rpm=20.0, window=nip.Window.CYCLE, start_index=0.0, max_collisions=1)


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


def _upper(mechanism: nip.Mechanism) -> float:
    """Speed of the upper ball after the strike, by that before it."""
    hit = next(event for event in nip.simulate(mechanism, FALL).events if event.t > 0.0)
    return float(hit.v_after.sum() / -hit.v_before.sum())


def test_it_may_be_left_out_written_and_changed(cannon: Path) -> None:
    """At once both leave with the speed of the fall; in sequence the upper one with twice that."""
    plain = nip.load(cannon)
    assert plain.simultaneous == "newton"
    other = nip.load(cannon, {"simultaneous": "sequential"})
    assert other.simultaneous == "sequential"
    assert [_upper(plain), _upper(other)] == pytest.approx([1.0, 2.0], rel=1e-14)
    file = cannon / "cannon.toml"
    file.write_text('simultaneous = "sequential"\n' + file.read_text(encoding="utf-8"))
    written = nip.load(cannon)
    assert written.simultaneous == "sequential"
    assert nip.load(cannon, {"simultaneous": "newton"}).simultaneous == "newton"
    assert changed(written, {"stops.s0.restitution": 0.5}).simultaneous == "sequential"


def test_a_saved_run_keeps_it(cannon: Path, tmp_path: Path) -> None:
    solution = nip.simulate(nip.load(cannon, {"simultaneous": "sequential"}), FALL)
    nip.save(solution, tmp_path / "run.npz")
    again = nip.load_solution(tmp_path / "run.npz")
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
def test_laws_agree_in_the_reduced_engine(e62: nip.Mechanism) -> None:
    """One freedom, in which the strike at the jaw throws the steeve off: both laws are one."""
    other = changed(e62, {"simultaneous": "sequential"})
    found = [transition(build(item), speed_rpm=450.0).table for item in (e62, other)]
    assert np.array_equal(*found)
    runs = [nip.simulate(item, nip.Case(speed_rpm=450.0)) for item in (e62, other)]
    for one, two in zip(*(run.events for run in runs), strict=True):
        assert np.array_equal(one.v_after, two.v_after)
    assert [run.warnings for run in runs] == [(), ()]
