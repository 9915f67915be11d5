"""The energy of a run balances; a run that is wrong is refused with status 1 and writes nothing."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from driven_machines import LAWS, follower
from small_machines import link, machine, slide

from nipper_pin import (
    Case,
    DriveMode,
    Resolution,
    SelfCheckError,
    Solution,
    Window,
    load,
    record,
    save,
    simulate,
)
from nipper_pin.cli import main
from nipper_pin.cli import simulate as command
from nipper_pin.hybrid.result.energy_balance import energy_balance
from nipper_pin.hybrid.result.self_check import need_sound
from nipper_pin.mechanism import with_numbers
from nipper_pin.view.run.export import export

RUNS = [(window, drive) for window in Window for drive in DriveMode]


@pytest.fixture(scope="module", params=RUNS, ids=lambda run: "-".join(run))
def run(request: pytest.FixtureRequest) -> Solution:
    """Both windows with both kinds of drives."""
    window, drive = request.param
    return simulate(load("e62"), Case(speed_rpm=650.0, window=window, drive=drive))


def test_balance_closes(run: Solution) -> None:
    """The residual is below 1e-9 of the largest kinetic energy.

    Work comes from multipliers, energies from states, losses from impulses: three computations that
    share no formula. States are exact to 1e-12 and the quadrature beyond that.
    """
    assert run.energy.relative <= 1e-9
    assert run.checks.energy_balance == run.energy.relative
    assert run.energy.impact_losses > 0.3
    assert run.energy.kinetic_peak > 1.0


def test_balance_sees_a_wrong_loss(run: Solution) -> None:
    """A thousandth of one collision's loss added to it opens the balance by just that."""
    events = list(run.events)
    number = int(np.argmax([event.energy_lost for event in events]))
    change = 1e-3 * events[number].energy_lost
    events[number] = replace(events[number], energy_lost=events[number].energy_lost + change)
    changed = energy_balance(run.system, run.segments, events)
    assert changed.residual == pytest.approx(run.energy.residual - change, rel=1e-6)
    assert changed.relative > 1e-8


@pytest.mark.slow
def test_drive_work_is_the_integral_of_torque_times_rate(run: Solution) -> None:
    """The trapezoidal rule on dense reactions gives the drives' work, segment by segment.

    With 400 steps on a segment the rule is wrong by (length)^2 / (12 * 400^2) of the second
    derivative of the power, some 1e-5 of the work on a smooth stretch; 1e-3 is asked for.
    """
    work = largest = 0.0
    for segment in run.segments:
        times = np.linspace(segment.t_start, segment.t_end, 401)
        inner = times[1:-1]
        if not (np.diff(times) > 0.0).all():
            continue
        reactions = run.trajectory.reactions(inner)
        motion = run.trajectory.evaluate(inner)
        power = np.zeros(len(inner))
        for drive in run.mechanism.drives:
            power += reactions.drives[drive.name] * motion.v[:, drive.index]
        # The two end steps take the inner value next to them.
        part = float(np.trapezoid(power, inner)) + (power[0] + power[-1]) * (times[1] - times[0])
        work += part
        largest += abs(part)
    assert work == pytest.approx(run.energy.drive_work, abs=1e-3 * largest)


def test_a_whole_turn_takes_no_gravity_work_and_stores_nothing() -> None:
    """After one turn with held drives the machine is where it was: only losses remain.

    The initial phase is kinematic, so its state depends on the cylinder angle alone.
    """
    energy = simulate(load("e62"), Case(speed_rpm=450.0, window=Window.CYCLE)).energy
    for part in (energy.gravity_work, energy.spring_change, energy.kinetic_change):
        assert abs(part) <= 1e-12 * energy.kinetic_peak
    supplied = energy.drive_work + energy.drive_impulse_work
    assert supplied == pytest.approx(energy.impact_losses, rel=1e-11)


def damaged(sound: Solution, kind: str) -> Solution:
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
def sound() -> Solution:
    return simulate(load("e62"), Case(speed_rpm=650.0))


@pytest.mark.parametrize(
    ("kind", "said"),
    [("closures", "the closures gape by"), ("energy", "the energy balance leaves over")],
)
def test_a_wrong_run_is_refused(
    sound: Solution, kind: str, said: str, tmp_path: Path,
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch,
) -> None:  # fmt: skip
    wrong = damaged(sound, kind)
    with pytest.raises(SelfCheckError, match=said) as refused:
        record(wrong)
    assert not refused.value.evidence["residual"] <= refused.value.evidence["tolerance"]
    with pytest.raises(SelfCheckError, match=said):
        export(wrong, tmp_path / "run")
    saved = save(wrong, tmp_path / "run.npz")
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
        case = Case(
            speed_rpm=450.0, window="cycle", drive=drive, resolution=Resolution(tolerance=tolerance)
        )
        need_sound(simulate(load(name), case))


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
        mechanism = with_numbers(follower(LAWS["Fourier"]), {"gravity_m_s2": gravity})
    need_sound(simulate(mechanism, Case(speed_rpm=speed, window=Window.CYCLE)))
