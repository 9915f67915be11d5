"""The programs of scripts/extend, run as they stand and compared with closed forms."""

from __future__ import annotations

import importlib.metadata
import math
import sys
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import numpy as np
import pytest

import nipper_pin as nip
from nipper_pin import InputError, ModelError
from nipper_pin.cli import main
from nipper_pin.hybrid.error_estimate.saltation import impact_map
from nipper_pin.mechanism import changed, from_sources
from nipper_pin.mechanism.files import register as registers
from nipper_pin.mechanism.files.register import DRIVES, FORCES, RESTITUTIONS, STOPS
from nipper_pin.mechanism.restitution import Falling
from nipper_pin.mechanism.stops.screw import ScrewStop
from nipper_pin.reduced import unfit

PROGRAMS = Path(__file__).parents[1] / "scripts/extend"
EPS = float(np.finfo(float).eps)
GRAVITY = 9.81


def ran(page: str, monkeypatch: pytest.MonkeyPatch) -> Any:
    """A module with the names of a program, after it has run."""
    for register in (DRIVES, FORCES, RESTITUTIONS, STOPS):
        # What a program adds is gone after its test.
        monkeypatch.setattr(register, "_added", {})
    module = ModuleType(f"page_{page}")
    monkeypatch.setitem(sys.modules, module.__name__, module)
    code = (PROGRAMS / f"{page}.py").read_text(encoding="utf-8")
    exec(compile(code, page, "exec"), module.__dict__)
    return module


def test_a_force_element(monkeypatch: pytest.MonkeyPatch) -> None:
    """m v^2 / 2 = k x^2 / 2 + h x^4 / 4; without the cubic part the rate would be 0.8."""
    page = ran("a_force_element", monkeypatch)
    k, h, m, x = 800.0, 2e6, 0.5, 0.02
    struck = page.solution.collisions[0]
    assert struck.approach_rate == pytest.approx(
        -math.sqrt((k * x**2 + h * x**4 / 2.0) / m), rel=1e-12
    )
    # The rebound climbs to where the law stores what is left, a quarter of the energy.
    second = page.solution.collisions[1]
    assert second.approach_rate == pytest.approx(0.5 * struck.approach_rate, rel=1e-11)
    system = page.solution.system
    q = np.zeros((1, len(page.solution.mechanism.joints)))
    q[0, page.solution.mechanism.stop("gap").index] = x
    assert system.spring_energy(q)[0] == pytest.approx(k * x**2 / 2.0 + h * x**4 / 4.0, rel=4 * EPS)


def test_a_drive_law(monkeypatch: pytest.MonkeyPatch) -> None:
    """The gap of the flight is a cubic in each piece; its root is found by another program."""
    page = ran("a_drive_law", monkeypatch)
    turn = 0.1
    roots = np.roots([2.0, -2.0, -1.0 / 3.0, 5.0 / 54.0])
    (z,) = [root.real for root in roots if abs(root.imag) < 1e-9 and 0.0 < root.real < 0.5]
    landing = page.solution.collisions[0]
    assert landing.t == pytest.approx((1.0 + z) * turn, rel=1e-13)
    rate = GRAVITY * turn * (-1.0 / 3.0 - 4.0 * z + 6.0 * z**2)
    assert landing.approach_rate == pytest.approx(rate, rel=1e-12)
    # The box leaves where the cam's acceleration is -g, after a third of each turn.
    left = [event.t for event in page.solution.events if event.kind == "release"]
    np.testing.assert_allclose(left, [turn / 3.0, 4.0 * turn / 3.0], rtol=1e-13)


@pytest.mark.parametrize("tolerance", [1e-12, 1e-5])
def test_a_restitution_law(monkeypatch: pytest.MonkeyPatch, tolerance: float) -> None:
    """Rates by the recursion of their reciprocals, times by sums of flights, to the stated errors.

    With the constant e_0 the second rate would be 0.50 instead of 0.22.
    """
    page = ran("a_restitution_law", monkeypatch)
    resolution = nip.Resolution(tolerance=tolerance)
    case = nip.Case(speed_rpm=60.0, window=nip.Window.CYCLE, resolution=resolution)
    solution = nip.simulate(page.FALL.mechanism(), case)
    e_0, v_1 = 0.8, 0.5
    rates = [math.sqrt(2.0 * GRAVITY * 0.02)]
    times = [rates[0] / GRAVITY]
    while rates[-1] > 1e-17:
        rates.append(e_0 / (1.0 / rates[-1] + 1.0 / v_1))
        times.append(times[-1] + 2.0 * rates[-1] / GRAVITY)
    struck = solution.collisions
    assert len(struck) > 5
    # Rates of collisions after the end of the list are those of a rest.
    (rest,) = [event for event in solution.events if event.kind == "rest"]
    round_off = 64 * EPS * times[-1]
    for hit, t, rate in zip(struck, times, rates, strict=False):
        stated = solution.errors[hit.event.number - 1]
        assert abs(hit.t - t) <= stated.time + round_off
        assert abs(-hit.approach_rate / rate - 1.0) <= stated.impulse + 64 * EPS
        assert hit.separation_rate == pytest.approx(rate * e_0 / (1.0 + rate / v_1), rel=1e-9)
    stated = solution.errors[rest.number - 1]
    assert abs(rest.t - times[-1]) <= stated.time + round_off
    assert stated.time < 1e-2 * times[-1]


def test_what_is_stated_follows_the_slope_of_a_law(monkeypatch: pytest.MonkeyPatch) -> None:
    """d(rate after)/d(rate before) = -e_0 / (1 + v / v_1)^2, half of -e at v = v_1."""
    page = ran("a_restitution_law", monkeypatch)
    solution = page.solution
    stop = solution.mechanism.stop("gap")
    q, v = np.zeros(2), np.zeros(2)
    v[stop.index] = -0.5
    e, slope = stop.coefficient(-0.5), stop.rebound_slope(-0.5)
    assert (e, slope) == (pytest.approx(0.4), pytest.approx(0.2))
    matrix, pushes = impact_map(solution.system, q, v, [stop], [e], [slope])
    assert matrix[2 + stop.index, 2 + stop.index] == pytest.approx(-0.2, rel=1e-12)
    assert pushes[0, 2 + stop.index] == pytest.approx(-0.5 * 1.2, rel=1e-12)


def test_the_law_of_the_package_falls_to_its_value_at_speed() -> None:
    """e_fast + (e_0 - e_fast) / e at the scale; its slope by a difference."""
    law = Falling(fast=0.1, scale=2.0)
    assert law.coefficient(0.6, 0.0) == 0.6
    assert law.coefficient(0.6, 2.0) == pytest.approx(0.1 + 0.5 / math.e, rel=4 * EPS)
    step = 1e-5
    change = law.coefficient(0.6, 1.0 + step) - law.coefficient(0.6, 1.0 - step)
    assert law.slope(0.6, 1.0) == pytest.approx(change / (2.0 * step), rel=1e-9)


def test_a_stop(monkeypatch: pytest.MonkeyPatch) -> None:
    """A free fall of h = 20 mm - e (1 - cos phi); at coordinate zero it would take 63.9 ms."""
    page = ran("a_stop", monkeypatch)
    h = 0.020 - 0.005 * (1.0 - math.cos(math.radians(120.0)))
    struck = page.solution.collisions[0]
    assert struck.t == pytest.approx(math.sqrt(2.0 * h / GRAVITY), rel=16 * EPS)
    assert struck.approach_rate == pytest.approx(-math.sqrt(2.0 * h * GRAVITY), rel=16 * EPS)
    # The key is a number of the model like others: half a turn lifts the stop by 10 mm.
    lifted = changed(page.solution.mechanism, {"stops.height.adjusted.angle_deg": 180.0})
    assert lifted.stop("height").at == pytest.approx(0.010, rel=4 * EPS)


def test_a_stop_on_a_screw(monkeypatch: pytest.MonkeyPatch) -> None:
    """At zero_mm + pitch_mm * turns of a slide; a hinge is refused."""
    page = ran("a_stop", monkeypatch)
    urdf, data = page.FALL.sources()
    data["stops"]["height"]["adjusted"] = {
        "law": "screw", "pitch_mm": 1.5, "turns": 4.0, "zero_mm": 1.0,
    }  # fmt: skip
    machine = from_sources("fall", urdf, data, ".")
    assert machine.stop("height").at == pytest.approx(0.007, rel=4 * EPS)
    with pytest.raises(InputError, match="a screw adjusts no stop of a hinge"):
        ScrewStop(pitch_mm=1.0, turns=1.0).place("revolute")


def test_the_reduced_engine_is_not_used_with_a_law() -> None:
    """It has one restitution for all rates; the transition is found by the direct one."""
    e62 = nip.load("e62")
    jaw = {
        **e62.description["stops"]["jaw"],
        "restitution_law": {"law": "falling", "fast": 0.1, "scale": 1.0},
    }
    data = {**e62.description, "stops": {**e62.description["stops"], "jaw": jaw}}
    machine = from_sources("e62", e62.urdf, data, e62.mesh_folder)
    assert "constant restitutions, and stop 'jaw' has a law" in str(unfit(machine))
    plain, soft = (
        nip.simulate(each, nip.Case(speed_rpm=650.0)).collisions for each in (e62, machine)
    )
    assert soft[0].approach_rate == plain[0].approach_rate
    assert soft[0].separation_rate < plain[0].separation_rate


def test_commands_print_what_is_added(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """`check` and `simulate` name force elements with law and joint, and a law of a stop."""
    page = ran("a_restitution_law", monkeypatch)
    forces = {"gap": {"joint": "gap", "law": "orifice", "c_N_s2_per_m2": 0.125}}
    folder = nip.Drawing({**page.FALL.tables, "forces": forces}).save(tmp_path / "fall")
    for command in (["check", str(folder)], ["simulate", str(folder), "--window", "cycle"]):
        assert main([*command]) == 0
        text = capsys.readouterr().out
        assert "forces: gap (orifice) on gap\n" in text
    assert "gap 0.8 at rate 0, by a law" in " ".join(text.split())


def test_added_laws_are_checked_like_built_in_ones(monkeypatch: pytest.MonkeyPatch) -> None:
    """Misspelt keys, other joints and unknown laws are refused with what is known."""
    page = ran("a_force_element", monkeypatch)
    urdf, data = page.BUFFER.sources()
    force = data["forces"]["gap"]
    for change, words in (
        ({"k_N_per_mm": 1.0}, r"forces.gap.k_N_per_mm.*known here: h_N_per_m3, joint, k_N_per_m"),
        ({"law": "ruber"}, r"forces.gap.law = 'ruber'.*one of orifice, rubber"),
        ({"joint": "gop"}, r"gop.*gap"),
    ):
        changed = {**data, "forces": {"gap": {**force, **change}}}
        with pytest.raises((ModelError, InputError), match=words):
            from_sources("buffer", urdf, changed, ".")


def test_values_that_make_no_law_are_refused_by_its_name(monkeypatch: pytest.MonkeyPatch) -> None:
    """Unless the error names the key that is wrong."""
    page = ran("a_force_element", monkeypatch)

    class NoForce(page.RubberForce, frozen=True, kw_only=True, tag="none"):  # type: ignore[misc,name-defined]
        """Never a law."""

        def build(self, kind: str) -> Any:
            message = f"softer on a {kind} joint"
            raise InputError(message)

    page.register_force(NoForce)
    urdf, data = page.BUFFER.sources()
    data["forces"]["gap"]["law"] = "none"
    with pytest.raises(ModelError, match=r"forces\.gap\.law = 'none' .*: softer on a prismatic"):
        from_sources("buffer", urdf, data, ".")


def test_an_installed_extension_is_imported_when_its_law_is_met(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Once, and only for a law that is not known; one that fails names itself."""
    page = ran("a_force_element", monkeypatch)
    urdf, data = page.BUFFER.sources()
    loaded: list[str] = []

    def load() -> None:
        class LateForce(page.RubberForce, frozen=True, kw_only=True, tag="late"):  # type: ignore[misc,name-defined]
            """Registered by the extension."""

        page.register_force(LateForce)
        loaded.append("late")

    points = [SimpleNamespace(name="my_laws", value="my_laws", load=load)]
    monkeypatch.setattr(importlib.metadata, "entry_points", lambda **_: points)
    registers._import_extensions.cache_clear()
    page.BUFFER.mechanism()
    assert loaded == []
    data["forces"]["gap"]["law"] = "late"
    machine = from_sources("buffer", urdf, data, ".")
    assert (loaded, machine.forces[0].kind) == (["late"], "late")

    def broken() -> None:
        message = "no module named 'x'"
        raise ImportError(message)

    points[0].load = broken
    registers._import_extensions.cache_clear()
    data["forces"]["gap"]["law"] = "never"
    with pytest.raises(InputError, match=r"extension 'my_laws' \(my_laws\) cannot be imported"):
        from_sources("buffer", urdf, data, ".")
    registers._import_extensions.cache_clear()


@pytest.mark.parametrize("parts", [(30.0,), (6.0, 14.0, 10.0)])
def test_orifices_slow_a_box_down(parts: tuple[float, ...]) -> None:
    """v = v0 exp(-c s / m) after the way s, whatever the time; a linear damper gives v0 - c s / m.

    Heat and kinetic energy together stay what they were.
    """
    c, m, rate, way = sum(parts), 0.5, 2.0, 0.05
    forces = {
        f"hole_{number}": {"joint": "gap", "law": "orifice", "c_N_s2_per_m2": part}
        for number, part in enumerate(parts)
    }
    drawing = nip.Drawing({
        "title": "a box slowed down by an orifice", "speed_rpm": 600.0, "forces": forces,
        "points": {"O": [-100.0, 0.0], "B": [0.0, 0.0]},
        "bodies": {"shaft": {"points": "O", "mass_kg": 1.0}, "box": {"points": "B", "mass_kg": m}},
        "joints": [
            {"slide": "turning", "parent": "frame", "child": "shaft", "at": "O", "along": [0, 1]},
            {"slide": "gap", "parent": "frame", "child": "box", "at": "B", "along": [1, 0]},
        ],
        "drives": {"turning": {"joint": "turning", "law": "fourier", "mean_mm": 0.0}},
        "initial": {"gap": {"at_mm": 1e3 * way, "rate_mm_per_s": -1e3 * rate}},
        "stops": {"gap": {"joint": "gap", "restitution": 0.0}},
    })  # fmt: skip
    case = nip.Case(speed_rpm=600.0, window=nip.Window.CYCLE, cycles=2)
    solution = nip.simulate(drawing.mechanism(), case)
    struck = solution.collisions[0]
    assert struck.approach_rate == pytest.approx(-rate * math.exp(-c * way / m), rel=1e-11)
    assert struck.t == pytest.approx(m / (c * rate) * (math.exp(c * way / m) - 1.0), rel=1e-11)
    # The box stays where it strikes: all that it had has become heat.
    lost = struck.energy_lost + solution.energy.dissipated
    assert lost == pytest.approx(0.5 * m * rate**2, rel=1e-11)
