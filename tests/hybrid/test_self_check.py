# ruff: noqa: ARG002
"""Energy balances; runs that are wrong, and laws of users that make energy, are refused."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import pytest
from driven_machines import LAWS, follower
from small_machines import link, machine, slide

import nipper_pin as nip
from nipper_pin.arrays import FloatArray
from nipper_pin.cli import main
from nipper_pin.cli import simulate as command
from nipper_pin.hybrid import need_sound
from nipper_pin.hybrid.result.energy_balance import energy_balance
from nipper_pin.mechanism import changed
from nipper_pin.mechanism.files.register import FORCES, RESTITUTIONS
from nipper_pin.mechanism.forces import ForceTable
from nipper_pin.mechanism.restitution import RestitutionTable
from nipper_pin.view.run.export import export

RUNS = [(window, drive) for window in nip.Window for drive in nip.DriveMode]


@pytest.fixture(scope="module", params=RUNS, ids=lambda run: "-".join(run))
def run(request: pytest.FixtureRequest) -> nip.Solution:
    """Both windows with both kinds of drives."""
    window, drive = request.param
    return nip.simulate(nip.load("e62"), nip.Case(speed_rpm=650.0, window=window, drive=drive))


def test_balance_closes(run: nip.Solution) -> None:
    """The residual is below 1e-9 of the largest kinetic energy.

    Work comes from multipliers, energies from states, losses from impulses: three computations that
    share no formula. States are exact to 1e-12 and the quadrature beyond that.
    """
    assert run.energy.relative <= 1e-9
    assert run.checks.energy_balance == run.energy.relative
    assert run.energy.impact_losses > 0.3
    assert run.energy.kinetic_peak > 1.0
    # A thousandth of one collision's loss added to it opens the balance by just that.
    events = list(run.events)
    number = int(np.argmax([event.energy_lost for event in events]))
    change = 1e-3 * events[number].energy_lost
    events[number] = replace(events[number], energy_lost=events[number].energy_lost + change)
    changed = energy_balance(run.system, run.segments, events)
    assert changed.residual == pytest.approx(run.energy.residual - change, rel=1e-6)
    assert changed.relative > 1e-8


def test_a_whole_turn_takes_no_gravity_work_and_stores_nothing() -> None:
    """After one turn with held drives the machine is where it was: only losses remain.

    The initial phase is kinematic, so its state depends on the cylinder angle alone.
    """
    case = nip.Case(speed_rpm=450.0, window=nip.Window.CYCLE)
    energy = nip.simulate(nip.load("e62"), case).energy
    for part in (energy.gravity_work, energy.spring_change, energy.kinetic_change):
        assert abs(part) <= 1e-12 * energy.kinetic_peak
    supplied = energy.drive_work + energy.drive_impulse_work
    assert supplied == pytest.approx(energy.impact_losses, rel=1e-11)


def damaged(sound: nip.Solution, kind: str) -> nip.Solution:
    """At one panel: one joint is shifted, which opens the closures, or velocities are larger."""
    segment = sound.segments[0]
    panel = segment.panels[0]
    wrong = {
        "closures": lambda: replace(panel, q=panel.q + 1e-3 * (np.arange(panel.q.shape[1]) == 1)),
        "energy": lambda: replace(panel, v=1.3 * panel.v),
    }[kind]()
    first = replace(segment, panels=(wrong, *segment.panels[1:]))
    return replace(sound, segments=(first, *sound.segments[1:]))


@pytest.fixture(scope="module")
def sound() -> nip.Solution:
    return nip.simulate(nip.load("e62"), nip.Case(speed_rpm=650.0))


@pytest.mark.parametrize(
    ("kind", "said"),
    [("closures", "the closures gape by"), ("energy", "the energy balance leaves over")],
)
def test_a_wrong_run_is_refused(
    sound: nip.Solution, kind: str, said: str, tmp_path: Path,
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch,
) -> None:  # fmt: skip
    wrong = damaged(sound, kind)
    with pytest.raises(nip.SelfCheckError, match=said) as refused:
        nip.record(wrong)
    assert not refused.value.evidence["residual"] <= refused.value.evidence["tolerance"]
    with pytest.raises(nip.SelfCheckError, match=said):
        export(wrong, tmp_path / "run")
    saved = nip.save(wrong, tmp_path / "run.npz")
    page = tmp_path / "page.html"
    assert main(["view", "--solution", str(saved), "--html", str(page)]) == 1
    monkeypatch.setattr(command, "simulate", lambda *_: wrong)
    words = ["simulate", "e62", "--speed", "650", "--out", str(tmp_path / "out")]
    assert main(words) == 1
    out, err = capsys.readouterr()
    assert out == ""
    assert err.count("nipper-pin: this run fails its own check") == 2
    assert err.count("\n") == 2
    assert [item.name for item in tmp_path.iterdir()] == ["run.npz"]


@pytest.mark.parametrize("tolerance", [1e-3, 1e-12])
@pytest.mark.parametrize("drive", ["held", "inertial"])
def test_right_runs_pass(tolerance: float, drive: str) -> None:
    """Also where the motion is resolved as badly as may be asked for."""
    for name in ("e62", "hanging_pendulum"):
        case = nip.Case(
            speed_rpm=450.0,
            window="cycle",
            drive=drive,
            resolution=nip.Resolution(tolerance=tolerance),
        )
        need_sound(nip.simulate(nip.load(name), case))


@pytest.mark.parametrize("gravity", [1e-6, 1e-12, 1e-20])
@pytest.mark.parametrize("speed", [60.0, 1e-3])
@pytest.mark.parametrize("weighs", ["ball", "follower"])
def test_round_off_of_what_springs_and_weights_hold_is_no_error(
    weighs: str, speed: float, gravity: float
) -> None:
    """A ball falls by next to nothing of its height, and a cam lifts a follower as slowly."""
    if weighs == "ball":
        floor = {"joint": "z", "restitution": 0.5}
        parts = [link("ball"), slide("z", "frame", "ball", (0.0, 1.0))]
        start = {"z": {"at_mm": 1000.0}}
        mechanism = machine(parts, 1, gravity=gravity, stops={"floor": floor}, initial=start)
    else:
        mechanism = changed(follower(LAWS["Fourier"]), {"gravity_m_s2": gravity})
    need_sound(nip.simulate(mechanism, nip.Case(speed_rpm=speed, window=nip.Window.CYCLE)))


RETURNED: dict[str, Any] = {
    "gains": 1.17,
    "gains a little": 1.0 + 1e-9,
    "negative": -0.1,
    "no number": math.nan,
    "nothing": None,
    "text": "0.5",
    "whole": 1,
    "numpy": np.float64(0.5),
    "zero": 0.0,
}

GOOD = ("whole", "numpy", "zero")


@dataclass(frozen=True, kw_only=True)
class Returning:
    """A coefficient of any kind."""

    name: str

    def coefficient(self, e_0: float, rate: float) -> Any:
        return RETURNED[self.name]

    def slope(self, e_0: float, rate: float) -> float:
        return 0.0


class ReturningRestitution(RestitutionTable, frozen=True, kw_only=True, tag="returning"):
    """A restitution of any kind."""

    name: str

    def build(self, kind: str) -> Returning:
        return Returning(name=self.name)


@dataclass(frozen=True, kw_only=True)
class Rubbing:
    """Force c x_dot and as much heat, from some rate on with the wrong sign."""

    c: float
    knots: ClassVar[tuple[float, ...]] = ()

    def force(self, x: FloatArray, rate: FloatArray) -> FloatArray:
        return self.c * rate

    def energy(self, x: FloatArray) -> FloatArray:
        return np.zeros_like(x)

    def heat(self, x: FloatArray, rate: FloatArray) -> FloatArray:
        return self.c * rate**2


class RubbingForce(ForceTable, frozen=True, kw_only=True, tag="rubbing"):
    """A damper of any sign."""

    c: float

    def build(self, kind: str) -> Rubbing:
        return Rubbing(c=self.c)


@pytest.fixture(autouse=True)
def registered(monkeypatch: pytest.MonkeyPatch) -> None:
    """The laws are known in these tests alone."""
    for register, table in ((RESTITUTIONS, ReturningRestitution), (FORCES, RubbingForce)):
        monkeypatch.setattr(register, "_added", dict(register._added))
        register.add(table)


def falling(**tables: Any) -> Any:
    """A ball that falls from 0.2 m; it strikes the floor at sqrt(2 g h) = 1.98 m/s."""
    parts = [link("ball"), slide("height", "frame", "ball", (0.0, 1.0))]
    stop = {"joint": "height", "restitution": 0.5, **tables.pop("stop", {})}
    return machine(
        parts,
        1,
        gravity=9.81,
        stops={"floor": stop},
        initial={"height": {"at_mm": 200.0}},
        **tables,
    )


CASE = nip.Case(speed_rpm=60.0, window="cycle", rest_rate=0.1)


@pytest.mark.parametrize("name", RETURNED)
def test_a_coefficient_is_a_number_from_zero_to_one(name: str) -> None:
    """Any other one is refused where it is met."""
    ball = falling(stop={"restitution_law": {"law": "returning", "name": name}})
    if name in GOOD:
        first = nip.simulate(ball, CASE).collisions[0]
        assert first.separation_rate == pytest.approx(-float(RETURNED[name]) * first.approach_rate)
        return
    with pytest.raises(nip.ImpactError) as caught:
        nip.simulate(ball, CASE)
    message = caught.value.message
    assert "Returning of stop 'floor'" in message
    assert f"returns {RETURNED[name]!r}" in message
    assert f"after t = {math.sqrt(2 * 0.2 / 9.81):.6g} s" in message
    assert caught.value.evidence["rate"] == pytest.approx(math.sqrt(2 * 9.81 * 0.2))


def test_heat_below_zero_is_refused_while_it_runs() -> None:
    ball = falling(forces={"rub": {"law": "rubbing", "joint": "height", "c": -0.25}})
    with pytest.raises(nip.ElementError) as caught:
        nip.simulate(ball, CASE)
    message, evidence = caught.value.message, caught.value.evidence
    assert "force rub (Rubbing, law 'rubbing')" in message
    assert f"its heat is {evidence['heat']:.6g} W" in message
    # v = (m g / c) (exp(c t / m) - 1) with c = 0.25 N s/m, downwards.
    rate = 9.81 / 0.25 * math.expm1(0.25 * evidence["t"])
    assert evidence["heat"] == pytest.approx(-0.25 * rate**2, rel=1e-6)
    # Where it is none by round-off it is taken.
    ball = falling(forces={"rub": {"law": "rubbing", "joint": "height", "c": 0.25}})
    assert abs(nip.simulate(ball, CASE).energy.residual) < 1e-9
