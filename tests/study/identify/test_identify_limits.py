"""A fit at a bound of a range says so; one that breaks a limit is a failure."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from nipper_pin import Case, Window, load, simulate
from nipper_pin.cli import main

PRELOAD = "springs.steeve.preload_length_mm"
SPEED = 550.0


def problem(folder: Path, truth: float, bounds: tuple[float, float], limits: str = "") -> str:
    """Three rebounds of the E62 with another preload, known to a tenth of themselves."""
    hits = simulate(load("e62", {PRELOAD: truth}), Case(speed_rpm=SPEED)).collisions
    values = {"rebound_amplitude_1": hits[0].rebound_amplitude,
              "rebound_time_s_1": hits[0].rebound_time,
              "rebound_amplitude_2": hits[1].rebound_amplitude}  # fmt: skip
    lines = ["speed_rpm,quantity,value,sigma"]
    for name, value in values.items():
        assert value is not None
        lines.append(f"{SPEED},{name},{value!r},{0.1 * value!r}")
    (folder / "measured.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")
    file = folder / "fit.toml"
    file.write_text(
        'format = 1\ntitle = "t"\nmodel = "e62"\nmeasured = "measured.csv"\n'
        "absolute_sigma = false\n"
        f'[parameters."{PRELOAD}"]\nlow = {bounds[0]}\nhigh = {bounds[1]}\n{limits}',
        encoding="utf-8",
    )
    return str(file)


def run(file: str, capsys: pytest.CaptureFixture[str]) -> tuple[int, dict, str, str]:
    """Status, document, report and complaint."""
    target = Path(file).with_name("result.json")
    words = ["identify", file, "--starts", "1", "--profiles", "0", "--workers", "1"]
    status = main([*words, "--json", str(target)])
    out, err = capsys.readouterr()
    text = " ".join(out.split())
    return status, json.loads(target.read_text(encoding="utf-8")), text, err


@pytest.mark.slow
@pytest.mark.parametrize(("bounds", "side"), [((8.0, 12.0), "high"), ((10.9, 14.0), None)])
def test_a_number_at_its_bound_is_named(
    bounds: tuple[float, float], side: str | None, tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:  # fmt: skip
    status, document, report, _ = run(problem(tmp_path, 12.5, bounds), capsys)
    (found,) = document["parameters"]
    assert status == 0
    assert found["at_bound"] == side
    assert found["identified"] == pytest.approx(bounds[1] if side else 12.5, rel=1e-3)
    words = "bounds and not targets decide them: preload length of spring steeve (high)"
    assert (words in report) is (side == "high")


@pytest.mark.slow
def test_broken_limits_are_status_1_with_the_result(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The opening is that of a simulated turn, which no preload changes; limits half a degree off.

    The working cycle is sampled: 0.02 degrees are a thousandth of the opening.
    """
    mechanism = load("e62")
    turn = simulate(mechanism, Case(speed_rpm=SPEED, window=Window.CYCLE))
    stop = mechanism.stop(mechanism.transition_stop)
    q = turn.trajectory.evaluate(np.linspace(*turn.trajectory.span, 2000)).q
    widest = float(stop.gaps(q).max()) * 57.29577951308232
    for off, kept in ((-0.5, True), (0.5, False)):
        folder = tmp_path / str(kept)
        folder.mkdir()
        limit = f"[limits]\nat.speed_rpm = {SPEED}\njaw_opening_deg.low = {widest + off}\n"
        status, document, report, err = run(problem(folder, 11.5, (8.0, 14.0), limit), capsys)
        assert status == (0 if kept else 1)
        broken = document["broken_limits"]
        if kept:
            assert (broken, err) == ({}, "")
            assert "all limits are kept" in report
        else:
            assert broken == {"jaw_opening_deg": pytest.approx(-0.5, abs=0.02)}
            off_by = f"jaw_opening_deg by {broken['jaw_opening_deg']:+.3g}"
            assert f"LIMITS ARE BROKEN: {off_by}" in report
            assert err.startswith("nipper-pin: the fit breaks limits: jaw_opening_deg by -0.")
            assert err.count("\n") == 1
