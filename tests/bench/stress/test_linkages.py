"""Random linkages: closed all around, the same for a seed, of every kind of dyad."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from benchmarks.stress import run_campaign, trial
from benchmarks.stress.linkages import random_linkage, write_linkage
from benchmarks.stress.linkages.dyads import KINDS, Growing, add_dyad, crank
from benchmarks.stress.linkages.freedoms import open_at, struck
from benchmarks.stress.linkages.motion import (
    ANGLES,
    NoAssemblyError,
    Output,
    Rod,
    rod_on_line,
    unit,
)
from nipper_pin import Case, SimulationError, UnknownNameError, load, simulate
from nipper_pin.mechanism.drawing import Drawing, Drive, Spring, Stop, drawn_mechanism

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


def test_stops_springs_and_dyads_of_every_kind_come_out(linkages: list[Drawing]) -> None:
    stops = [[p for p in item.parts if isinstance(p, Stop)] for item in linkages]
    assert any(stop.joint.startswith("turn") for group in stops for stop in group)
    assert any(stop.joint.startswith("slide") for group in stops for stop in group)
    assert any(stop.side == "upper" and stop.at for group in stops for stop in group)
    assert all(group for group in stops)
    names = {name for item in linkages for name in _joints(item)}
    assert {"rod", "turn", "slide", "slot", "ride", "flap", "box"} <= names
    assert any(isinstance(p, Spring) and p.joint.startswith("turn")
               for item in linkages for p in item.parts)  # fmt: skip


def _joints(drawing: Drawing) -> set[str]:
    names = [joint.name for joint in drawn_mechanism(drawing).joints]
    return {name.rstrip("0123456789") for name in names}


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


def test_a_stop_is_met_within_the_reach(linkages: list[Drawing]) -> None:
    """Stops on what dyads move: without them the coordinate goes past their place."""
    met = 0
    for drawing in linkages[:16]:
        stops = [p for p in drawing.parts
                 if isinstance(p, Stop) and p.joint.startswith(("turn", "slide"))]  # fmt: skip
        if not stops:
            continue
        kept = tuple(p for p in drawing.parts if p not in stops)
        # So stiff that nothing gives way.
        kept = tuple(replace(p, preload=1e6 * p.preload) if isinstance(p, Spring) else p
                     for p in kept)  # fmt: skip
        free = drawn_mechanism(replace(drawing, parts=kept, struck=""))
        try:
            solution = simulate(free, Case(speed_rpm=1.0, window="cycle"))
        except SimulationError:
            continue
        q = solution.trajectory.evaluate(np.linspace(*solution.trajectory.span, 721)).q
        full = drawn_mechanism(drawing)
        for part in stops:
            stop = full.stop(part.joint)
            met += 1
            gap = stop.gaps(q)
            # Drawn between 0.03 and 0.4 of the reach, or one step of the crank before that.
            assert 0.02 < -gap.min() / np.ptp(gap) < 0.75
    assert met > 3


def test_the_rod_gives_way_to_the_side_that_the_stop_asks_for() -> None:
    """A block beyond the crank: one that is kept from going on needs a shorter rod, one that is
    kept from coming back a longer one; and before it is met a stop is open."""
    pin = 20.0 * unit(ANGLES)
    travel = rod_on_line(pin, 100.0, 0j, 0.0, 1.0, 0.1)
    rod = Rod("rod", 100.0, pin, complex)
    sides = set()
    for seed in range(8):
        step = 1 if seed % 2 else -1
        found = struck(np.random.default_rng(seed), Output("x", travel, False, rod), rod, step)
        assert found is not None
        assert found.longer == found.lower
        assert found.gap[found.contact] == 0.0
        assert found.gap[found.contact - step] > 0.0 > found.gap[found.contact + step]
        best = open_at([found])
        assert best is not None
        assert found.gap[best] > 20.0
        sides.add(found.lower)
    assert sides == {True, False}


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
