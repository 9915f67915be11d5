"""Random linkages: closed all around, the same for a seed, of every kind of dyad."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from benchmarks.stress import run_campaign, trial
from benchmarks.stress.linkages import random_linkage, write_linkage
from benchmarks.stress.linkages.dyads import KINDS, Growing, add_dyad, crank
from benchmarks.stress.linkages.motion import (
    ANGLES,
    NoAssemblyError,
)
from nipper_pin import Case, UnknownNameError, load, simulate
from nipper_pin.mechanism.drawing import Drawing, Drive, drawn_mechanism

COUNT = 40


@pytest.fixture(scope="module")
def linkages() -> list[Drawing]:
    return [random_linkage(np.random.default_rng([3, number])) for number in range(COUNT)]


def test_every_linkage_is_a_model(linkages: list[Drawing]) -> None:
    """All load, which means that they close as drawn; free coordinates are one to three."""
    free = set()
    for drawing in linkages:
        mechanism = drawn_mechanism(drawing)
        free.add(mechanism.degrees_of_freedom - len(mechanism.drives))
    assert free == {1, 2, 3}


@pytest.mark.parametrize("kind", KINDS)
def test_a_dyad_moves_as_the_closed_form_says(kind: str) -> None:
    """The engine's kinematics of the same machine, which knows nothing of dyads."""
    rng, found = np.random.default_rng(11), None
    while found is None:
        found = _with_dyad(rng, kind)
    points = {name: (float(x[0].real), float(x[0].imag)) for name, x in found.places.items()}
    drawing = Drawing(
        "dyad", "a dyad", points,
        (*(found.body(name) for name in found.bodies), *found.joints, Drive("O")), 0.0, 0.0, 60.0,
    )  # fmt: skip
    solution = simulate(drawn_mechanism(drawing), Case(speed_rpm=60.0, window="cycle"))
    times = ANGLES / (2.0 * np.pi)
    q = solution.trajectory.evaluate(times).q
    for output in found.outputs:
        joint = next(j for j in solution.mechanism.joints if j.name == output.joint)
        expected = (output.coordinate - output.coordinate[0]) * (1.0 if output.hinge else 1e-3)
        assert np.abs(q[:, joint.index] - expected).max() < 1e-9


def _with_dyad(rng: np.random.Generator, kind: str) -> Growing | None:
    linkage = crank(rng, 0.1)
    try:
        if kind == "PRP":
            # A guide on the crank itself would be level with the line twice a turn.
            add_dyad(rng, linkage, "RRR")
        add_dyad(rng, linkage, kind)
    except NoAssemblyError:
        return None
    return linkage


def test_a_linkage_is_written_as_a_model_folder(tmp_path: Path) -> None:
    case = write_linkage(5, 3, tmp_path / "third")
    same = trial(5, 3, ("linkage",))
    assert load(tmp_path / "third").description == same.mechanism().description
    assert case["speed_rpm"] == same.case["speed_rpm"]
    assert case["drive"] == same.case["drive"]


def test_a_campaign_of_one_family() -> None:
    result = run_campaign(3, 5, 1, families=("linkage",))
    assert {verdict.family for verdict in result.verdicts} == {"linkage"}
    with pytest.raises(UnknownNameError, match="no family of trials named 'linkages'"):
        trial(1, 1, ("linkages",))
