"""Stops on either side of a joint: gap, place, contact of shapes, and what is refused."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from small_machines import hinge, link, machine, slide

from nipper_pin import Case, InputError, Mechanism, Window, check, load, simulate
from nipper_pin.mechanism import Stop
from nipper_pin.reduced import build, unfit
from tests.refusals.bases import model

PARTS = [link("cart"), slide("x", "frame", "cart"), link("arm"), hinge("turn", "cart", "arm")]


def test_places_and_sides_are_read_in_their_units() -> None:
    """Millimetres of a slide, degrees of a hinge; a stop without them is the lower one at zero.

    The findings about a model say which limit of which joint each stop is.
    """
    mechanism = machine(PARTS, 2, stops={
        "wall": {"joint": "x", "restitution": 0.5, "side": "upper", "at_mm": 120.0},
        "floor": {"joint": "x", "restitution": 0.5},
        "turned": {"joint": "turn", "restitution": 0.25, "at_deg": -90.0},
    })  # fmt: skip
    found = {stop.name: (stop.sense, stop.at) for stop in mechanism.stops}
    assert found == {"wall": (-1.0, 0.12), "floor": (1.0, 0.0), "turned": (1.0, -np.pi / 2.0)}
    assert [stop.plain for stop in mechanism.stops] == [False, True, False]
    assert check(mechanism, 60.0).record()["stops"] == {
        "wall": {"joint": "x", "side": "upper", "at": 0.12, "restitution": 0.5},
        "floor": {"joint": "x", "side": "lower", "at": 0.0, "restitution": 0.5},
        "turned": {"joint": "turn", "side": "lower", "at": -np.pi / 2.0, "restitution": 0.25},
    }


@pytest.mark.parametrize("sense", [1.0, -1.0])
@pytest.mark.parametrize("at", [0.0, 0.1, -1.0 / 3.0])
def test_gap_and_rate_count_from_the_stop(sense: float, at: float) -> None:
    """g_N is zero to the last bit at the stop and grows away from it, on whichever side that is.

    The neighbouring number of ``at`` on the free side is a positive gap of one unit in the last
    place: the difference of nearby numbers is exact.
    """
    stop = Stop(name="s", index=1, restitution=0.0, contact=None, sense=sense, at=at)
    q = np.array([7.0, at, 7.0])
    assert stop.gap(q) == 0.0
    near = np.nextafter(at, sense * np.inf)
    assert stop.gap(np.array([7.0, near, 7.0])) == abs(near - at) > 0.0
    many = np.array([q, q + sense * 0.25])
    assert stop.gaps(many) == pytest.approx([0.0, 0.25], abs=1e-16)
    v = np.array([[7.0, 3.0, 7.0]])
    assert (stop.rate(v[0]), stop.rates(v).tolist()) == (sense * 3.0, [sense * 3.0])


def test_a_stop_beyond_its_contact_at_the_start_is_refused() -> None:
    """A coordinate of zero above an upper stop at -5 mm lies in the wall: by 0.005 m, with advice.

    With that stop closed in the initial phase the joint starts at the stop instead.
    """
    stops = {"a": {"joint": "x", "restitution": 0.5, "side": "upper", "at_mm": -5.0}}
    case = Case(speed_rpm=60.0, window=Window.CYCLE, start_index=0.0)
    with pytest.raises(InputError, match=r"stop 'a' would be 5 mm beyond its contact"):
        simulate(machine(PARTS, 2, stops=stops), case)
    closed = [{"number": 1, "name": "at the wall", "closed": ["a"]}]
    springs = {"k": {"joint": "x", "stiffness_N_per_m": 5.0, "preload_length_mm": -10.0}}
    solution = simulate(machine(PARTS, 2, stops=stops, phases=closed, springs=springs), case)
    q = solution.trajectory.evaluate([0.0, 0.5, 1.0]).q
    assert (q[:, 0] == -0.005).all()
    force = solution.trajectory.reactions(0.5).stops["a"][0]
    assert force == pytest.approx(5.0 * (0.010 + 0.005), rel=1e-12)


def test_a_transition_needs_a_stop_that_is_closed_at_touch() -> None:
    """A transition starts where its stop collides; one that stands open there is told so."""
    stops = {"a": {"joint": "x", "restitution": 0.5, "at_mm": -5.0}}
    with pytest.raises(InputError, match=r"stop 'a' stands open by 5 mm .*whole turns"):
        simulate(machine(PARTS, 2, stops=stops), Case(speed_rpm=60.0))


def test_the_reduced_engine_leaves_other_stops_to_the_direct_one(
    e62: Mechanism, tmp_path: Path
) -> None:
    """An upper stop, or one away from zero, is a reason in one sentence; plain ones are not."""
    assert unfit(e62) is None
    limit = '[stops.limit]\njoint = "jaw"\nrestitution = 0.2\nside = "upper"\nat_deg = 60.0\n'
    limited = load(model("e62", ("[stops.jaw]", f"{limit}[stops.jaw]"), tmp_path))
    assert "'limit'" in (unfit(limited) or "")
    with pytest.raises(InputError, match=r"lower stops at coordinate zero.*use the direct engine"):
        build(limited)
    wide, plain = (simulate(item, Case(speed_rpm=450.0)).transitions[0] for item in (limited, e62))
    assert wide.duration == pytest.approx(plain.duration, rel=1e-12)
