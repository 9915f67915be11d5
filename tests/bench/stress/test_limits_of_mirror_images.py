"""A machine and its mirror image have the same limits."""

from __future__ import annotations

import pytest
from machine_of_all_elements import CASE, everything
from made_up_runs import Said, watched

from benchmarks.stress.checks import elements as element_invariants
from benchmarks.stress.checks import flights as flight_invariants
from benchmarks.stress.checks import impacts as impact_invariants
from benchmarks.stress.checks import invariants
from benchmarks.stress.checks import model as model_invariants
from benchmarks.stress.checks import rebounds as rebound_invariants
from benchmarks.stress.machines.mirror import mirrored
from benchmarks.stress.machines.parts import Source
from nipper_pin import simulate
from nipper_pin.mechanism import from_sources

FILES = (element_invariants, flight_invariants, impact_invariants, invariants, model_invariants,
         rebound_invariants)  # fmt: skip


def limits(source: Source) -> list[tuple[str, float]]:
    """What is looked at, and the most that is allowed; times to six digits."""
    machine = from_sources(source.name, source.urdf, source.description, source.folder)
    solution = simulate(machine, CASE)
    with pytest.MonkeyPatch.context() as patch:
        said: list[list[Said]] = [watched(patch, file) for file in FILES]
        assert invariants.violations(solution) == []
    return [(what.split(" at ")[0], most) for each in said for what, _, most in each]


@pytest.mark.slow
def test_limits_of_a_mirror_image() -> None:
    """Of all elements; only round-off of the two motions is between them."""
    source = everything()
    image = mirrored(source)
    assert image is not None
    ones, others = limits(source), limits(image)
    assert len(ones) > 1000
    assert [what for what, _ in ones] == [what for what, _ in others]
    for (what, one), (_, other) in zip(ones, others, strict=True):
        assert one == pytest.approx(other, rel=1e-5, abs=1e-300), what
