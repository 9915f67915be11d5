"""What studies refuse while they compute, of machines for which it is so."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from nipper_pin import Case, InputError, Mechanism, Outcome, SimulationError, load, simulate
from nipper_pin.study.identify import Condition, Target, predict, working_cycle
from nipper_pin.study.optimise import Problem, read_problem
from nipper_pin.study.optimise.points import Evaluator
from tests.refusals.bases import BESIDE, model

AT, SINCE = Condition(650.0, 0.25), Condition(450.0)
STIFF = Condition(650.0, None, 9500.0)


def beside(name: str, folder: Path) -> Mechanism:
    """A model of the table of refusals."""
    base, edits = BESIDE[name]
    return load(model(base, edits, folder))


def target(name: str, quantity: str, **others: Any) -> Target:
    return Target(name=name, quantity=quantity, value=1.0, sigma=1.0, **{"at": AT, **others})


def test_targets_that_a_transition_has_not(e62: Mechanism) -> None:
    """Values, changes since another setting, and names of those that are missing.

    At 10 rad/s a transition ends with its first collision: there is no third rebound.
    """
    plain, change = target("a", "duration_s"), target("b", "duration_s", since=SINCE)
    machine = load("e62", {"stops.jaw.restitution": 0.25})
    new, old = (
        simulate(item, Case(speed_rpm=speed)).transitions[0].duration
        for item, speed in ((machine, 650.0), (e62, 450.0))
    )
    # Either is as accurate as it is asked for, or better.
    assert predict(e62, [plain, change], 1e-10, None) == pytest.approx(
        [new, (new - old) / old], rel=1e-9
    )
    none = [target("c", "rebound_amplitude_3"), plain,
            target("d", "rebound_amplitude_3", since=SINCE)]  # fmt: skip
    with pytest.raises(SimulationError, match="no value for c, d; leave these") as caught:
        predict(e62, none, 1e-6, 10.0)
    assert caught.value.evidence == {"targets": ["c", "d"]}


def test_transitions_without_rest(e62: Mechanism) -> None:
    """Named with the setting."""
    at = Condition(650.0, 1.0)
    with pytest.raises(SimulationError) as caught:
        predict(e62, [target("a", "duration_s", at=at)], 1e-6, None)
    assert caught.value.message == f"e62 at 650 r/min: {Outcome.NO_REST.value}"
    assert caught.value.evidence == {"condition": at._asdict()}


def test_stiffnesses_need_one_spring(e62: Mechanism, tmp_path: Path) -> None:
    aims = [target("a", "duration_s", at=STIFF)]
    changed = load("e62", {"springs.steeve.stiffness_N_per_m": 9500.0})
    plain = [target("a", "duration_s", at=Condition(650.0))]
    assert predict(e62, aims, 1e-8, None) == predict(changed, plain, 1e-8, None)
    with pytest.raises(InputError, match="e62 has 2 springs") as caught:
        predict(beside("two_springs", tmp_path), aims, 1e-8, None)
    assert sorted(caught.value.evidence["springs"]) == ["second", "steeve"]  # type: ignore[call-overload]


def test_working_cycles_of_models_without_one(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="timing and forces by kinematics need one") as caught:
        working_cycle(beside("third_phase", tmp_path), 650.0)
    assert caught.value.evidence == {"model": "e62", "initial": []}


def test_a_stop_that_does_not_open_again(tmp_path: Path) -> None:
    """Touched where the pendulum turns back, and drawn shut by a shaft that goes slowly round."""
    law, slow = 'law = "geared"\nof = "pendulum"\nratio = 2.2 ', 'law = "constant_speed"\n'
    base = model("e62", (law, f"{slow}ratio = 0.05 "), tmp_path)
    machine = load(base, {"cylinder.angle_at_touch_deg": 115.6})
    with pytest.raises(SimulationError, match="e62: the stop jaw does not open again") as caught:
        working_cycle(machine, 650.0)
    assert caught.value.evidence == {"stop": "jaw"}


def design(folder: Path, aim: str) -> Problem:
    file = folder / "design.toml"
    file.write_text(
        f'format = 1\nminimise = "{aim}"\n[case]\nspeed_rpm = 650.0\n[parameters.restitution]\n'
        "low = 0.0\nhigh = 1.0\n",
        encoding="utf-8",
    )
    return read_problem(file)


@pytest.mark.parametrize(
    ("aim", "restitution", "why"),
    [
        ("duration_s", 0.2, ""),
        ("duration_s", 1.0, Outcome.NO_REST.value),
        ("rest_index", 1.0, "the turn has no rest_index"),
        ("clamped_time_s", 1.0, ""),
    ],
)
def test_why_a_design_is_none(aim: str, restitution: float, why: str, tmp_path: Path) -> None:
    """It does not come to rest, or has not what is asked for; of nothing else is it missed."""
    point = Evaluator(design(tmp_path, aim)).at(np.array([restitution]))
    assert (point.why, point.usable, point.z.tolist()) == (why, not why, [restitution])
    if why:
        assert (point.values, point.owners, point.rows.size, point.engine) == ({}, (), 0, "")
    else:
        assert math.isfinite(point.values[aim])
