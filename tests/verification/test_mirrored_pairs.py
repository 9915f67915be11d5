"""Each machine beside its mirror image, and beside copies of itself, does what it does alone.

Two machines on one frame and one cylinder have nothing in common: what one does is not to depend
on the other, though stops of both are struck in the same instant. No number comes from elsewhere:
a run of the machine alone is the judge, to the errors that the two runs state.
"""

from __future__ import annotations

from dataclasses import replace

import pytest
from side_by_side import copies, differences, pair
from small_machines import link, machine, slide

from nipper_pin import Case, EventKind, Mechanism, Window, load, simulate
from nipper_pin.mechanism.gallery import GALLERY, drawn

SETTINGS = (("held", 1.0), ("inertial", 1.0), ("held", 2.0))


def table() -> list[object]:
    """Every machine of the gallery; a turn at the rated speed is the quick one."""
    return [
        pytest.param(
            name, drive, share,
            marks=[pytest.mark.campaign] * ((drive, share) != ("held", 1.0)),
        )
        for drive, share in SETTINGS
        for name in GALLERY
    ]  # fmt: skip


def turn(mechanism: Mechanism, share: float = 1.0, **keys: object) -> Case:
    speed = share * mechanism.cylinder.rated_speed_rpm
    return Case(speed_rpm=speed, window=Window.CYCLE, max_collisions=400, **keys)  # type: ignore[arg-type]


@pytest.mark.sampled(5)
@pytest.mark.parametrize(("name", "drive", "share"), table())
def test_a_machine_beside_its_mirror_image(name: str, drive: str, share: float) -> None:
    """Events of either half are those of the machine alone, each at the time that it has there."""
    machine_alone = drawn(name).mechanism()
    case = turn(machine_alone, share, drive=drive)
    alone, both = simulate(machine_alone, case), simulate(pair(machine_alone), case)
    # At twice its speed the clapper of the bell is thrown past both stops.
    assert alone.events or (name, share) == ("bell", 2.0)
    assert differences(alone, both, "") == differences(alone, both, "_mirrored") == []


def ball(restitution: float) -> Mechanism:
    """A ball 200 mm above a floor."""
    return machine(
        [link("ball"), slide("z", "frame", "ball", (0.0, 1.0))], 1, gravity=9.81,
        stops={"floor": {"joint": "z", "restitution": restitution}},
        initial={"z": {"at_mm": 200.0}},
    )  # fmt: skip


@pytest.mark.parametrize(
    ("of", "count"),
    [
        *(("ball", count) for count in (2, 3, 5)),
        ("e62", 3), ("slider_crank", 3), ("slider_crank", 5),
    ],
)  # fmt: skip
def test_machines_that_do_the_same(of: str, count: int) -> None:
    """Copies whose stops are struck, and come to rest, all in the same instants."""
    machines = {"ball": lambda: ball(0.4), "e62": load}
    single = machines.get(of, lambda: drawn(of).mechanism())()
    case = turn(single)
    alone, beside = simulate(single, case), simulate(copies(single, count), case)
    assert any(event.kind is EventKind.REST for event in alone.events)
    for k in range(count):
        assert differences(alone, beside, f"_{k}" if k else "") == []


def test_a_half_that_is_another_machine_is_seen() -> None:
    """A restitution that is off by a millionth, and only there."""
    single = drawn("bell").mechanism()
    both, case = pair(single), turn(single)
    stops = tuple(
        replace(stop, restitution=stop.restitution * (1.0 + 1e-6))
        if stop.name == "left_mirrored" else stop
        for stop in both.stops
    )  # fmt: skip
    alone, beside = simulate(single, case), simulate(replace(both, stops=stops), case)
    assert [text for text in differences(alone, beside, "") if "collision" in text] == []
    found = differences(alone, beside, "_mirrored")
    assert any("left_mirrored: collision" in text for text in found)
