"""Found by the stress campaign (cases 200 and 238 of seed 1): a contact that only grazes.

"no impulses at flap1, flap2, flap3 satisfy the impact law: these stops jam the mechanism against
its drives": the flaps arrived at their stops at +3e-15 rad/s, which is round-off. No impulse is
needed there, and the law was not tried with none.
"""

import numpy as np
import pytest
from small_machines import link, slide
from small_machines import machine as machine_of_parts

from benchmarks.stress.machines.small_machines import flaps
from nipper_pin import Case, EventKind, Mechanism, Outcome, Window, simulate
from nipper_pin.dynamics import Partition, ShaftMotion, System, collide
from nipper_pin.hybrid.event_location.guards import _flight_root
from nipper_pin.hybrid.motion.chebyshev import nodes
from nipper_pin.hybrid.motion.panel import Panel
from nipper_pin.mechanism import from_sources
from nipper_pin.tolerances.hybrid import GAP_ROUND_OFF


@pytest.fixture(scope="module")
def machine() -> Mechanism:
    source = flaps(2, (0.3,), 0.5, 0.02, 10.0, 9.81)
    return from_sources(source.name, source.urdf, source.description, source.folder)


@pytest.mark.parametrize(("rate", "after"), [(0.0, 0.0), (3e-15, 0.0), (0.25, 0.25)])
def test_contacts_that_do_not_approach_take_no_impulse(
    machine: Mechanism, rate: float, after: float
) -> None:
    """P = 0 satisfies the law where every rate is positive; one that is round-off becomes zero.

    The arm turns at 1 rad/s, so 3e-15 rad/s is round-off and 0.25 rad/s is not.
    """
    system = System(machine, ShaftMotion(machine, 10.0, 0.0))
    q, v = np.zeros(3), np.array([1.0, rate, rate])
    impact = collide(system, q, v, np.empty((0, 3)), machine.stops, [0.5, 0.5])
    assert set(impact.P_N.values()) == {0.0}
    assert not impact.delta.any()
    assert impact.energy_lost == 0.0
    assert impact.v_after.tolist() == [1.0, after, after]


def test_flaps_that_bounce_in_one_rhythm_come_to_rest() -> None:
    """Found by case 7680 of seed 111: "max() arg is an empty sequence".

    Three equal flaps bounce in one rhythm. No series of one stop described that, so they went on
    until their rates were round-off, and touched without approach again and again.
    """
    swing = 0.02389812640351119, 0.22654876994566853, -0.3652977606771073
    source = flaps(3, swing, 0.5, 0.08450230233247534, 48.62970648878668, 0.0)
    machine = from_sources(source.name, source.urdf, source.description, source.folder)
    case = Case(
        speed_rpm=35.930164672310816,
        window=Window.CYCLE,
        start_index=11.809148731844,
        max_collisions=100,
    )
    solution = simulate(machine, case)
    assert solution.outcome is Outcome.COMPLETED
    assert all(len(hit.event.stops) == 3 for hit in solution.collisions)
    assert all(hit.approach_rate < 0.0 for hit in solution.collisions)
    rests = [event for event in solution.events if event.kind is EventKind.REST]
    assert rests
    assert all(len(event.stops) == 3 for event in rests)


def test_a_gap_that_opens_and_closes_within_round_off_ends_there() -> None:
    """Found by case 6571 of seed 111: "its gap starts to close from zero".

    A gap of 3e-22 m that opens at 1e-11 m/s and is pulled shut at 9.4 m/s^2 is back after 2.5e-12
    s; the first sample of a panel of 10 ms was its start plus round-off of the
    motion, -1e-20 m.
    """
    mechanism = machine_of_parts(
        [link("mass"), slide("x", "frame", "mass")], 1,
        stops={"floor": {"joint": "x", "side": "lower", "restitution": 0.2}},
    )  # fmt: skip
    stop = mechanism.stop("floor")
    order, h, gap, rate, pull = 12, 1e-2, 2.868892e-22, 1.182589e-11, 9.43
    for share in np.linspace(0.9, 1.1, 21):
        t = h * nodes(order).sigma[:, None]
        a = np.full((order, 1), -pull * share)
        q, v = gap + rate * t + 0.5 * a * t**2, rate + a * t
        panel = Panel(0.0, h, q, v, a, Partition((), (0,)), integrated=True)
        found = _flight_root(panel, stop, gap, rate, GAP_ROUND_OFF)
        assert found is not None
        # Round-off of what the panel moves by, h^2 a, is all that may be left of the gap there.
        left = gap + rate * found - 0.5 * pull * share * found**2
        assert found >= 0.0
        assert abs(left) <= 64.0 * np.finfo(float).eps * h**2 * pull


@pytest.mark.parametrize("gap", [-1e-35, -1e-20, -3e-14])
def test_a_stop_that_opens_from_below_zero_and_closes_is_not_passed(gap: float) -> None:
    """Found by case 1631 of seed 151: "jump [rad or m]: 0.00296, at most 3.12e-11".

    A collision at another stop in the same instant had left a gap of -1e-35 rad that opened at
    3e-8 rad/s and was pulled shut at 13 rad/s^2. On a panel of 17 ms all samples of it lay below
    zero, and were taken for a gap that had no time to open.
    """
    mechanism = machine_of_parts(
        [link("mass"), slide("x", "frame", "mass")], 1,
        stops={"floor": {"joint": "x", "side": "lower", "restitution": 0.2}},
    )  # fmt: skip
    order, h, rate, pull = 13, 0.0175, 3.47e-8, 13.18
    t = h * nodes(order).sigma[:, None]
    a = np.full((order, 1), -pull)
    q, v = gap + rate * t + 0.5 * a * t**2, rate + a * t
    panel = Panel(0.0, h, q, v, a, Partition((), (0,)), integrated=True)
    found = _flight_root(panel, mechanism.stop("floor"), gap, rate, GAP_ROUND_OFF)
    assert found == pytest.approx(2.0 * rate / pull, rel=1e-10)


@pytest.mark.parametrize("start", [0.0, 1e-9, 1e-3])
def test_a_stop_that_opens_without_a_pull_and_is_pressed_shut_closes_at_once(start: float) -> None:
    """Found by case 1018 of seed 611: "its gap starts to close from zero".

    A machine without weight, at rest but for round-off: accelerations of 1e-34 opened a stop, and
    pushed it shut from there, slowly at first.
    """
    mechanism = machine_of_parts(
        [link("mass"), slide("x", "frame", "mass")], 1,
        stops={"floor": {"joint": "x", "side": "lower", "restitution": 0.0}},
    )  # fmt: skip
    order, h, pull = 13, 0.02, 1e-33
    t = h * nodes(order).sigma[:, None]
    a = -pull * (start + t / h)
    v = -pull * (start * t + 0.5 * t**2 / h)
    q = -pull * (0.5 * start * t**2 + t**3 / (6.0 * h))
    panel = Panel(0.25, h, q, v, a, Partition((), (0,)), integrated=True)
    assert _flight_root(panel, mechanism.stop("floor"), 0.0, 0.0, GAP_ROUND_OFF) == 0.25
