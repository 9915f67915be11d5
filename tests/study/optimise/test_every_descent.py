"""Descents to optima, their prices, fronts and failures, of quantities that are polynomials."""

from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from polynomial_problem import HIGH, LOW, Quantities, Source, problem

from nipper_pin.errors import InfeasibleError
from nipper_pin.study.optimise import design as design_module
from nipper_pin.study.optimise.points.point import Point
from nipper_pin.study.optimise.problem.problem import Aim, Limit, read_text
from nipper_pin.study.optimise.search import binding, descend, front, infeasible
from nipper_pin.study.optimise.search import samples as search
from nipper_pin.study.optimise.search.trace import Scales, Trace
from nipper_pin.study.optimise.work import Work
from nipper_pin.tolerances.study import DESIGN_STEP

AIM, TIME = "rebound_amplitude_1", "duration_s"
SCALES = Scales(2.0, (4.0, 0.5))
LIMITS = (Limit(quantity=TIME, side="high", value=3.0), Limit(quantity=TIME, side="low", value=1.0))
VALUES: Quantities = {
    AIM: lambda z: 2.0 + 3.0 * z[0] + 4.0 * z[1] ** 2,
    TIME: lambda z: 1.5 + 2.0 * z[0] - z[1],
}


@pytest.fixture(name="sources")
def polynomials(monkeypatch: pytest.MonkeyPatch) -> list[Source]:
    """Every evaluator that is made, of the quantities above or of those that are given."""
    made: list[Source] = []

    def evaluator(text: bytes) -> Source:
        if not made or made[-1].problem.text() != text:
            made.append(Source(read_text(text), VALUES))
        return made[-1]

    for module in (descend, search):
        monkeypatch.setattr(module, "evaluator", evaluator)
    for module in (binding, front, infeasible):
        monkeypatch.setattr(module, "Evaluator", lambda asking: Source(asking, VALUES))
    return made


def work(calls: list[tuple[int, int]] | None = None) -> Work:
    progress = None if calls is None else lambda *counts: calls.append(counts)
    return Work(1, progress)


def test_derivatives_of_points() -> None:
    """Differences of polynomials up to the second order are exact: central, and one-sided."""
    source: Any = Source(problem(*LIMITS), VALUES, edge=0.5 + 0.5 * DESIGN_STEP)
    trace = Trace(source, SCALES)
    for z in ((0.25, 0.5), (0.0, 0.0), (0.5, 1.0)):
        place = np.array(z)
        aim, rows = trace.slopes(place)
        assert aim == pytest.approx([3.0, 8.0 * z[1]], abs=1e-9)
        assert rows == pytest.approx(np.array([[-2.0, 1.0], [2.0, -1.0]]), abs=1e-9)
    asked = len(source.asked)
    assert trace.slopes(np.array([0.25, 0.5]))[0][0] == pytest.approx(3.0)
    trace.at(np.array([0.25, 0.5]))
    assert len(source.asked) == asked == trace.counts[0]
    # Outside of the bounds: the point at them.
    assert trace.at(np.array([-0.5, 2.0])).z.tolist() == [0.0, 1.0]
    failed = sum(z[0] > 0.5 + 0.5 * DESIGN_STEP for z in source.asked)
    assert failed > 0
    assert trace.counts == (len(source.asked), failed)
    assert trace.engines == {"direct": len(source.asked) - failed}
    # Between two edges there is no difference; beside one a single step, of the first order.
    for reach, place, slope in (
        (0.4, 0.0, 0.0),
        (0.6, 0.5, 1.0),
        (1.6, 1.0, 1.0 + 2.0 * DESIGN_STEP),
    ):
        within: Any = Source(problem(), {})
        within.at = lambda z, reach=reach: (
            Point(z=z, values={AIM: z[1] ** 2}, rows=np.zeros(0), owners=())
            if abs(z[1] - 0.5) < reach * DESIGN_STEP
            else Point(z=z, values={}, rows=np.zeros(0), owners=(), why="beyond")
        )
        aim, _ = Trace(within, SCALES).slopes(np.array([0.5, 0.5 + place * DESIGN_STEP]))
        assert aim[1] == pytest.approx(slope, abs=1e-9)


def test_violations_and_the_best_point() -> None:
    """Scaled by their limits; within 1e-6 the aim decides, beyond it the violation."""
    source: Any = Source(problem(*LIMITS), VALUES)
    trace = Trace(source, SCALES)
    inside, high, low = (trace.at(np.array(z)) for z in ((0.5, 0.5), (1.0, 0.0), (0.0, 1.0)))
    assert SCALES.violation(inside) == 0.0
    # 3.5 is 0.5 above 3, of a scale of 4; 0.5 is 0.5 below 1, of a scale of 0.5.
    assert SCALES.violation(high) == pytest.approx(0.125)
    assert SCALES.violation(low) == pytest.approx(1.0)
    assert [SCALES.inside(item) for item in (inside, high, low)] == [True, False, False]
    assert trace.best() == (inside, 0.0)
    assert high.slacks == pytest.approx((-0.5, 2.5))
    better = trace.at(np.array([0.25, 0.0]))
    assert trace.best() == (better, 0.0)
    largest: Any = Trace(Source(problem(aims=(Aim(quantity=AIM, sense=-1.0),)), VALUES), SCALES)  # type: ignore[arg-type]
    assert largest.aim(high) == pytest.approx(-5.0)
    for beyond, within in ((0.9e-6, True), (1.1e-6, False)):
        near = trace.at(np.array([0.75 + 2.0 * beyond, 0.0]))
        assert SCALES.inside(near) is within
    only: Any = Trace(Source(problem(*LIMITS), VALUES), SCALES)  # type: ignore[arg-type]
    first, second = only.at(np.array([1.0, 0.0])), only.at(np.array([0.9, 0.0]))
    assert only.best() == (second, pytest.approx(0.075))
    assert first is not second


def test_a_descent_and_its_price(sources: list[Source]) -> None:
    """Least 2 + 3 x + 4 y^2 with 1.5 + 2 x - y at least 2.5.

    More of y asks for more of x, so the bound y = 0 holds, and x = 1/2. There the gradient
    (3, 0) is 1.5 times that of the limit, (2, -1), and 1.5 times that of the bound, (0, 1): by
    one second more the rebound rises by 1.5, and by the bound's unit, of a range of 2, by 0.75.
    """
    asking = problem(Limit(quantity=TIME, side="low", value=2.5))
    by = Scales(2.0, (0.5,))
    found = descend.descend(asking.text(), by, (0.9, 0.4))
    assert found.start == (0.9, 0.4)
    assert found.z == pytest.approx((0.5, 0.0), abs=1e-6)
    assert found.aim == pytest.approx(3.5, abs=1e-5)
    assert found.violation <= 1e-6
    assert (found.feasible, found.converged, found.failures) == (True, True, 0)
    assert found.rank == (0.0, found.aim)
    assert found.evaluations == len(sources[-1].asked) == found.engines["direct"]
    account = binding.account(asking, by, (0.5, 0.0))
    limit, bound = account.bindings
    assert (limit.name, limit.kind, limit.active) == ("duration_s >= 2.5", "limit", True)
    assert (limit.value, limit.slack, limit.price) == pytest.approx((2.5, 0.0, 1.5), abs=1e-8)
    assert (bound.name, bound.kind, bound.active) == ("two >= -1", "bound", True)
    assert (bound.value, bound.slack, bound.price) == pytest.approx((-1.0, 0.0, 0.75), abs=1e-8)
    assert account.residual == pytest.approx(0.0, abs=1e-9)
    loose = binding.account(problem(LIMITS[0]), Scales(2.0, (4.0,)), (0.5, 1.0 - 0.9e-4))
    limit, bound = loose.bindings
    assert (limit.active, limit.price, limit.slack) == (False, 0.0, pytest.approx(1.5 - 0.9e-4))
    assert (bound.name, bound.price) == ("two <= 1", 0.0)
    assert bound.slack == pytest.approx(2.0 * 0.9e-4)
    # Nothing active explains the gradient (3, 8), nor a part of it.
    assert loose.residual == pytest.approx(1.0)
    free = binding.account(problem(LIMITS[0]), Scales(2.0, (4.0,)), (0.5, 1.0 - 1.1e-4))
    assert len(free.bindings) == 1
    assert free.residual == pytest.approx(1.0)


@pytest.mark.parametrize("go_down", [descend.descend, descend.restore])
@pytest.mark.parametrize("start", [(0.5, 0.3), (0.3, 0.6)])
def test_descents_that_end_at_an_edge(
    monkeypatch: pytest.MonkeyPatch, go_down: Any, start: tuple[float, float]
) -> None:
    """The limit asks for more of x, and beyond x = 1/2 there is no machine: the edge is nearest."""
    limit = Limit(quantity=TIME, side="low", value=3.5)
    values: Quantities = {AIM: lambda z: z[1], TIME: lambda z: 1.5 + 2.0 * z[0]}
    edged: Any = Source(problem(limit), values, edge=0.5)
    monkeypatch.setattr(descend, "evaluator", lambda _: edged)
    found = go_down(problem(limit).text(), Scales(1.0, (1.0,)), start)
    assert found.z[0] == pytest.approx(0.5, abs=1e-4)
    assert found.violation == pytest.approx(1.0, abs=2e-4)
    assert not found.feasible


def test_a_front_goes_around_a_gap(monkeypatch: pytest.MonkeyPatch) -> None:
    """Halfway between the best by either aim there is no machine: no descent begins there."""
    aims = (Aim(quantity=AIM, sense=1.0), Aim(quantity=TIME, sense=-1.0))
    values: Quantities = {AIM: lambda z: z[0] ** 2 + z[1], TIME: lambda z: z[0] + z[1]}

    class Gap(Source):
        def at(self, z: np.ndarray) -> Point:
            point = super().at(z)
            lost = abs(z[0] - 0.5) + abs(z[1] - 0.5) < 0.1
            return replace(point, values={}, why="in the gap") if lost else point

    made: Any = Gap(problem(aims=aims), values)
    monkeypatch.setattr(front, "Evaluator", lambda _: made)
    monkeypatch.setattr(descend, "evaluator", lambda text: Gap(read_text(text), values))
    scales = Scales(1.0, ())
    one, two = (descend.descend(problem(aims=(aim,)).text(), scales, (0.2, 0.9)) for aim in aims)
    assert (one.z, two.z) == (pytest.approx((0.0, 0.0), abs=1e-6), pytest.approx((1.0, 1.0)))
    with work() as parts:
        places, descents = front.front(problem(aims=aims), (scales, scales), (one, two), 3, parts)
    # Two steps: from three places, the middle of which is in the gap at the first one.
    assert len(descents) == 2 + 3
    # The least x^2 + y with x + y held to 1 has x = 1/2, beside the gap; held to 2 it is a corner.
    assert len(places) == 3
    assert sum(places[1]) == pytest.approx(1.0, abs=1e-5)
    assert places[2] == pytest.approx((1.0, 1.0), abs=3e-3)


def test_limits_that_nothing_meets(sources: list[Source]) -> None:
    """The nearest design, what it breaks and by how much, alone and together.

    1.5 + 2 x - y reaches 3.5, and both limits are missed by as little where it is 3.
    """
    limits = (
        Limit(quantity=TIME, side="low", value=4.0),
        Limit(quantity=TIME, side="high", value=2.0),
    )
    asking, by = problem(*limits), Scales(2.0, (0.5, 0.5))
    near = descend.restore(asking.text(), by, (0.2, 0.2))
    assert near.violation == pytest.approx(2.0, abs=1e-6)
    assert not near.feasible
    assert near.rank == (near.violation, near.aim)
    assert sources
    with pytest.raises(InfeasibleError) as caught, work() as parts:
        infeasible.from_feasible_designs(asking, by, [near], parts)
    one, two = caught.value.evidence["limits"]
    assert (one["limit"], two["limit"]) == ("duration_s >= 4", "duration_s <= 2")
    assert one["reached"] == two["reached"] == pytest.approx(3.0, abs=1e-5)
    assert (one["missed_by"], two["missed_by"]) == pytest.approx((1.0, 1.0), abs=1e-5)
    assert (one["can_be_met_alone"], two["can_be_met_alone"]) == (False, True)
    assert one["missed_by_alone"] == pytest.approx(0.5, abs=1e-5)
    assert "missed by 1 s (alone it is still missed by 0.5); duration_s <= 2: 3 is reached, " \
           "missed by 1 s (alone it could be met)" in caught.value.message  # fmt: skip
    numbers = problem().numbers(np.array(near.z))
    assert caught.value.evidence["numbers"] == pytest.approx(numbers, abs=1e-5)
    assert f"the nearest (one = {numbers['one']:.6g}, two = " in caught.value.message
    wide = problem(Limit(quantity=TIME, side="low", value=3.0))
    with work() as parts:
        (again,) = infeasible.from_feasible_designs(wide, Scales(2.0, (0.5,)), [near], parts)
    assert again.feasible
    assert again.aim == pytest.approx(4.25, abs=1e-4)


@pytest.mark.usefixtures("sources")
def test_the_front_of_two_aims() -> None:
    """Least rebound for every time: even steps from the best by one aim to that by the other.

    With y = 0 the rebound is 2 + 3 (t - 1.5) / 2; the last step stops a thousandth short.
    """
    aims = (Aim(quantity=AIM, sense=1.0), Aim(quantity=TIME, sense=-1.0))
    asking, by = problem(aims=aims), (Scales(2.0, ()), Scales(1.0, ()))
    one, two = (
        descend.descend(asking.with_aim(aim).text(), Scales(1.0, ()), (0.4, 0.3)) for aim in aims
    )
    with work() as parts:
        places, descents = front.front(asking, by, (one, two), 5, parts)
    assert len(descents) == 3 * 4
    times = [VALUES[TIME](np.array(z)) for z in places]
    wanted = [1.5, 2.0, 2.5, 3.0, 3.5 - 2e-3]
    assert times == pytest.approx(wanted, abs=2e-5)
    heights = [VALUES[AIM](np.array(z)) for z in places]
    assert heights == pytest.approx([2.0 + 1.5 * (t - 1.5) for t in wanted], abs=1e-4)
    with work() as parts:
        assert front.front(asking, by, (two, two), 5, parts) == ((two.z,), [])
    assert front._beaten((1.0, 2.0), [(1.0, 2.0), (0.5, 3.0), (3.0, 1.0)]) is False
    assert front._beaten((1.0, 2.0), [(1.0, 1.5)]) is True
    assert front._beaten((1.0, 2.0), [(0.5, 2.0)]) is True


def test_designs_as_they_are_reported() -> None:
    source: Any = Source(problem(*LIMITS), VALUES, edge=0.9)
    found = design_module.design(source, SCALES, (0.5, 0.5))
    assert found is not None
    assert found.record() == {
        "numbers": {"one": pytest.approx(12.0), "two": pytest.approx(0.0)},
        "values": {AIM: pytest.approx(4.5), TIME: pytest.approx(2.0)},
        "errors": {AIM: pytest.approx(4.5e-3), TIME: pytest.approx(2e-3)},
        "slacks": pytest.approx([1.0, 1.0]), "inside": True, "holding": [],
        "engine": "direct",
    }  # fmt: skip
    assert found.z == (0.5, 0.5)
    assert design_module.design(source, SCALES, (1.0, 0.5)) is None
    outside = design_module.design(source, SCALES, (0.85, 0.0))
    assert outside is not None
    assert not outside.inside
    assert design_module._finite(math.nan) is None


def test_what_holds_a_design() -> None:
    """Limits with less room than 1e-4 of their scale, 4 and 0.5, and bounds nearer than 1e-4."""
    source: Any = Source(problem(*LIMITS), VALUES)
    high, low = map(str, LIMITS)
    for z, wanted in (
        ((0.5, 0.5), ()),
        # The time is 1.5 + 2 z0 - z1, at most 3 and at least 1.
        ((0.7500 + 0.5 * 0.5 - 0.5 * 3.9e-4, 0.5), (high,)),
        ((0.7500 + 0.5 * 0.5 - 0.5 * 4.1e-4, 0.5), ()),
        ((0.1, 0.7 - 4.9e-5), (low,)),
        ((0.1, 0.7 - 5.1e-5), ()),
        ((0.9e-4, 0.2), (f"one >= {LOW[0]:.6g}",)),
        ((1.1e-4, 0.2), ()),
        ((0.6, 1.0 - 0.9e-4), (f"two <= {HIGH[1]:.6g}",)),
        ((0.6, 1.0 - 1.1e-4), ()),
        # Broken limits, too, and several at once.
        ((1.0, 0.0), (high, f"one <= {HIGH[0]:.6g}", f"two >= {LOW[1]:.6g}")),
    ):
        found = design_module.design(source, SCALES, z)
        assert found is not None
        assert found.holding == wanted


def test_what_cannot_be_simulated_is_far_outside_its_limits(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """To the solver such a point is worse than any other, when limits are mended, too."""
    source: Any = Source(problem(*LIMITS), VALUES)
    trace = Trace(source, SCALES)
    asked: list[Any] = []

    def solver(*words: Any, constraints: Any, **more: Any) -> Any:
        del words, more
        usable = trace.at

        def lost(z: Any) -> Point:
            return replace(usable(z), why="does not close")

        before = constraints[0]["fun"](np.array([0.25, 0.5, 0.0]))
        monkeypatch.setattr(trace, "at", lost)
        asked.extend((before, constraints[0]["fun"](np.array([0.25, 0.5, 0.0]))))
        monkeypatch.setattr(trace, "at", usable)
        return SimpleNamespace(success=True)

    monkeypatch.setattr("scipy.optimize.minimize", solver)
    descend._mend(trace, np.array([0.25, 0.5]))
    inside, outside = asked
    assert (np.abs(inside) < 10.0).all()
    assert (outside <= -100.0 * np.abs(inside).max()).all()
