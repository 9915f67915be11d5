"""Runs that many tests of views look at, each computed once: machines of unlike kinds."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

from boxed_mass import box
from judge import MACHINES, press
from small_machines import SHAFT, frame, hinge, link, machine, slide

from nipper_pin import Case, Mechanism, Solution, Window, load, simulate
from nipper_pin.mechanism import from_sources
from nipper_pin.mechanism.gallery import GALLERY, drawn


def balls() -> Mechanism:
    """Two balls that fall from one height, so that one event strikes both of their floors."""
    return load(MACHINES / "balls" / "small")


def with_elements() -> Mechanism:
    """The E62 with springs and dampers of all kinds."""
    plain = load("e62")
    document: Any = plain.description
    band = {"frame_a": "steeve_lower", "frame_b": "frame", "stiffness_N_per_m": 120.0,
            "free_length_mm": 90.0}  # fmt: skip
    lid = {"joint": "jaw", "coordinate_deg": [-90.0, 0.0, 180.0], "torque_N_m": [1.0, 2.0, 4.5]}
    document = {
        **document,
        "springs": {**document["springs"], "band": band, "lid": lid},
        "dampers": {
            "oil": {"joint": "steeve", "damping_N_s_per_m": 12.0},
            "stay": {"frame_a": "frame", "frame_b": "rod_head", "damping_N_s_per_m": 5.0},
        },
    }
    return from_sources("e62", plain.urdf, document, plain.mesh_folder or ".")


def aside() -> Mechanism:
    """The press with its flap beside the plane of its sled."""
    plain = press()
    urdf = plain.urdf.replace("0.1 0 0.05", "0.1 0.07 0.05")
    return from_sources("small", urdf, plain.description, ".")


def slotted() -> Mechanism:
    """A pin in a slot, and a mass between two stops away from zero."""
    parts = [
        link("crank"), hinge("crank_axis", "frame", "crank"),
        frame("crank_pin", "crank", (0.05, 0.0)),
        link("yoke"), slide("yoke_x", "frame", "yoke", at=(0.05, 0.0)),
        link("mass"), slide("room", "yoke", "mass"),
    ]  # fmt: skip
    return machine(
        parts, 2,
        drives={"crank": {"joint": "crank_axis", "law": "constant_speed", "ratio": 1.0, **SHAFT}},
        closures={"slot": {"frame_a": "yoke", "frame_b": "crank_pin", "slot_axis": "z",
                           "block_mass_kg": 0.1}},
        stops={"near": {"joint": "room", "restitution": 0.5, "at_mm": -4.0},
               "far": {"joint": "room", "restitution": 0.5, "side": "upper", "at_mm": 6.0}},
    )  # fmt: skip


def machine_called(name: str) -> Mechanism:
    """A model of the package, one of the gallery, or the E62 with springs between two points."""
    if name in GALLERY:
        return drawn(name).mechanism()
    return with_elements() if name == "elements" else load(name)


def turn(mechanism: Mechanism, speed: float, start: float = 0.0, turns: int = 1) -> Solution:
    """Some turns from an index on."""
    case = Case(speed_rpm=speed, window=Window.CYCLE, cycles=turns, start_index=start)
    return simulate(mechanism, case)


RUNS: dict[str, Callable[[], Solution]] = {
    # A contact point, and a stop of a slide; one without contact at a hinge, on a machine that
    # starts at index zero; stops on the upper side and away from zero; two struck together.
    "e62": lambda: turn(load("e62"), 650.0, 24.0),
    "transition": lambda: simulate(load("e62"), Case(speed_rpm=650.0)),
    "elements": lambda: simulate(with_elements(), Case(speed_rpm=650.0)),
    "press": lambda: turn(press(), 60.0),
    "aside": lambda: turn(aside(), 60.0),
    "boxed": lambda: turn(box(-1.0, 0.15), 60.0, turns=2),
    "balls": lambda: turn(balls(), 60.0),
}


@cache
def run_of(name: str) -> Solution:
    """One of them."""
    return RUNS[name]()


TURNS = ("e62", "press", "boxed", "balls")
"""Whole turns of which no two are alike."""
