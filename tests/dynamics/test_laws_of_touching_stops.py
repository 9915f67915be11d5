"""Both laws of impacts at stops that touch, against closed forms.

With "newton" all contacts follow Newton's law at once, touching ones with no rate before; with
"sequential" an impulse passes from contact to contact as it does across small gaps.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
import pytest
from rows_of_balls import row, struck
from small_machines import link, machine, slide

from nipper_pin import ImpactError
from nipper_pin.dynamics import ShaftMotion, System
from nipper_pin.dynamics.impact_laws import solve_impact

EPS = np.finfo(float).eps
# A strike is a few roundings of numbers of the size of one; rows of five take ten.
EXACT = 100.0 * EPS


def test_newton_moves_a_cradle_of_five_in_two_groups() -> None:
    """The struck four stay together: 4 v' + v'' = 1 and v' - v'' = 1."""
    after, _ = struck(row([1.0] * 5, 1.0), [1.0, 0.0, 0.0, 0.0, 0.0])
    assert after == pytest.approx([-0.6, 0.4, 0.4, 0.4, 0.4], abs=EXACT)


@pytest.mark.parametrize("thrown", [1, 2, 3, 4])
def test_a_cradle_throws_as_many_balls_as_strike_it(thrown: int) -> None:
    before = [1.0] * thrown + [0.0] * (5 - thrown)
    after, impact = struck(row([1.0] * 5, 1.0, law="sequential"), before)
    assert after == pytest.approx(before[::-1], abs=EXACT)
    assert impact.energy_lost == pytest.approx(0.0, abs=EXACT)


@pytest.mark.parametrize(("e", "f"), [(1.0, 1.0), (0.9, 0.8), (0.8, 0.7)])
def test_a_cannon_of_two_balls(e: float, f: float) -> None:
    """3 kg below 1 kg fall with 1 m/s: the lower one leaves the floor with e, then they meet.

    Relative to each other they approach with 1 + e and part with f (1 + e), while the momentum
    3 e - 1 stays. Without losses the lower one stands still and the upper one leaves with twice the
    speed, to four times the height. By Newton's law at once both leave with e.
    """
    part = f * (1.0 + e)
    below = (3.0 * e - 1.0 - part) / 4.0
    assert below >= 0.0
    after, impact = struck(row([3.0, 1.0], [e, f], wall=True, law="sequential"), [-1.0, -1.0])
    assert after == pytest.approx([below, below + part], abs=EXACT)
    kept = (3.0 * below**2 + (below + part) ** 2) / 2.0
    assert impact.energy_lost == pytest.approx(2.0 - kept, abs=4.0 * EXACT)
    after, _ = struck(row([3.0, 1.0], [e, f], wall=True), [-1.0, -1.0])
    assert after == pytest.approx([e, e], abs=EXACT)


def test_a_lower_ball_that_is_thrown_back_strikes_the_floor_again() -> None:
    """1 kg below 3 kg: the lower one leaves with 1, comes back with 2, and that again.

    Pairs without losses reflect: (1, -1) to (-2, 0), floor, (2, 0) to (-1, 1), floor, (1, 1).
    """
    machine = row([1.0, 3.0], 1.0, wall=True, law="sequential")
    after, impact = struck(machine, [-1.0, -1.0])
    assert after == pytest.approx([1.0, 1.0], abs=EXACT)
    assert {
        "s0": pytest.approx(8.0, rel=EXACT), "s1": pytest.approx(6.0, rel=EXACT)
    } == impact.P_N  # fmt: skip


@pytest.mark.parametrize("e", [1.0, 0.7])
@pytest.mark.parametrize(
    "masses", [[8.0, 4.0, 2.0, 1.0], [5.0, 4.0, 1.0], [9.0, 5.0, 2.0, 1.0, 0.3]]
)
def test_a_row_of_falling_masses_passes_the_impulse_once(masses: list[float], e: float) -> None:
    """u <- (1 + e) m u / (m + n) from ball to ball, and each keeps (m - e n) u / (m + n).

    What is kept rises along the row, so that nobody strikes twice.
    """
    kept, speed = [], 1.0
    for mass, following in pairwise(masses):
        kept.append((mass - e * following) * speed / (mass + following))
        speed *= (1.0 + e) * mass / (mass + following)
    wanted = [*kept, speed]
    assert np.diff(wanted).min() > 0.0
    before = [1.0, *[0.0] * (len(masses) - 1)]
    after, _ = struck(row(masses, e, law="sequential"), before)
    assert after == pytest.approx(wanted, abs=EXACT)


@pytest.mark.parametrize("e", [0.0, 0.05])
def test_strikes_without_an_end_take_their_limit(e: float) -> None:
    """Of three equal balls with e < 7 - 4 sqrt(3) = 0.072 the middle one goes to and fro for ever.

    All end with the common speed of 1/3; what is left is 1e-13 of the first approach.
    """
    after, impact = struck(row([1.0, 1.0, 1.0], e, law="sequential"), [1.0, 0.0, 0.0])
    assert np.diff(after).tolist() == [0.0, 0.0]
    assert after == pytest.approx([1.0 / 3.0] * 3, abs=1e-12)
    assert impact.energy_lost == pytest.approx(1.0 / 3.0, abs=1e-12)


def test_strikes_that_get_no_slower_are_refused() -> None:
    """A ball without losses that touches a wall on either side goes to and fro for ever."""
    sides = [{"joint": "x", "restitution": 1.0, "side": side} for side in ("lower", "upper")]
    sides[1]["at_mm"] = 1e-9
    mechanism = machine(
        [link("ball"), slide("x", "frame", "ball")], 1, simultaneous="sequential",
        stops=dict(zip(("left", "right"), sides, strict=True)),
    )  # fmt: skip
    system = System(mechanism, ShaftMotion(mechanism, 1.0, 0.0))
    with pytest.raises(ImpactError, match="left, right still pass to and fro"):
        solve_impact(system, np.zeros(1), np.array([-1.0]), np.empty((0, 1)), mechanism.stops)


def mirrored(masses: Sequence[float], e_N: Sequence[float], speeds: Sequence[float], law: str):
    """Velocities after of a row and, back to front, of its mirror image."""
    one, _ = struck(row(masses, e_N, law=law), speeds)
    other, _ = struck(row(masses[::-1], e_N[::-1], law=law), [-speed for speed in speeds[::-1]])
    return one, -other[::-1]


@pytest.mark.parametrize("law", ["newton", "sequential"])
@pytest.mark.parametrize("seed", range(8))
def test_mirrored_rows_do_the_same(law: str, seed: int) -> None:
    """Tied ones, too: of the first kind the row is its own mirror image, struck from both ends."""
    rng = np.random.default_rng(seed)
    half, e_half = rng.uniform(0.5, 3.0, 3), rng.uniform(0.4, 1.0, 3)
    if seed % 2:
        masses, e_N = [*half, *half[::-1]], [*e_half[:2], e_half[2], *e_half[1::-1]]
        speeds = [1.0, 0.3, 0.0, 0.0, -0.3, -1.0]
    else:
        masses, e_N = [*half, 1.0, 2.0], [*e_half, 0.9]
        speeds = [1.0, 0.0, 0.0, 0.0, -0.4]
    one, other = mirrored(masses, e_N, speeds, law)
    assert one == pytest.approx(other, abs=EXACT)
    if seed % 2:
        assert one == pytest.approx(-one[::-1], abs=EXACT)
    momentum = np.array(masses) @ speeds
    assert np.array(masses) @ one == pytest.approx(momentum, abs=10.0 * EXACT)
    assert np.diff(one).min() >= 0.0


@pytest.mark.parametrize("law", ["newton", "sequential"])
@pytest.mark.parametrize("faint", [1e-3, 1e-14])
def test_parts_that_do_not_touch_are_struck_as_if_alone(law: str, faint: float) -> None:
    """A row and a ball beside it, slower by 1e14: each has the bits that it has alone."""
    balls = {f"s{i}": {"joint": f"z{i}", "restitution": 0.5} for i in (0, 1)}
    parts = [
        link("low", 3.0), slide("z0", "frame", "low", (0.0, 1.0)),
        link("high", 1.0), slide("z1", "low", "high", (0.0, 1.0)),
        link("beside", 2.0), slide("z2", "frame", "beside", (0.0, 1.0)),
    ]  # fmt: skip
    beside = {"s2": {"joint": "z2", "restitution": 0.25}}
    both = machine(parts, 3, simultaneous=law, stops={**balls, **beside})
    _, alone = struck(row([3.0, 1.0], 0.5, wall=True, law=law), [-1.0, -1.0])
    system = System(both, ShaftMotion(both, 1.0, 0.0))
    v = np.array([-1.0, 0.0, -faint])
    impact = solve_impact(system, np.zeros(3), v, np.empty((0, 3)), both.stops)
    assert impact.v_after.tolist() == [*alone.v_after, 0.25 * faint]
    assert {**alone.P_N, "s2": pytest.approx(2.5 * faint, rel=EXACT)} == impact.P_N
    assert list(impact.P_N) == ["s0", "s1", "s2"]


@pytest.mark.parametrize("law", ["newton", "sequential"])
@pytest.mark.parametrize(("faint", "taken"), [(1e-9, 1.0), (1e-14, 0.0)])
def test_a_stop_beside_a_hard_blow_takes_part_unless_its_rate_is_round_off(
    law: str, faint: float, taken: float
) -> None:
    """A cart that strikes its floor with 1 m/s carries a block that drifts across to a wall."""
    parts = [link("cart", 3.0), slide("z", "frame", "cart", (0.0, 1.0)),
             link("block", 0.5), slide("x", "cart", "block")]  # fmt: skip
    stops = {
        "floor": {"joint": "z", "restitution": 0.5},
        "wall": {"joint": "x", "restitution": 0.25},
    }
    both = machine(parts, 2, simultaneous=law, stops=stops)
    system = System(both, ShaftMotion(both, 1.0, 0.0))
    v = np.array([-1.0, -faint])
    impact = solve_impact(system, np.zeros(2), v, np.empty((0, 2)), both.stops)
    assert impact.v_after == pytest.approx([0.5, 0.25 * faint * taken], rel=EXACT)
    wall = pytest.approx(taken * 0.5 * 1.25 * faint, rel=EXACT)
    assert {"floor": pytest.approx(3.5 * 1.5, rel=EXACT), "wall": wall} == impact.P_N


@pytest.mark.parametrize("law", ["newton", "sequential"])
@pytest.mark.parametrize("wall", [False, True])
def test_forty_balls_keep_momentum_and_energy(law: str, wall: bool) -> None:
    """With a wall the momentum changes by its impulse; without losses the energy stays.

    2^40 sets of stops could not be tried. Forty balls strike a thousand times, 3 eps each.
    """
    masses = np.random.default_rng(3).uniform(0.5, 2.0, 40)
    before = -np.ones(40) if wall else np.eye(40)[0]
    after, impact = struck(row(masses.tolist(), 1.0, wall=wall, law=law), before.tolist())
    given = impact.P_N["s0"] if wall else 0.0
    assert masses @ (after - before) == pytest.approx(given, abs=1e-11)
    kept = masses @ after**2 / 2.0 + impact.energy_lost
    assert kept == pytest.approx(masses @ before**2 / 2.0, abs=1e-11)
    if law == "sequential" or wall:
        assert impact.energy_lost == pytest.approx(0.0, abs=1e-11)
    assert np.diff(after).min() >= -1e-13
