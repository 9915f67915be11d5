"""A seed gives the machines that it gave: failures in campaigns are told by it.

A family that is changed on purpose gives others. This file, run by `python`, then writes the
record anew, and campaigns that were published have to say of which version they are.
"""

from __future__ import annotations

import hashlib
import json
import re
from pathlib import Path
from xml.etree.ElementTree import canonicalize

import numpy as np
import pytest

from benchmarks.stress import FAMILIES, trial
from benchmarks.stress.linkages import random_linkage, write_linkage
from benchmarks.stress.linkages.dyads import KINDS, Growing, add_dyad, crank
from benchmarks.stress.linkages.motion import ANGLES, NoAssemblyError
from nipper_pin import Case, Drawing, load, simulate

KEPT = Path(__file__).with_name("machines_of_a_seed.json")
SEED, TRIALS = 421, 48
NUMBER = r"-?\d+(\.\d*)?(e[-+]?\d+)?"
# Families that are written quickly, or have forms that are seldom drawn.
MORE = {
    "dead centre": 240, "grazing": 96, "together": 240, "many cycles": 96, "bouncing mass": 240,
    "two stops": 240, "chain": 240, "hard elements": 240, "spring tables": 144,
    "near points": 240, "slots": 240, "linkage": 144,
}  # fmt: skip


def digest(family: str) -> str:
    """Of the first trials of a family: models, cases, and by them the order of random numbers."""
    found = hashlib.sha256()
    for number in range(MORE.get(family, TRIALS)):
        made = trial(SEED, number, [family])
        # Provenance is text for people; no machine depends on it.
        numbers = {k: v for k, v in made.source.description.items() if k != "provenance"}
        urdf = canonicalize(made.source.urdf, strip_text=True)
        text = urdf + json.dumps([numbers, made.case], default=list)
        # The last digits are those of round-off.
        found.update(re.sub(NUMBER, lambda match: f"{float(match[0]):.7g}", text).encode())
    return found.hexdigest()[:16]


@pytest.mark.sampled(9)
@pytest.mark.parametrize("family", FAMILIES)
def test_a_seed_gives_the_machines_that_it_gave(family: str) -> None:
    """Seven digits of every number: by accident one in 1e9 is rounded to the other side."""
    assert digest(family) == json.loads(KEPT.read_text(encoding="utf-8"))[family]


# --- linkages ------------------------------------------------------------------------------------


def test_every_linkage_is_a_model() -> None:
    """All load, which means that they close as drawn; free coordinates are one to three."""
    free = set()
    for number in range(40):
        mechanism = random_linkage(np.random.default_rng([3, number])).mechanism()
        free.add(mechanism.degrees_of_freedom - len(mechanism.drives))
    assert free == {1, 2, 3}


@pytest.mark.parametrize("kind", KINDS)
def test_a_dyad_moves_as_the_closed_form_says(kind: str) -> None:
    """The engine's kinematics of the same machine, which knows nothing of dyads."""
    rng, found = np.random.default_rng(11), None
    while found is None:
        found = _with_dyad(rng, kind)
    points = {name: (float(x[0].real), float(x[0].imag)) for name, x in found.places.items()}
    drive = {"joint": "O", "law": "constant_speed", "ratio": 1.0}
    drawing = Drawing(
        {**found.tables(points), "title": "a dyad", "speed_rpm": 60.0, "drives": {"O": drive}}
    )
    solution = simulate(drawing.mechanism(), Case(speed_rpm=60.0, window="cycle"))
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


if __name__ == "__main__":
    digests = {family: digest(family) for family in FAMILIES}
    KEPT.write_text(json.dumps(digests, indent=1) + "\n", encoding="utf-8")
