"""A run that is wrong is refused with status 1 and writes nothing; one that is right never is.

The runs are made wrong after they were computed, at one panel: a shift of one joint opens the
closures, and a factor on the velocities makes energy.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from driven_machines import LAWS, follower
from small_machines import link, machine, slide

from nipper_pin import (
    Case,
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
from nipper_pin.hybrid.result.self_check import need_sound
from nipper_pin.mechanism import with_numbers
from nipper_pin.view.run.export import export


def damaged(run: Solution, kind: str) -> Solution:
    segment = run.segments[0]
    panel = segment.panels[0]
    wrong = {
        "closures": lambda: replace(panel, q=panel.q + 1e-3 * (np.arange(panel.q.shape[1]) == 1)),
        "energy": lambda: replace(panel, v=1.3 * panel.v),
    }[kind]()
    first = replace(segment, panels=(wrong, *segment.panels[1:]))
    return replace(run, segments=(first, *run.segments[1:]))


@pytest.fixture(scope="module")
def run() -> Solution:
    return simulate(load("e62"), Case(speed_rpm=650.0))


@pytest.mark.parametrize(
    ("kind", "said"),
    [("closures", "the closures gape by"), ("energy", "the energy balance leaves over")],
)
def test_a_wrong_run_is_refused(
    run: Solution, kind: str, said: str, tmp_path: Path,
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch,
) -> None:  # fmt: skip
    wrong = damaged(run, kind)
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
