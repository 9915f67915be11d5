"""Optimisation: closed-form optima come out, with their prices; what cannot be had is refused.

The machine of most tests is a bouncing mass (tests/verification): a table that rises at V m/s hits
it, and the first rebound and the transition are

    A = (e V)^2 / (2 g),    T = 2 e V / (g (1 - e)).

With u = e V, a least rebound A fixes u = sqrt(2 g A), and T = 2 u / (g (1 - e)) is least for the
least e, that is for the fastest table: e = u / V. So an optimum of T under A >= A_0 has one active
limit, one active bound, and both prices in closed form. The search knows none of this: it sees
transitions of an engine that finds impacts by root search.
"""

from __future__ import annotations

import contextlib
import io
import json
import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import designs
import numpy as np
import pytest
from designs import MASS, parameter

from nipper_pin import Case, InfeasibleError, load, simulate
from nipper_pin.cli import main
from nipper_pin.study.optimise import Limit, Optimum, Problem, optimise
from nipper_pin.study.optimise.design import design
from nipper_pin.study.optimise.points import Evaluator
from nipper_pin.study.optimise.search import descend as descending
from nipper_pin.study.optimise.search.binding import account
from nipper_pin.study.optimise.search.trace import Scales

GRAVITY = 9.81
E_N, LEAD = "stops.table.restitution", "drives.table.lead_mm_per_turn"
BOUNCES = parameter(E_N, 0.05, 0.5) + parameter(LEAD, 20.0, 100.0)


def asked(body: str, model: str | Path = MASS) -> str:
    """The text of a problem; with a cylinder at 60 r/min a lead of v metres is v m/s."""
    speed = 60.0 if model == MASS else 650.0
    return f'model = "{model}"\ncase = {{ speed_rpm = {speed} }}\n{body}'


def problem(folder: Path, body: str, model: str | Path = MASS) -> Problem:
    return designs.problem(folder, asked(body, model))


def quick(found: Problem, **settings: Any) -> Optimum:
    return optimise(found, **{"starts": 3, "check": False, "workers": 1, **settings})


def rest(u: float, v: float) -> float:
    return 2.0 * u / (GRAVITY * (1.0 - u / v))


LEAST = 2e-5
AT_LEAST = (
    'minimise = "duration_s"\n' + BOUNCES + f"[limits]\nrebound_amplitude_1 = {{ low = {LEAST} }}\n"
)


# --- optima that are known -----------------------------------------------------------------------


def test_constrained_optimum_and_its_prices_are_those_of_the_formulas(tmp_path: Path) -> None:
    """T is least at e = u / V_max; its prices are dT/dA and dT/dV there.

    The optimum is a corner of one limit and one bound, so it is as exact as the limit is kept: 1e-6
    of the limit's scale, which is at most the largest A, 1.3e-4 m, and so 7e-6 of this A; half of
    it in u. At a bound the aim has a slope, and a step that changes it by less than 1e-12 ends the
    search: 1e-6 of V is generous. Prices carry the truncation of central differences, below 1e-5.
    Either active thing missed would leave the start or the other bound, where T is more than twice
    as long.
    """
    found = quick(problem(tmp_path, AT_LEAST + "duration_s = { high = 1.0 }\n"))
    u = math.sqrt(2.0 * GRAVITY * LEAST)
    numbers = found.best.numbers
    assert numbers[LEAD] == pytest.approx(100.0, rel=1e-6)
    assert numbers[E_N] == pytest.approx(u / 0.1, rel=1e-5)
    assert found.best.values["duration_s"] == pytest.approx(rest(u, 0.1), rel=2e-5)
    assert found.before is not None
    assert found.before.values["duration_s"] > 2.0 * rest(u, 0.1)
    active = {item.name: item.price for item in found.account.bindings if item.active}
    assert set(active) == {f"rebound_amplitude_1 >= {LEAST:g}", f"{LEAD} <= 100"}
    assert found.best.holding == tuple(active)
    (loose,) = (item for item in found.account.bindings if not item.active)
    assert (loose.name, loose.price) == ("duration_s <= 1", 0.0)
    assert loose.slack == pytest.approx(1.0 - rest(u, 0.1))
    by_u = 2.0 / (GRAVITY * (1.0 - u / 0.1) ** 2)
    assert active[f"rebound_amplitude_1 >= {LEAST:g}"] == pytest.approx(
        by_u * GRAVITY / u, rel=1e-4
    )
    by_v = 2.0 * u**2 / (GRAVITY * (0.1 - u) ** 2)
    # The file has the lead in mm.
    assert active[f"{LEAD} <= 100"] == pytest.approx(1e-3 * by_v, rel=1e-4)
    assert found.account.residual < 1e-9


@pytest.mark.slow
def test_what_is_maximised_comes_out_with_its_own_sign(tmp_path: Path) -> None:
    """Largest A under T <= T_0: u = g T_0 (1 - e) / 2 falls with e, so V is at its bound again.

    There u = e V, and so e = c / (V + c) with c = g T_0 / 2. Tolerances as above. Half of the range
    of the mass is below zero: those samples are counted, with their reason, and no rebound of a
    ball depends on its mass.
    """
    body = 'maximise = "rebound_amplitude_1"\n' + BOUNCES
    body += parameter("links.mass.mass_kg", -1.0, 1.0)
    found = quick(problem(tmp_path, body + "[limits]\nduration_s = { high = 0.01 }\n"))
    c = GRAVITY * 0.01 / 2.0
    e = c / (0.1 + c)
    assert found.best.numbers[E_N] == pytest.approx(e, rel=1e-5)
    assert found.best.numbers["links.mass.mass_kg"] > 0.0
    highest = (0.1 * e) ** 2 / (2.0 * GRAVITY)
    assert found.best.values["rebound_amplitude_1"] == pytest.approx(highest, rel=2e-5)
    assert found.no_machine
    assert all("mass" in why for why in found.no_machine)


@pytest.mark.slow
def test_front_is_the_curve_of_the_formulas(tmp_path: Path) -> None:
    """Shortest T for every A: T = 2 u / (g (1 - u / V_max)), from e = 0.05 to e = 0.5.

    Each point is a descent of its own; evenly spaced limits on A, ends included. Weighted sums
    would find the two ends only: T is concave in A.
    """
    body = 'minimise = "duration_s"\nmaximise = "rebound_amplitude_1"\n'
    found = quick(problem(tmp_path, body + BOUNCES), points=6)
    heights = np.array([item.values["rebound_amplitude_1"] for item in found.front])
    ends = [(e * v) ** 2 / (2.0 * GRAVITY) for e, v in ((0.05, 0.02), (0.5, 0.1))]
    wanted = np.linspace(*ends, 6)
    # The last one stops a thousandth short of the end.
    wanted[-1] -= 1e-3 * (ends[1] - ends[0])
    np.testing.assert_allclose(heights, wanted, rtol=1e-4, atol=1e-9)
    for item in found.front[1:]:
        u = math.sqrt(2.0 * GRAVITY * item.values["rebound_amplitude_1"])
        assert item.values["duration_s"] == pytest.approx(rest(u, 0.1), rel=1e-4)


def test_aims_that_agree_have_a_front_of_one_point(tmp_path: Path) -> None:
    """A and T both grow with e and with V."""
    body = 'minimise = ["duration_s", "rebound_amplitude_1"]\n' + BOUNCES
    found = quick(problem(tmp_path, body))
    assert len(found.front) == 1
    assert found.best.numbers == {E_N: pytest.approx(0.05), LEAD: pytest.approx(20.0)}


def test_what_holds_a_design(tmp_path: Path) -> None:
    """A limit with less room than 1e-4 of its scale, and bounds nearer than 1e-4.

    Where nothing holds, nothing explains the slope of the aim: this is no optimum.
    """
    asked = problem(tmp_path, AT_LEAST)
    source = Evaluator(asked)

    def holding(z: tuple[float, float], room: float) -> tuple[str, ...]:
        """With a scale of which the limit's slack is this part."""
        slack = abs(source.at(np.array(z)).slacks[0])
        found = design(source, Scales(1e-2, (slack / room,)), z)
        assert found is not None
        return found.holding

    limit = f"rebound_amplitude_1 >= {LEAST:g}"
    assert holding((0.8, 0.8), 1.1e-4) == ()
    assert holding((0.8, 0.8), 0.9e-4) == (limit,)
    assert holding((0.5, 1.0 - 1.1e-4), 1.0) == ()
    assert holding((0.5, 1.0 - 0.9e-4), 1.0) == (f"{LEAD} <= 100",)
    assert holding((0.5, 1.1e-4), 1.0) == (limit,)
    # Broken ones, too, and several at once.
    assert holding((0.9e-4, 0.0), 1.0) == (limit, f"{E_N} >= 0.05", f"{LEAD} >= 20")
    assert account(asked, Scales(1e-2, (1e-5,)), (0.8, 0.8)).residual == pytest.approx(1.0)


# --- what may not disturb ------------------------------------------------------------------------


@pytest.mark.campaign
def test_same_seed_same_bits_whoever_computes(tmp_path: Path) -> None:
    """One process or two; another seed starts elsewhere."""
    found = problem(tmp_path, AT_LEAST)
    one = quick(found, check=True)
    two = quick(found, check=True, workers=2)
    assert two.best == one.best
    assert two.descents == one.descents
    assert two.check == one.check
    assert two.account == one.account
    elsewhere = quick(found, seed=2, check=True)
    assert [item.start for item in elsewhere.descents] != [item.start for item in one.descents]
    assert one.check is not None
    assert elsewhere.check is not None
    assert elsewhere.check.z != one.check.z
    assert elsewhere.best.numbers[E_N] == pytest.approx(one.best.numbers[E_N], rel=1e-5)


@pytest.mark.campaign
def test_global_check_finds_what_descents_miss(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Descents that do not move leave the optimum to differential evolution and its descent."""
    whole = descending.descend
    calls: list[tuple[float, ...]] = []

    def lazy(text: bytes, scales: Any, start: tuple[float, ...]) -> Any:
        calls.append(start)
        found = whole(text, scales, start)
        return found if len(calls) > 3 else replace(found, z=start, aim=1e3)

    monkeypatch.setattr("nipper_pin.study.optimise.search.stages.descend", lazy)
    result = quick(problem(tmp_path, AT_LEAST), check=True)
    u = math.sqrt(2.0 * GRAVITY * LEAST)
    assert len(calls) == 4
    assert result.check_gain > 0.0
    assert result.best.numbers[E_N] == pytest.approx(u / 0.1, rel=1e-5)


# --- what cannot be had --------------------------------------------------------------------------


@pytest.mark.slow
def test_limits_that_contradict_one_another_are_named_with_what_is_missing(tmp_path: Path) -> None:
    """The nearest design breaks both, and says so, and that each of them could be met alone.

    A rebound of 0.1 mm takes at least T = 2 u / (g (1 - u / V)), V = 0.1 m/s: 16 ms.
    """
    limits = "rebound_amplitude_1 = { low = 1e-4 }\nduration_s = { high = 0.01 }\n"
    body = 'minimise = "duration_s"\n' + BOUNCES + f"[limits]\n{limits}"
    with pytest.raises(InfeasibleError) as caught:
        quick(problem(tmp_path, body))
    one, two = caught.value.evidence["limits"]
    assert (one["limit"], two["limit"]) == ("rebound_amplitude_1 >= 0.0001", "duration_s <= 0.01")
    assert one["missed_by"] == pytest.approx(1e-4 - one["reached"])
    assert two["missed_by"] == pytest.approx(two["reached"] - 0.01)
    # The nearest design is on the curve of the fastest table.
    u = math.sqrt(2.0 * GRAVITY * one["reached"])
    assert two["reached"] == pytest.approx(rest(u, 0.1), rel=1e-4)
    assert one["can_be_met_alone"] is two["can_be_met_alone"] is True


def test_limits_that_starts_break_are_mended_first(tmp_path: Path) -> None:
    """A sliver of the box meets both limits, and no sample lies in it."""
    u = math.sqrt(2.0 * GRAVITY * 1e-4)
    limits = (
        Limit(quantity="rebound_amplitude_1", side="low", value=1e-4),
        Limit(quantity="duration_s", side="high", value=1.0001 * rest(u, 0.1)),
    )
    found = quick(replace(problem(tmp_path, AT_LEAST), limits=limits))
    assert found.best.inside
    assert found.best.values["duration_s"] == pytest.approx(rest(u, 0.1), rel=2e-5)


# --- the command and its files -------------------------------------------------------------------


class CtrlC(io.StringIO):
    """A terminal whose user interrupts the command at its first word."""

    def isatty(self) -> bool:
        return True

    def write(self, text: str) -> int:
        if not self.getvalue():
            super().write(text)
            raise KeyboardInterrupt
        return super().write(text)


def test_an_interrupt_leaves_what_was_there(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """No folder, or the one that was there; a search after it is a new one, and takes nothing.

    What that writes is a case and overrides of the same machine.
    """
    body = 'minimise = "duration_s"\n' + parameter(E_N, 0.05, 0.5)
    out, file = tmp_path / "out", designs.study(tmp_path, asked(body))
    words = ["optimise", str(file), "--out", str(out), "--workers", "1", "--starts", "1"]
    with contextlib.redirect_stderr(CtrlC()):
        assert main(words) == 130
    assert not out.exists()
    # As an earlier version kept finished parts.
    (out / "parts").mkdir(parents=True)
    (out / "problem.json").write_text('{"format": 1, "hash": "another"}')
    (out / "parts" / "first_0.json").write_text("[]")
    before = {path: path.read_bytes() for path in out.rglob("*.json")}
    with contextlib.redirect_stderr(CtrlC()):
        assert main(words) == 130
    assert {path: path.read_bytes() for path in out.rglob("*.json")} == before
    assert main([*words, "--no-check"]) == 0
    after = {path: path.read_bytes() for path in out.rglob("*.json")}
    assert {path: after.pop(path) for path in before} == before
    names = {"result.json", "overrides.json", "case.json"}
    assert {path.relative_to(out).as_posix() for path in after} == names
    optimum = json.loads((out / "result.json").read_text())["optimum"]["values"]
    capsys.readouterr()
    assert main(["simulate", "--case", str(out / "case.json"), "--json", "-"]) == 0
    case = json.loads(capsys.readouterr().out)
    overrides = json.loads((out / "overrides.json").read_text())
    single = simulate(load(MASS, overrides), Case(speed_rpm=60.0))
    for duration in (case["transition"]["duration_s"], single.transitions[0].duration):
        assert duration == pytest.approx(optimum["duration_s"], rel=1e-8)


# --- parts ---


def test_tables_and_single_runs_agree(tmp_path: Path) -> None:
    """A point by the reduced engine is the direct run of a model that is loaded with its numbers.

    Every kind of setting takes part, so a wrong unit or place would show in the first digits.
    """
    body = 'minimise = "rebound_amplitude_1"\n[set]\n"stops.steeve.restitution" = 0.1\n'
    body += parameter("preload", 8.0, 14.0) + parameter("stops.jaw.restitution", 0.1, 0.3)
    body += parameter("stiffness", 8000.0, 10000.0) + parameter("speed_rpm", 500.0, 700.0)
    # The speed of the file is where the parameter starts.
    source = Evaluator(problem(tmp_path, body, "e62"))
    z = np.array([0.2, 0.7, 0.4, 0.6])
    machine = load("e62", {"preload": 9.2, "restitution": 0.24, "stiffness": 8800.0})
    single = simulate(machine, Case(speed_rpm=620.0))
    height = single.collisions[0].rebound_amplitude
    assert source.at(z).engine == "reduced"
    assert source.at(z).values["rebound_amplitude_1"] == pytest.approx(height, rel=1e-8)
