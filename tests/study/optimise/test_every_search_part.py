"""Parts of a search for an optimum: samples, starts, merits, counts, of polynomials."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from polynomial_problem import Quantities, Source, problem
from scipy.stats import qmc

from nipper_pin.errors import InputError
from nipper_pin.study.optimise import run
from nipper_pin.study.optimise.problem.problem import Aim, Limit, read_text
from nipper_pin.study.optimise.search import binding, descend, front, infeasible
from nipper_pin.study.optimise.search import samples as search
from nipper_pin.study.optimise.search.descend import Descent
from nipper_pin.study.optimise.search.samples import Seen
from nipper_pin.study.optimise.search.trace import Scales
from nipper_pin.study.optimise.work import Work

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


def seen(z: tuple[float, float], aim: float = 1.0, time: float = 2.0, why: str = "") -> Seen:
    values = {} if why else {AIM: aim, TIME: time, "closing_index": 33.0}
    slacks = () if why else (3.0 - time, time - 1.0)
    return Seen(z=z, values=values, slacks=slacks, engine="" if why else "direct", why=why)


def test_scales_of_a_problem() -> None:
    """The spread of what is usable; the largest value where there is none; one index."""
    asking = problem(*LIMITS, Limit(quantity="closing_index", side="high", value=34.0))
    looked = [seen((0, 0), 1.0, 2.0), seen((0, 1), 0, 0, "no"), seen((1, 0), 5.0, 2.0)]
    found = search.scales(asking, asking.aims[0], looked)
    assert found.aim == pytest.approx(2.0)
    assert found.limits == pytest.approx((2.0, 2.0, 1.0))
    same = [seen((0, 0), 0.0, 2.0), seen((1, 0), 0.0, 2.0 + 3e-6)]
    found = search.scales(asking, asking.aims[0], same)
    assert found.aim == 1e-12
    assert found.limits[0] == pytest.approx(2.0 + 3e-6)
    tight = search.scales(asking, asking.aims[0], [seen((0, 0), 1, 2.0), seen((1, 0), 1, 2 + 5e-6)])
    assert tight.limits[0] == pytest.approx(2.5e-6, rel=1e-6)


def test_starts_of_descents() -> None:
    """The own values first, then the best that are apart by more than 0.15, then any."""
    looked = [
        seen((0.5, 0.5), 9.0), seen((0.5, 0.66), 3.0), seen((0.5, 0.6), 1.0),
        seen((0.1, 0.1), 4.0, 3.5), seen((0.9, 0.9), 5.0), seen((0.9, 0.8), 4.9, 2.9),
        seen((0.3, 0.9), 0.0, 0.5, "no"), seen((0.2, 0.9), 8.0, 0.25),
    ]  # fmt: skip
    aim = problem().aims[0]
    found = search.begins(looked, aim, SCALES, 20)
    # Violations: 0.5 of 4, 0.75 of 0.5; then what is near to one before.
    assert found == (
        (0.5, 0.5), (0.5, 0.66), (0.9, 0.8), (0.1, 0.1), (0.2, 0.9), (0.5, 0.6), (0.9, 0.9),
    )  # fmt: skip
    assert search.begins(looked, aim, SCALES, 3) == found[:3]
    assert search.begins(looked, Aim(quantity=AIM, sense=-1.0), SCALES, 2) == (
        (0.5, 0.5), (0.9, 0.9),
    )  # fmt: skip
    assert search.begins(looked[6:], aim, SCALES, 3) == ((0.2, 0.9),)
    assert search.begins([seen((0.0, 0.0), why="no"), looked[0]], aim, SCALES, 3) == ((0.5, 0.5),)


def test_samples_of_the_box() -> None:
    """The model's own numbers, taken to the bounds, and 64 points of a Sobol sequence."""
    found = search.samples(problem(), 5)
    assert found[0] == pytest.approx([0.25, 0.25])
    wanted = qmc.Sobol(2, rng=np.random.default_rng(5)).random(64)
    assert found[1:] == pytest.approx(wanted)


@pytest.mark.usefixtures("sources")
def test_merits_of_points() -> None:
    """The scaled aim inside; above all of these the violation, and above that no machine."""
    text = problem(*LIMITS).text()
    assert search.merit(text, SCALES, np.array([0.5, 0.5])) == (pytest.approx(2.25), "direct")
    assert search.merit(text, SCALES, np.array([1.0, 0.0])) == (pytest.approx(1000.125), "direct")
    huge = Scales(2.0, (1e-9, 1e-9))
    assert search.merit(text, huge, np.array([1.0, 0.0])) == (2000.0, "direct")
    assert search.merit(text, SCALES, np.array([3.0, 0.0])) == (1e6, "")
    most = problem(*LIMITS, aims=(Aim(quantity=AIM, sense=-1.0),)).text()
    assert search.merit(most, SCALES, np.array([0.5, 0.5]))[0] == pytest.approx(-2.25)
    (one,) = search.look(text, [(0.5, 0.5)])
    assert (one.z, one.slacks, one.engine, one.why) == ((0.5, 0.5), (1.0, 1.0), "direct", "")
    assert one.values == {AIM: pytest.approx(4.5), TIME: pytest.approx(2.0)}


def test_the_evolution(sources: list[Source], monkeypatch: pytest.MonkeyPatch) -> None:
    """Its best member is the least point of the box, and every point that it saw is counted."""
    monkeypatch.setattr(search, "_GENERATIONS", 12)
    text = problem(*LIMITS).text()
    points: list[int] = []

    def mapper(function: Any, places: Any) -> list[Any]:
        rows = list(places)
        points.append(len(rows))
        return [function(z) for z in rows]

    found = search.evolve(text, SCALES, 4, mapper)
    assert found.feasible
    assert found.z == pytest.approx((0.0, 0.0), abs=0.05)
    assert found.evaluations == sum(points) == len(sources[-1].asked)
    assert found.engines == {"direct": sum(points)}
    # Ten members for each of two numbers, and those that make a Sobol sequence whole.
    assert points[0] == 32
    nowhere = problem(Limit(quantity=TIME, side="low", value=9.0)).text()
    assert not search.evolve(nowhere, Scales(2.0, (4.0,)), 4, mapper).feasible


def test_parts_that_are_counted() -> None:
    """What is known and what is done, after each part; results in the order of the tasks."""
    done: list[str] = []

    def task(name: str) -> Any:
        return lambda: (done.append(name), name)[1]

    calls: list[tuple[int, int]] = []
    with work(calls) as parts:
        first = parts.all([task("a"), task("b")])
        one = parts.one(task("c"))
    assert (first, one) == (["a", "b"], "c")
    assert done == ["a", "b", "c"]
    assert calls == [(0, 2), (1, 2), (2, 2), (3, 3)]


@pytest.mark.parametrize(
    ("name", "value", "least"),
    [("starts", 0, 1), ("seed", -1, 0), ("points", 1, 2), ("workers", 0, 1)],
)
def test_settings_of_a_search(
    monkeypatch: pytest.MonkeyPatch, name: str, value: int, least: int
) -> None:
    """The least that can be used is used; one less is refused before anything is done."""
    monkeypatch.setattr(run, "Work", lambda *_: pytest.fail("begun"))
    with pytest.raises(InputError, match=f"{name} = {value} .* from {least} to") as caught:
        run.optimise(problem(), **{name: value})  # type: ignore[arg-type]
    assert (caught.value.evidence["key"], caught.value.evidence["value"]) == (name, value)
    run._check_arguments(**{"starts": 1, "seed": 0, "points": 2, "workers": None})


def test_what_the_global_check_brings() -> None:
    """Its descent takes the place of the best one if it is better, by a part of the larger aim."""

    def descent(aim: float, violation: float = 0.0) -> Descent:
        return Descent(start=(0.0,), z=(aim,), aim=aim, violation=violation, evaluations=1,
                       failures=0, engines={}, converged=True)  # fmt: skip

    one, two = descent(4.0), descent(6.0)
    for polished, best, gain in (
        (descent(3.0), 3.0, 0.25), (descent(5.0), 4.0, 0.0), (None, 4.0, 0.0),
        (descent(-8.0), -8.0, 1.5), (descent(1.0, 0.1), 4.0, 0.0),
    ):  # fmt: skip
        asked: Any = type("Search", (), {
            "problem": problem(), "descents": lambda *_: (one, two),
            "check": lambda *_, polished=polished: ("found", polished),
        })()  # fmt: skip
        led = run._searched(asked, check=True, points=3)
        assert (led.best.aim, led.gain, led.found) == (best, pytest.approx(gain), "found")
        assert led.descents == (one, two)
        assert led.front == ()
        assert led.every == [one, two, *([] if polished is None else [polished])]
        assert run._searched(asked, check=False, points=3).best is one
