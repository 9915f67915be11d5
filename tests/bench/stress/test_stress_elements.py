"""Families of elements and stops on both sides: what they hold, and whether checks can fail.

The comparison with mirror images is shown deliberate errors: a wrong sign, a stop elsewhere.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
import small_machines
from machine_of_all_elements import CASE, everything

from benchmarks.stress import FAMILIES, trial, violations
from benchmarks.stress.checks.agreement import bits, mirror_images
from benchmarks.stress.machines.element_families import (
    ELEMENT_FAMILIES,
)
from benchmarks.stress.machines.mirror import mirrored
from benchmarks.stress.machines.parts import Source
from nipper_pin import Case, Mechanism, Solution, Window, simulate
from nipper_pin.mechanism import from_sources

SEED = 11


def built(source: Source) -> Mechanism:
    return from_sources(source.name, source.urdf, source.description, source.folder)


@pytest.fixture(scope="module")
def run() -> Solution:
    return simulate(built(everything()), CASE)


def test_the_machine_shows_what_the_errors_below_need(run: Solution) -> None:
    """It hits stops on both sides and loses energy in dampers: else they would be none."""
    assert {hit.stop for hit in run.collisions} >= {"j0 lower", "j0 upper", "j1 upper"}
    assert run.energy.dissipated > 0.01


@pytest.mark.parametrize("ratio", [1.0, -1.0])
def test_a_strut_that_keeps_its_length_is_no_violation(ratio: float) -> None:
    """From the hub of a wheel to its rim, whichever way that turns: all its power is round-off."""
    wheel = small_machines.machine(
        [
            small_machines.link("wheel"),
            small_machines.hinge("axle", "frame", "wheel"),
            small_machines.frame("hub", "frame"),
            small_machines.frame("rim", "wheel", (0.3, 0.1)),
        ],
        1,
        drives={
            "axle": {
                "joint": "axle", "law": "constant_speed", "ratio": ratio, **small_machines.SHAFT
            }
        },
        springs={
            "rod": {
                "frame_a": "hub",
                "frame_b": "rim",
                "stiffness_N_per_m": 1e4,
                "free_length_mm": 200.0,
            }
        },
    )  # fmt: skip
    case = Case(speed_rpm=60.0, window=Window.CYCLE, start_index=0.0)
    turning = simulate(wheel, case)
    assert np.sign(turning.trajectory.evaluate(0.5).v[0, 0]) == ratio
    assert violations(turning) == []


def test_mirror_images_move_alike(run: Solution) -> None:
    """All events of the mirror image are those of the machine; hinges have turned their stops.

    Twice mirrored is the model itself, number by number.
    """
    source = everything()
    image = mirrored(source)
    assert image is not None
    assert image.description["stops"]["j0 lower"]["side"] == "upper"
    assert image.description["stops"]["j1 upper"]["side"] == "upper"
    twice = mirrored(image)
    assert twice is not None
    assert built(twice).stops == run.mechanism.stops
    assert built(twice).springs == run.mechanism.springs
    assert bits(simulate(built(twice), CASE)) == bits(run)
    seen = simulate(built(image), CASE)
    assert len(seen.events) == len(run.events)
    assert [(e.kind, e.stops) for e in seen.events] == [(e.kind, e.stops) for e in run.events]
    assert mirror_images(run, seen) == []


def wrong_place(image: Source) -> None:
    image.description["stops"]["j0 upper"]["at_deg"] *= 1.0 + 1e-6


def unturned_table(image: Source) -> None:
    image.description["springs"]["coil"]["preload_deg"] *= -1.0


def unturned_drive(image: Source) -> None:
    drive = image.description["drives"]["shaft"]
    drive["sine_rad"] = [-x for x in drive["sine_rad"]]


@pytest.mark.parametrize("wrong", [wrong_place, unturned_table, unturned_drive])
def test_a_mirror_image_with_a_wrong_sign_is_caught(
    run: Solution, wrong: Callable[[Source], None]
) -> None:
    """What an engine with a wrong sign at one side would do to the image."""
    image = mirrored(everything())
    assert image is not None
    wrong(image)
    found = mirror_images(run, simulate(built(image), CASE))
    assert {item.kind for item in found} == {"mirror"}


def test_families_hold_what_they_say() -> None:
    """In 30 trials each: all elements and stops, extreme numbers, both drives, coarse and fine."""
    names = tuple(FAMILIES)
    sources = [
        trial(SEED, names.index(name) + k * len(names))
        for name in ELEMENT_FAMILIES for k in range(30)
    ]  # fmt: skip
    texts = [item.source.description for item in sources]
    springs = [s for text in texts for s in text.get("springs", {}).values()]
    dampers = [d for text in texts for d in text.get("dampers", {}).values()]
    stops = [s for text in texts for s in text.get("stops", {}).values()]
    assert any("frame_a" in s for s in springs)
    assert any("force_N" in s for s in springs)
    assert any("torque_N_m" in s for s in springs)
    assert any("frame_a" in d for d in dampers)
    assert any("joint" in d for d in dampers)
    assert {s.get("side", "lower") for s in stops} == {"lower", "upper"}
    assert {0.0, 1.0, 0.999} <= {s["restitution"] for s in stops}
    stiffness = [v for s in springs for k, v in s.items() if k.startswith("stiffness")]
    assert min(stiffness) < 0.1
    assert max(stiffness) > 1e8
    assert any("slot_axis" in c for text in texts for c in text.get("closures", {}).values())
    assert {1, 2, 3, 4} <= {len(text.get("stops", {})) for text in texts}
    assert {item.case.get("drive", "held") for item in sources} == {"held", "inertial"}
    tolerances = [item.case["resolution"]["tolerance"] for item in sources]
    assert min(tolerances) == 1e-12
    assert max(tolerances) > 1e-4
