"""A rod falls flat on two stops, one under each end, which are hit at one time.

Of a symmetric rod both laws of stops struck together say the same: it bounces flat. Rounded numbers
are no reason to strike one end before the other; a difference that is one makes the laws differ,
which is told, and alike of the mirror image.
"""

from __future__ import annotations

import math

import pytest
from small_machines import frame, hinge, link, machine, slide

from nipper_pin import Case, EventKind, Mechanism, Solution, Window, simulate
from nipper_pin.mechanism import Simultaneous

FALL, G = 0.1, 9.81
LAWS: tuple[Simultaneous, ...] = ("newton", "sequential")


def rod(
    law: Simultaneous,
    mass: float,
    arms: tuple[float, float],
    restitution: tuple[float, float] = (0.5, 0.5),
) -> Mechanism:
    """A uniform rod of 0.3 m on feet of 1 g, which slide upright.

    Args:
        law: Of stops that are struck together.
        mass: Of the rod [kg].
        arms: From its middle to its left and its right foot [m].
        restitution: Of the stops below them.
    """
    places = dict(zip("lr", (-arms[0], arms[1]), strict=True))
    parts = [link("guide", 1e-3), slide("z", "frame", "guide", (0.0, 1.0)),
             link("rod", mass, mass * 0.3**2 / 12.0), hinge("tilt", "guide", "rod")]  # fmt: skip
    for foot, x in places.items():
        parts += [frame(f"{foot}_end", "rod", (x, 0.0)), link(f"{foot}_foot", 1e-3),
                  slide(f"{foot}_z", "frame", f"{foot}_foot", (0.0, 1.0), (x, 0.0))]  # fmt: skip
    return machine(
        parts, 2, gravity=G, simultaneous=law, initial={"z": {"at_mm": 1e3 * FALL}},
        closures={foot: {"frame_a": f"{foot}_foot", "frame_b": f"{foot}_end", "slot_axis": "x",
                         "block_mass_kg": 1e-3} for foot in places},
        stops={foot: {"joint": f"{foot}_z", "restitution": e_N}
               for foot, e_N in zip(places, restitution, strict=True)},
    )  # fmt: skip


def turn(mechanism: Mechanism) -> Solution:
    return simulate(mechanism, Case(speed_rpm=60.0, window=Window.CYCLE))


@pytest.mark.sampled(7)
@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("arms", [(0.15, 0.15), (0.1166667, 0.1166666), (0.11667, 0.11666)])
@pytest.mark.parametrize(("mass", "e_N"), [(0.1, 0.0), (1.0, 0.5), (30.0, 0.2), (1.0, 0.7)])
def test_a_symmetric_rod_bounces_flat(
    law: Simultaneous, arms: tuple[float, float], mass: float, e_N: float
) -> None:
    solution = turn(rod(law, mass, arms, (e_N, e_N)))
    assert not [text for text in solution.warnings if "choice" in text]
    (rest,) = (event for event in solution.events if event.kind is EventKind.REST)
    assert rest.stops == ("l", "r")
    fall = math.sqrt(2.0 * FALL / G)
    assert rest.t == pytest.approx(fall * (1.0 + e_N) / (1.0 - e_N), rel=1e-11)
    for hit in solution.collisions:
        assert hit.separation_rate == pytest.approx(-e_N * hit.approach_rate, rel=1e-9)


@pytest.mark.sampled(5)
@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("mass", [0.1, 30.0])
@pytest.mark.parametrize("restitution", [(0.5, 0.5), (0.0, 0.5), (0.2, 0.7)])
def test_the_mirror_image_does_the_same(
    law: Simultaneous, mass: float, restitution: tuple[float, float]
) -> None:
    """Of a rod whose left foot is nearer; its first blow is the one that the laws give apart."""
    one = turn(rod(law, mass, (0.1, 0.15), restitution))
    other = turn(rod(law, mass, (0.15, 0.1), restitution[::-1]))
    for solution in (one, other):
        assert "depends on a choice of the model: at t = 142.784 ms" in solution.warnings[0]
    first, mirrored = one.events[0].P_N, other.events[0].P_N
    assert first["l"] == pytest.approx(mirrored["r"], rel=1e-9)
    assert first["r"] == pytest.approx(mirrored["l"], rel=1e-9)
    assert len(one.collisions) == len(other.collisions)
    for hit, image in zip(one.collisions, other.collisions, strict=True):
        assert image.t == pytest.approx(hit.t, abs=1e-9)
