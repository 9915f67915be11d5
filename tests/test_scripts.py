"""The example programs: each runs as the page says, and its numbers are those of another source."""

from __future__ import annotations

import json
import math
import os
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image
from scipy.optimize import brentq

import nipper_pin as nip

SCRIPTS = Path(__file__).resolve().parents[1] / "scripts"
CERTIFIED = json.loads((SCRIPTS.parent / "tests/reference/e62_transition.json").read_text())[
    "cases"
]
NUMBER = r"-?\d+(?:\.\d+)?(?:e[-+]?\d+)?"


def printed(name: str, folder: Path, *arguments: str) -> str:
    """What a program prints; it runs in a folder of its own, where it may write."""
    done = subprocess.run(
        [sys.executable, str(SCRIPTS / name), *arguments],
        cwd=folder, capture_output=True, text=True, check=False,
        env={**os.environ, "OPENBLAS_NUM_THREADS": "1"},
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return done.stdout


def numbers(pattern: str, text: str) -> list[list[float]]:
    """The numbers of all lines that a pattern fits; ``#`` in it stands for one."""
    found = re.findall(pattern.replace("#", f" *({NUMBER})"), text)
    return [[float(item) for item in (row if isinstance(row, tuple) else (row,))] for row in found]


def test_every_program_is_short_and_has_a_test() -> None:
    text = Path(__file__).read_text(encoding="utf-8")
    for file in SCRIPTS.glob("*.py"):
        assert f'"{file.name}"' in text
        assert len(file.read_text(encoding="utf-8").splitlines()) <= 60


def test_a_run_has_the_certified_collisions(tmp_path: Path) -> None:
    """As many digits as are printed, of the solution in 60-digit arithmetic."""
    text = printed("simulate_a_run.py", tmp_path)
    case = CERTIFIED["650"]
    found = numbers(r"collision \d+:# ms#", text)
    assert len(found) == 6
    for (time, rate), row in zip(found, case["collisions"], strict=False):
        assert time == pytest.approx(1e3 * float(row["time_s"]), abs=5e-6)
        assert rate == pytest.approx(float(row["approach_rate"]), abs=5e-6)
    assert f"at rest after {1e3 * float(case['rest_time_s']):.6f} ms" in text
    # The turn meets the jaw's first collision at the same index as the transition.
    assert f"phase 3: index {float(case['collisions'][0]['index']):6.3f}" in text


def bouncing_box(turns: int) -> list[tuple[float, float]]:
    """Landings of a box on a table that moves as a sine: time [s] and speed against it [m/s].

    Take-off where the table falls with g, free flight, root of the gap, Newton's restitution; the
    box stays on the table when the flights have become shorter than can be told.
    """
    amplitude, omega, g, e = 4e-3, 2.0 * math.pi * 10.0, 9.81, 0.3
    period = 2.0 * math.pi / omega

    def table(t: float) -> float:
        return -amplitude * math.cos(omega * t)

    def rate(t: float) -> float:
        return amplitude * omega * math.sin(omega * t)

    landings = []
    for turn in range(turns):
        start = turn * period + (math.pi / 2.0 + math.asin(g / (amplitude * omega**2))) / omega
        up = rate(start)
        while True:
            height, begin = table(start), start

            def gap(
                t: float, begin: float = begin, height: float = height, up: float = up
            ) -> float:
                return height + up * (t - begin) - 0.5 * g * (t - begin) ** 2 - table(t)

            step = 1e-4 if not landings or start > landings[-1][0] else 1e-2 * landings[-1][1] / g
            low = begin + step
            while gap(low + step) > 0.0:
                low += step
            start = float(brentq(gap, low, low + step, xtol=1e-15))
            speed = rate(start) - (up - g * (start - begin))
            landings.append((start, speed))
            up = rate(start) + e * speed
            if speed < 1e-3 or start > turns * period:
                break
    return [item for item in landings if item[0] < turns * period]


def test_an_own_machine_bounces_as_a_free_box_does(tmp_path: Path) -> None:
    """The first landings of two turns, against parabolas over a sine."""
    text = printed("build_a_machine.py", tmp_path, "shaker")
    found = numbers(r"# ms: it lands with# m/s", text)
    for time, speed in bouncing_box(2):
        nearest = min(found, key=lambda row: abs(1e-3 * row[0] - time))
        assert nearest == pytest.approx([1e3 * time, speed], abs=1e-5)
    assert nip.load(tmp_path / "shaker").title == "loose box on a shaking table"


@pytest.mark.campaign
def test_a_sweep_agrees_with_simulated_turns(tmp_path: Path) -> None:
    """The settings that it prints, as whole turns of the engine that the sweep does not use.

    They are printed with six digits, which moves a duration by some 1e-5 of it.
    """
    text = printed("sweep_the_spring.py", tmp_path)
    pattern = "transition:# ms with speed_rpm=#, restitution=#, stiffness=#, preload=#"
    rows = numbers(pattern, text)
    assert len(rows) == 2
    for duration, speed, restitution, stiffness, preload in rows:
        machine = nip.load("e62", {
            "stops.jaw.restitution": restitution,
            "springs.steeve.stiffness_N_per_m": stiffness,
            "springs.steeve.preload_length_mm": preload,
        })  # fmt: skip
        case = nip.Case(speed_rpm=speed, window=nip.Window.CYCLE, cycles=2)
        turns = nip.simulate(machine, case).transitions
        assert duration == pytest.approx(1e3 * turns[-1].duration, rel=1e-4)
    ((tenth, median, ninth),) = numbers("over after#,# and# ms", text)
    assert rows[1][0] < tenth < median < ninth < rows[0][0]


@pytest.mark.campaign
def test_a_sweep_with_dask_agrees_with_the_reduced_engine(tmp_path: Path) -> None:
    """Rebounds at one speed of its rows, which every fourth machine shows to be right."""
    text = printed("sweep_with_dask.py", tmp_path)
    ((mean, largest, machines),) = numbers(
        r"400\.0 r/min: first rebound# deg .*,# deg .* of#", text
    )
    rows = nip.read_sweep(tmp_path / "out" / "sweep_eccentric").table.to_pydict()
    names = [name for name in rows if name.startswith(("points.", "drives."))]
    assert len(names) == 3
    here = np.flatnonzero(np.array(rows["speed_rpm"]) == 400.0)
    rebounds = np.degrees(np.array(rows["rebound_amplitude_1"])[here])
    assert machines == len(rebounds) == 36
    assert (mean, largest) == pytest.approx((np.mean(rebounds), max(rebounds)), abs=1e-6)
    # By the engine that this sweep does not use.
    for row, rebound in zip(here[::4], rebounds[::4], strict=True):
        changes: dict[str, Any] = {name: rows[name][row] for name in names}
        machine = nip.load("e62", {"stops.jaw.restitution": 0.15, **changes})
        table = nip.transition_table(machine, speed_rpm=400.0, engine="reduced")
        (found,) = table.to_frame("pandas")["rebound_amplitude_1"]
        assert math.degrees(found) == pytest.approx(rebound, abs=1e-6)


@pytest.mark.campaign
def test_an_identification_finds_the_machine_that_was_filmed(tmp_path: Path) -> None:
    """The numbers of which the measurements were made, within four stated deviations."""
    truth = {
        "stops.jaw.restitution": 0.235,
        "springs.steeve.preload_length_mm": 9.4,
        "cylinder.angle_at_touch_deg": 168.0,
    }
    text = printed("identify_a_machine.py", tmp_path)
    for path, value in truth.items():
        ((found, deviation),) = numbers(rf"{re.escape(path)}:# \+-#", text)
        assert abs(found - value) < 4.0 * deviation < 0.02 * value
    ((rebound,),) = numbers("not measured:# ms", text)
    hit = nip.simulate(nip.load("e62", truth), nip.Case(speed_rpm=400.0)).collisions[0]
    assert hit.rebound_time is not None
    assert rebound == pytest.approx(1e3 * hit.rebound_time, rel=0.01)


@pytest.mark.campaign
def test_a_film_has_pictures_and_the_certified_losses(tmp_path: Path) -> None:
    text = printed("film_a_run.py", tmp_path, "film.gif")
    case = CERTIFIED["650"]
    for number, time, share in numbers(r"impact# at# ms takes# %", text):
        row = case["collisions"][int(number) - 1]
        lost = float(row["energy_lost_J"]) / float(case["energy_lost_total_J"])
        assert (time, share) == pytest.approx((1e3 * float(row["time_s"]), 100.0 * lost), abs=6e-5)
    with Image.open(tmp_path / "film.gif") as film:
        shown = set()
        for frame in range(film.n_frames):
            film.seek(frame)
            shown.add(film.convert("RGB").tobytes())
    # Time stands almost still around six impacts, ten pictures a second: each picture is another.
    assert len(shown) > 50


@pytest.mark.campaign
def test_an_optimum_is_what_the_direct_engine_simulates(tmp_path: Path) -> None:
    """The design that is printed, and the model as it is, by runs that no search made."""
    text = printed("optimise_a_design.py", tmp_path)
    assert text.endswith("simulated turns confirm the design\n")
    found = dict(re.findall(rf"(\S+) = ({NUMBER})", text))
    assert len(found) == 3
    before, best = numbers("first rebound# deg, clamping force# N", text)
    for (rebound, force), changes in ((before, {}), (best, found)):
        machine = nip.load("e62", {path: float(value) for path, value in changes.items()})
        hit = nip.simulate(machine, nip.Case(speed_rpm=650.0)).collisions[0]
        # The design is printed with six digits.
        assert rebound == pytest.approx(math.degrees(hit.rebound_amplitude or 0.0), rel=1e-4)
        assert 80.0 <= force <= 105.0
    # A limit of clamping force binds, since calm costs force.
    assert best[0] < 0.6 * before[0]
    assert best[1] == pytest.approx(105.0, abs=1e-3)


def test_the_notebook_runs_cell_by_cell(monkeypatch: pytest.MonkeyPatch) -> None:
    """All cells in their order in one namespace, with the certified durations in the end."""
    monkeypatch.setenv("MPLBACKEND", "Agg")
    import matplotlib.pyplot as plt

    plt.switch_backend("Agg")
    names: dict[str, Any] = {}
    document = json.loads((SCRIPTS / "first_steps.ipynb").read_text(encoding="utf-8"))
    assert document["nbformat"] == 4
    for number, cell in enumerate(document["cells"], start=1):
        if cell["cell_type"] == "code":
            exec(compile("".join(cell["source"]), f"cell {number}", "exec"), names)
    (angle,) = (axes.lines[0].get_ydata() for axes in plt.figure(1).axes)
    plt.close("all")
    for key, case in {"650": names["solution"], "650_e0.05": names["calm"]}.items():
        certified = float(CERTIFIED[key]["rest_time_s"])
        assert case.transitions[0].duration == pytest.approx(certified, abs=2e-15)
    table = names["table"]
    for speed in ("450", "550", "650"):
        (duration,) = table.duration[table.speed_rpm == float(speed)]
        assert duration == pytest.approx(float(CERTIFIED[speed]["rest_time_s"]), rel=1e-9)
    amplitude = math.degrees(float(CERTIFIED["650"]["collisions"][0]["rebound_amplitude"]))
    assert max(angle) == pytest.approx(amplitude, rel=1e-4)  # drawn at 400 times
