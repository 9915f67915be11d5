"""Families of elements and stops on both sides: what they hold, and whether checks can fail.

Every check of springs, dampers, flights and mirror images is shown a deliberate error: a wrong
number in the engine, a sign, a loss that is not counted, a stop on the other side.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
import small_machines
from machine_of_all_elements import CASE, everything

from benchmarks.stress import FAMILIES, RIGHT, judge, trial, violations
from benchmarks.stress.checks.agreement import bits, mirror_images
from benchmarks.stress.machines.element_families import (
    ELEMENT_FAMILIES,
)
from benchmarks.stress.machines.mirror import mirrored
from benchmarks.stress.machines.parts import Source
from nipper_pin import Case, EventKind, Mechanism, Solution, Window, simulate
from nipper_pin.dynamics.elements import Elements
from nipper_pin.mechanism import from_sources

SEED = 11


def built(source: Source) -> Mechanism:
    return from_sources(source.name, source.urdf, source.description, source.folder)


@pytest.fixture(scope="module")
def run() -> Solution:
    return simulate(built(everything()), CASE)


def test_the_machine_shows_what_the_errors_below_need(run: Solution) -> None:
    """It hits stops on both sides, loses energy in dampers and stores some, and nothing is wrong.

    Otherwise the errors below would be caught for another reason, or be none.
    """
    assert {hit.stop for hit in run.collisions} >= {"j0 lower", "j0 upper", "j1 upper"}
    assert run.energy.dissipated > 0.01
    assert violations(run) == []


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


def other_engine(run: Solution, **changes: object) -> Solution:
    """The solution of an engine that takes this for the mechanism."""
    wrong = replace(run, mechanism=replace(run.mechanism, **changes))  # type: ignore[arg-type]
    wrong.__dict__["system"] = run.system
    return wrong


def stiffer_spring(run: Solution) -> Solution:
    (spring,) = run.mechanism.springs
    return other_engine(run, springs=(replace(spring, stiffness=spring.stiffness * 1.000001),))


def stiffer_strut(run: Solution) -> Solution:
    struts = tuple(replace(s, stiffness=s.stiffness * 1.000001) for s in run.mechanism.struts)
    return other_engine(run, struts=struts)


def other_strut(run: Solution) -> Solution:
    struts = tuple(replace(s, frame_b="b1") for s in run.mechanism.struts)
    return other_engine(run, struts=struts)


def thicker_oil(run: Solution) -> Solution:
    (damper,) = run.mechanism.dampers
    return other_engine(run, dampers=(replace(damper, damping=damper.damping * 1.000001),))


def softer_table(run: Solution) -> Solution:
    (table,) = run.mechanism.tabulated_springs
    rows = table.characteristic
    force = tuple(x * 0.999999 for x in rows.force)
    softer = replace(table, characteristic=replace(rows, force=force))
    return other_engine(run, tabulated_springs=(softer,))


def shorter_table(run: Solution) -> Solution:
    (table,) = run.mechanism.tabulated_springs
    rows = table.characteristic
    cut = replace(rows, coordinate=(-0.01, 0.0, 0.002, 0.01))
    return other_engine(run, tabulated_springs=(replace(table, characteristic=cut),))


@pytest.mark.parametrize(
    "doctor",
    [stiffer_spring, stiffer_strut, other_strut, thicker_oil, softer_table, shorter_table],
)
def test_an_engine_with_another_element_is_caught(
    run: Solution, doctor: Callable[[Solution], Solution]
) -> None:
    """Powers found anew differ by a millionth, or by where the points are."""
    assert "springs and dampers" in {item.kind for item in violations(doctor(run))}


def no_heat(_: Elements, q: np.ndarray, _v: np.ndarray) -> np.ndarray:
    return np.zeros(len(q))


def pushes_along(_: Elements, q: np.ndarray, v: np.ndarray) -> np.ndarray:
    return np.zeros_like(q) + 0.01 * v


def more_energy(_: Elements, q: np.ndarray) -> np.ndarray:
    return np.abs(q).sum(axis=1)


@pytest.mark.parametrize(
    ("name", "wrong", "kinds"),
    [
        ("dissipation", no_heat, {"springs and dampers", "energy"}),
        ("forces", pushes_along, {"springs and dampers", "energy"}),
        ("energy", more_energy, {"energy"}),
    ],
)
def test_an_engine_that_loses_or_makes_energy_is_caught(
    monkeypatch: pytest.MonkeyPatch, name: str, wrong: Callable[..., np.ndarray], kinds: set[str]
) -> None:
    """Struts and tables without heat, with a force that drives, and with another potential."""
    monkeypatch.setattr(Elements, name, wrong)
    found = {item.kind for item in violations(simulate(built(everything()), CASE))}
    assert kinds <= found


def moved(run: Solution, name: str, shift: float) -> Solution:
    """A number more in one coordinate of all flight panels."""
    segments = []
    for segment in run.segments:
        panels = tuple(
            replace(panel, **{name: getattr(panel, name) + np.array([0.0, shift, 0.0])})
            if panel.integrated else panel
            for panel in segment.panels
        )  # fmt: skip
        segments.append(replace(segment, panels=panels))
    return replace(run, segments=tuple(segments))


def test_a_flight_beside_its_equations_is_caught(run: Solution) -> None:
    """Accelerations 1e-4 rad/s^2 too large, of some 50; energy alone would hardly notice."""
    assert "flights" in {item.kind for item in violations(moved(run, "a", 1e-4))}


def test_a_body_beyond_its_upper_stop_is_caught(run: Solution) -> None:
    """The same motion with the upper stop nearer: gaps fall below zero and closed ones are open."""
    stops = tuple(
        replace(stop, at=stop.at - 1e-6) if stop.name == "j0 upper" else stop
        for stop in run.mechanism.stops
    )
    found = violations(other_engine(run, stops=stops))
    assert any("j0 upper penetrates" in item.detail for item in found)


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


@pytest.mark.campaign
def test_new_families_are_run_and_most_of_them_are_right() -> None:
    """Three trials of each; what they are judged by is shown to fail above."""
    names = tuple(FAMILIES)
    verdicts = [
        judge(trial(SEED, names.index(name) + k * len(names)))
        for name in ELEMENT_FAMILIES for k in range(3)
    ]  # fmt: skip
    assert [v.detail for v in verdicts if v.word == "wrong"] == []
    assert sum(v.word == RIGHT for v in verdicts) > len(verdicts) // 2
    collided = trial(SEED, names.index("two stops"))
    solution = simulate(
        collided.mechanism(), Case(**{**collided.case, "resolution": CASE.resolution})
    )
    assert any(event.kind is EventKind.COLLISION for event in solution.events)
