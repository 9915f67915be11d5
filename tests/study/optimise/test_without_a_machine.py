"""Designs that are no machine, or break a limit: what is said of them, and advised."""

from __future__ import annotations

from pathlib import Path

import pytest
from designs import MASS, parameter, problem, study

from nipper_pin import InfeasibleError, SimulationError
from nipper_pin.cli import main
from nipper_pin.study.optimise import optimise, read_problem

FALLING = Path(__file__).resolve().parents[2] / "strangers" / "ball_e05"
E_N, WEIGHT = "stops.table.restitution", "links.mass.mass_kg"


def text(model: Path, body: str, **bounds: tuple[float, float]) -> str:
    return f'model = "{model}"\n{body}\n' + "".join(
        parameter(path, *ends) for path, ends in bounds.items()
    )


@pytest.mark.parametrize(
    ("model", "bounds", "advice"),
    [
        # Nothing approaches the floor in the touch configuration, whatever the numbers.
        (FALLING, {"stops.floor.restitution": (0.1, 0.9)}, "the model as it is: stop 'floor' is"),
        # No mass is negative, but that of the model itself is not.
        (MASS, {WEIGHT: (-2.0, -1.0)}, "the model as it is can: put its numbers within the bounds"),
    ],
)
def test_advice_where_no_sample_is_a_machine(
    model: Path, bounds: dict[str, tuple[float, float]], advice: str, tmp_path: Path
) -> None:
    found = problem(tmp_path, text(model, 'minimise = "duration_s"', **bounds))
    with pytest.raises(SimulationError, match=advice) as caught:
        optimise(found, starts=1, check=False, workers=1)
    assert "narrow" not in caught.value.message


def test_reasons_that_differ_in_numbers_are_told_once(tmp_path: Path) -> None:
    """Each sample below zero has another mass, and all of them the same reason."""
    body = text(MASS, 'minimise = "duration_s"', **{E_N: (0.1, 0.5), WEIGHT: (-1.0, 1.0)})
    found = optimise(problem(tmp_path, body), starts=1, check=False, workers=1)
    (reason,) = found.no_machine
    assert "mass" in reason


def test_the_bound_that_is_in_the_way_is_named(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """No rebound is a metre high, and the highest is that of the largest restitution.

    A limit that is kept is not told.
    """
    body = (
        'minimise = "duration_s"\n'
        "limits = { rebound_amplitude_1 = { low = 1.0 }, duration_s = { high = 10.0 } }"
    )
    file = study(tmp_path, text(MASS, body, **{E_N: (0.1, 0.5)}))
    with pytest.raises(InfeasibleError) as caught:
        optimise(read_problem(file), starts=1, check=False, workers=1)
    (broken,) = caught.value.evidence["limits"]  # type: ignore[misc]
    assert broken == {
        "limit": "rebound_amplitude_1 >= 1", "reached": broken["reached"],
        "missed_by": pytest.approx(1.0 - broken["reached"]), "can_be_met_alone": False,
        "missed_by_alone": pytest.approx(broken["missed_by"], rel=1e-3),
    }  # fmt: skip
    # Half of the table's 1.5 m/s is thrown up by v^2 / 2 g.
    assert broken["reached"] == pytest.approx(0.75**2 / (2.0 * 9.81), rel=1e-6)
    assert caught.value.evidence["numbers"] == {E_N: pytest.approx(0.5)}
    command = ["optimise", str(file), "--out", str(tmp_path / "out"), "--workers", "1"]
    assert main([*command, "--starts", "1", "--no-check"]) == 1
    advice = f"Relax these limits, or widen the bound {E_N} <= 0.5\n"
    said = capsys.readouterr().err
    assert said.endswith(advice)
    assert "breaks rebound_amplitude_1 >= 1: " in said
    assert "duration_s <= 10" not in said
