"""Parts of a search: where it looks, which engine and machine serve a point, who does the work.

Quantities that are read off a simulated turn, and where its kinematics say the same.
"""

from __future__ import annotations

import math
import sys
import time
from collections.abc import Callable, Iterable
from contextlib import suppress
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from designs import MASS, parameter, problem, study
from driven_machines import follower
from programs import study_text
from scipy.stats import qmc

from nipper_pin import InfeasibleError, InputError, Mechanism, SimulationError, Window, load
from nipper_pin.cli import main
from nipper_pin.mechanism.gallery import GALLERY, drawn
from nipper_pin.study.identify import WorkingCycle, working_cycle
from nipper_pin.study.identify.problem.working_cycle import Phase, unfit
from nipper_pin.study.optimise import optimise
from nipper_pin.study.optimise.control.reading import MOST_TURNS, control_turn, read
from nipper_pin.study.optimise.points import Evaluator, Point
from nipper_pin.study.optimise.points.turn import differs
from nipper_pin.study.optimise.problem.quantities import (
    QUANTITIES,
    check_fit,
    cycle_values,
    lowest,
    thinned,
)
from nipper_pin.study.optimise.search.samples import SHARE, evolve, merit, samples, scales
from nipper_pin.study.optimise.search.stages import screen
from nipper_pin.study.optimise.search.trace import Scales
from nipper_pin.study.optimise.work import Work
from nipper_pin.tolerances.study import QUANTITY_ROUND_OFF

HEAD = f"""
model = "{MASS}"
minimise = "duration_s"
case = {{ speed_rpm = 60.0 }}
[parameters]
"stops.table.restitution" = {{ low = 0.05, high = 0.5 }}
"""
LEAD = '"drives.table.lead_mm_per_turn" = { low = -100.0, high = 100.0 }\n'
E62 = study_text("calm_nipper.toml")
AIM, TIME = "rebound_amplitude_1", "duration_s"


# --- where it looks ------------------------------------------------------------------------------


def test_samples_of_the_box(tmp_path: Path) -> None:
    """The model's own numbers, taken to the bounds, and 64 points of a Sobol sequence.

    They are looked at in shares, and come back in their order.
    """
    found = problem(tmp_path, E62)
    places = samples(found, 5)
    assert places[0] == pytest.approx(np.clip(found.start, 0.0, 1.0))
    assert places[1:] == pytest.approx(qmc.Sobol(1, rng=np.random.default_rng(5)).random(64))
    assert len(places) > SHARE
    seen = screen(found, 5, Work(1, None))
    assert [item.z for item in seen] == [tuple(z) for z in places.tolist()]


def seen(z: tuple[float, float], aim: float = 1.0, time: float = 2.0, why: str = "") -> Point:
    """A sample whose time is to be between 1 and 3 s."""
    values = {} if why else {AIM: aim, TIME: time}
    slacks = () if why else (3.0 - time, time - 1.0)
    owners, engine = tuple(range(len(slacks))), "" if why else "direct"
    return Point(
        z=np.array(z), values=values, rows=np.array(slacks), owners=owners, engine=engine, why=why
    )


def test_scales_of_a_problem(tmp_path: Path) -> None:
    """The spread of what is usable; the largest value where there is none; one index."""
    text = E62 + "[limits]\nduration_s = { high = 3.0 }\nclosing_index = { high = 34.0 }\n"
    found = problem(tmp_path, text)
    looked = [seen((0, 0), 1.0, 2.0), seen((0, 1), 0, 0, "no"), seen((1, 0), 5.0, 2.0)]
    by = scales(found, found.aims[0], looked)
    assert (by.aim, by.limits) == (pytest.approx(2.0), pytest.approx((2.0, 1.0)))


def test_a_global_check_goes_to_the_best_of_the_box(tmp_path: Path) -> None:
    """Any point inside the limits before any outside, and these before what is no machine.

    With u = e V the rebound is u^2 / 2 g and the time 2 u / (g (1 - e)), which is least at V = 0.1
    m/s; no table that sinks hits the mass. The check asks for these values instead of simulating.
    """
    found = problem(tmp_path, HEAD + LEAD + "[limits]\nrebound_amplitude_1 = { low = 2e-5 }\n")
    text, by = found.text(), Scales(1e-2, (1e-5,))

    def formula(z: np.ndarray) -> tuple[float, str]:
        e, speed = 0.05 + 0.45 * z[0], 0.2 * z[1] - 0.1
        if speed <= 0.0:
            return 1e6, ""
        height, duration = (e * speed) ** 2 / (2.0 * 9.81), 2.0 * e * speed / (9.81 * (1.0 - e))
        missed = (2e-5 - height) / by.limits[0]
        return (1e3 + missed if missed > 1e-6 else duration / by.aim), "direct"

    for z in (np.array([0.5, 0.95]), np.array([0.1, 0.7]), np.array([0.5, 0.4])):
        value, engine = formula(z)
        assert merit(text, by, z) == (pytest.approx(value, rel=1e-9), engine)

    def evolved(seed: int) -> tuple[Any, list[int]]:
        sizes: list[int] = []

        def mapper(_: Callable[..., Any], places: Iterable[np.ndarray]) -> list[tuple[float, str]]:
            judged = [formula(z) for z in places]
            sizes.append(sum(bool(engine) for _, engine in judged))
            return judged

        return evolve(text, by, seed, mapper), sizes

    (first, machines), (again, _), (other, _) = evolved(1), evolved(1), evolved(2)
    assert first == again
    assert first.z != other.z
    assert first.feasible
    e = np.sqrt(2.0 * 9.81 * 2e-5) / 0.1
    assert first.z == pytest.approx(((e - 0.05) / 0.45, 1.0), abs=0.02)
    assert first.engines == {"direct": sum(machines)}
    assert first.evaluations > sum(machines)
    assert not evolve(text, by, 1, lambda _, places: [(2e3, "direct") for _ in places]).feasible


# --- which engine computes -----------------------------------------------------------------------


RATIO = '"drives.tension.ratio" = { low = 2.1, high = 2.3 }\n'
ONCE = "one machine: its tables are sampled once"


@pytest.mark.parametrize(
    ("text", "engine", "why"),
    [
        (E62, "reduced", ONCE),
        # The tables are there, and do not know a mass that is thrown up by a winding drive.
        (HEAD, "direct", ONCE),
        # At 1,200 r/min no transition begins as it is assumed to.
        (E62.replace("650.0", "1200.0"), "reduced_turn", ONCE),
        (E62 + RATIO, "direct", "drives.tension.ratio change the machine, and so the tables"),
    ],
)
def test_points_are_named_by_the_engine_that_computed_them(
    text: str, engine: str, why: str, tmp_path: Path
) -> None:
    source = Evaluator(found := problem(tmp_path, text))
    assert source.at(found.start).engine == engine
    assert source.transitions.why == why


def test_a_search_without_numba(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "numba", None)
    source = Evaluator(problem(tmp_path, E62))
    assert source.transitions.why == "the reduced engine needs numba, which is not installed"


# --- who does the work ---------------------------------------------------------------------------


def late(pause: float, answer: int) -> int:
    """A task that another process can find."""
    time.sleep(pause)
    return answer


@pytest.mark.parametrize("workers", [1, pytest.param(2, marks=pytest.mark.slow)])
def test_parts_of_a_search(workers: int) -> None:
    """In their order whoever ends first, and counted as they end."""
    told: list[tuple[int, int]] = []
    with Work(workers, lambda done, known: told.append((done, known))) as work:
        assert work.all([partial(late, 0.4, 7), partial(late, 0.0, 11)]) == [7, 11]
        assert told == [(0, 2), (1, 2), (2, 2)]
        assert work.one(lambda: 5) == 5
        assert told[-1] == (3, 3)
        assert work.mapper(abs, [-3, 2]) == [3, 2]


# --- machines of designs, and designs that are none ----------------------------------------------


# Bounds of what may be free: numbers of the drives, links and points are another machine each.
FREE = {
    "drives.tension.ratio": (2.1, 2.3),
    "links.top_nipper.mass_kg": (1.1, 1.3),
    "points.eccentric_pin.radius_mm": (4.9, 5.1),
    "stops.steeve.restitution": (0.1, 0.4),
    "restitution": (0.1, 0.3),
    "stiffness": (8000.0, 10000.0),
    "preload": (9.0, 13.0),
    "speed_rpm": (500.0, 700.0),
}
PROBLEMS = {
    "settings": ["restitution", "stiffness", "preload", "speed_rpm"],
    "all backwards": list(FREE)[::-1],
}


def numbers(mechanism: Mechanism) -> np.ndarray:
    """What the numbers of a design can change, as the engines read it."""
    model = mechanism.model
    parts = [
        *([stop.restitution] for stop in mechanism.stops),
        *([item.stiffness, item.preload] for item in mechanism.springs),
        *(np.ravel(drive.law.evaluate(np.array([0.7]))) for drive in mechanism.drives),
        *([inertia.mass] for inertia in model.inertias),
        *(place.translation for place in model.jointPlacements),
        *(frame.placement.translation for frame in model.frames),
    ]
    return np.concatenate(parts)


@pytest.mark.parametrize("names", PROBLEMS.values(), ids=PROBLEMS)
def test_the_machine_is_that_of_its_numbers(names: list[str], tmp_path: Path) -> None:
    """Each number moved alone, the first design again, and again after more than are kept."""
    bounds = "".join(parameter(name, *FREE[name]) for name in names)
    asked = problem(tmp_path, f'minimise = "duration_s"\n{bounds}')
    source, count = Evaluator(asked), len(names)
    middle = np.full(count, 0.5)
    alone = [middle + 0.25 * unit for unit in np.eye(count)]
    others = list(np.random.default_rng(4).uniform(size=(17, count)))
    for z in (middle, *alone, middle, *others, middle):
        wanted = load(asked.model, asked.overrides(z))
        np.testing.assert_allclose(numbers(source.mechanism(z)), numbers(wanted), atol=1e-15)
        assert asked.speed(z) == asked.numbers(z).get("speed_rpm", asked.speed_rpm)


FALLING = Path(__file__).resolve().parents[2] / "strangers" / "ball_e05"
E_N, WEIGHT = "stops.table.restitution", "links.mass.mass_kg"


def text(model: Path, body: str, **bounds: tuple[float, float]) -> str:
    return f'model = "{model}"\n{body}\n' + "".join(
        parameter(path, *ends) for path, ends in bounds.items()
    )


@pytest.mark.parametrize(
    ("model", "bounds", "advice"),
    [
        # Nothing approaches the floor in the touch configuration, whatever the numbers.
        (FALLING, {"stops.floor.restitution": (0.1, 0.9)}, "the model as it is: stop 'floor' is"),
        # No mass is negative, but that of the model itself is not.
        (MASS, {WEIGHT: (-2.0, -1.0)}, "the model as it is can: put its numbers within the bounds"),
    ],
)
def test_advice_where_no_sample_is_a_machine(
    model: Path, bounds: dict[str, tuple[float, float]], advice: str, tmp_path: Path
) -> None:
    found = problem(tmp_path, text(model, 'minimise = "duration_s"', **bounds))
    with pytest.raises(SimulationError, match=advice) as caught:
        optimise(found, starts=1, check=False, workers=1)
    assert "narrow" not in caught.value.message


def test_reasons_that_differ_in_numbers_are_told_once(tmp_path: Path) -> None:
    """Each sample below zero has another mass, and all of them the same reason."""
    body = text(MASS, 'minimise = "duration_s"', **{E_N: (0.1, 0.5), WEIGHT: (-1.0, 1.0)})
    found = optimise(problem(tmp_path, body), starts=1, check=False, workers=1)
    (reason,) = found.no_machine
    assert "mass" in reason


def test_the_bound_that_is_in_the_way_is_named(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """No rebound is a metre high, and the highest is that of the largest restitution.

    A limit that is kept is not told.
    """
    body = (
        'minimise = "duration_s"\n'
        "limits = { rebound_amplitude_1 = { low = 1.0 }, duration_s = { high = 10.0 } }"
    )
    file = study(tmp_path, text(MASS, body, **{E_N: (0.1, 0.5)}))
    with pytest.raises(InfeasibleError) as caught:
        optimise(file, starts=1, check=False, workers=1)
    (broken,) = caught.value.evidence["limits"]  # type: ignore[misc]
    assert broken == {
        "limit": "rebound_amplitude_1 >= 1", "reached": broken["reached"],
        "missed_by": pytest.approx(1.0 - broken["reached"]), "can_be_met_alone": False,
        "missed_by_alone": pytest.approx(broken["missed_by"], rel=1e-3),
    }  # fmt: skip
    # Half of the table's 1.5 m/s is thrown up by v^2 / 2 g.
    assert broken["reached"] == pytest.approx(0.75**2 / (2.0 * 9.81), rel=1e-6)
    assert caught.value.evidence["numbers"] == {E_N: pytest.approx(0.5)}
    command = ["optimise", str(file), "--out", str(tmp_path / "out"), "--workers", "1"]
    assert main([*command, "--starts", "1", "--no-check"]) == 1
    advice = f"Relax these limits, or widen the bound {E_N} <= 0.5\n"
    said = capsys.readouterr().err
    assert said.endswith(advice)
    assert "breaks rebound_amplitude_1 >= 1: " in said
    assert "duration_s <= 10" not in said


@pytest.mark.parametrize(
    ("speed", "why"),
    [
        # Its bounces outlast the time in which it is pressed shut; faster still, it never arrives.
        (1600.0, "the simulated turn has no duration_s"),
        (2500.0, "the stop jaw is not hit in the simulated turn"),
    ],
)
def test_a_turn_without_a_transition(speed: float, why: str) -> None:
    """What it lacks is named, and its speed is read all the same."""
    turn = control_turn(load("e62"), speed, None)
    assert read(turn, "speed_rpm").value == pytest.approx(speed)
    for name in ("duration_s", "closing_index", "stop_force_N"):
        with pytest.raises(SimulationError) as caught:
            read(turn, name)
        if name == "duration_s":
            assert caught.value.message == why
            assert caught.value.evidence == {"stop": "jaw"}


def thrown() -> Mechanism:
    """A mass on a table that goes down twice a turn, faster than anything falls; no bounces."""
    made = follower({"law": "fourier", "cosine": [0.0, -0.3]}, sprung=False)
    return replace(made, stops=(replace(made.stops[0], restitution=0.0),))


@pytest.mark.parametrize(
    ("make", "speed", "why"),
    [
        (thrown, 230.0, "the stop cam closes more than once in a turn"),
        (lambda: drawn("film_claw").mechanism(), 600.0, "the stop claw does not open again"),
    ],
)
def test_turns_that_have_no_working_cycle(
    make: Callable[[], Mechanism], speed: float, why: str
) -> None:
    with pytest.raises(SimulationError, match=why):
        read(control_turn(make(), speed, None), "opening_index")


@pytest.mark.parametrize(("model", "turns"), [("e62", MOST_TURNS), (MASS, 1)], ids=str)
def test_turns_that_are_simulated(model: str | Path, turns: int) -> None:
    """From a quarter of a turn before the touch: until they repeat, or one if drives wind on."""
    mechanism = load(model)
    cylinder = mechanism.cylinder
    touch = cylinder.index_from_angle(cylinder.angle_at_touch_rad)
    found = control_turn(mechanism, 60.0, 1e-4)
    case = found.solution.case
    assert (case.speed_rpm, case.window, case.rest_rate) == (60.0, Window.CYCLE, 1e-4)
    assert case.start_index == pytest.approx(touch - 10.0)
    assert found.repeats
    assert found.number == case.cycles == turns


@pytest.mark.sampled(5)
@pytest.mark.parametrize("name", ["e62", "e62_offset_guide", "hanging_pendulum", *GALLERY])
def test_kinematics_and_turn_have_one_window(name: str) -> None:
    """Forces and travels of a cycle are those of the turn, where no stop bounces too long.

    Off by no more than what every second sample of the kinematics changes, and half of those of
    the turn; of a smooth curve either is several times the error of all samples.
    """
    mechanism = drawn(name).mechanism() if name in GALLERY else load(name)
    speed, asked = mechanism.cylinder.rated_speed_rpm, []
    for quantity, item in QUANTITIES.items():
        if item.source == "cycle":
            with suppress(InputError):
                check_fit([quantity], mechanism, name)
                asked.append(quantity)
    assert bool(asked) is (unfit(mechanism) is None)
    if not asked:
        return
    cycle, turn = working_cycle(mechanism, speed), control_turn(mechanism, speed, None)
    found, coarse = cycle_values(cycle), cycle_values(thinned(cycle))
    for quantity in asked:
        if differs(cycle, read(turn, "duration_s").value, frozenset({quantity})):
            continue
        seen, value = read(turn, quantity), found[quantity]
        error = abs(value - coarse[quantity]) + QUANTITY_ROUND_OFF * abs(value) + seen.error
        assert seen.value == pytest.approx(value, rel=0.0, abs=error), quantity


def cycle(least: float = 5.0, stop_force: float = 5.0, top: float = 20.0) -> WorkingCycle:
    """At 600 r/min a rest after 10 ms is 4 of 40 indices after the touch at 10."""
    at = np.linspace(10.0, 34.0, 25)
    clamping = Phase(at, 0.01 - 1e-5 * (at - top) ** 2, least + (at - 22.0) ** 2)
    waiting = Phase(at - 24.0, 0.2 - 1e-4 * (at - 24.0) ** 2, stop_force + (at - 16.0) ** 2)
    return WorkingCycle(600.0, 10.0, 34.0, waiting, clamping, 77.0)


@pytest.mark.parametrize(
    ("made", "duration", "asked", "word"),
    [
        (cycle(), 0.0149, ("clamping_force_N",), ""), (cycle(least=-0.01), 0.0, (), "closed stop"),
        (cycle(least=0.01), 0.0, (), ""),
        (cycle(stop_force=-0.01), 0.0, ("jaw_opening_deg",), "initial phase"),
        (cycle(stop_force=-0.01), 0.0, ("clamping_force_N",), ""),
        # The middle half begins at 16, 6 indices or 15 ms after the touch.
        (cycle(), 0.0151, ("clamping_force_N",), "middle half"), (cycle(), 0.0151, (), ""),
        # The sample before the widest one, at 20: 9 indices or 22.5 ms after the touch.
        (cycle(), 0.0224, ("stroke_mm",), ""), (cycle(), 0.0226, ("stroke_mm",), "stroke is"),
        (cycle(), 0.0226, ("jaw_opening_deg",), ""),
        (cycle(top=5.0), 0.0001, ("stroke_mm",), "stroke is"),
    ],
)  # fmt: skip
def test_where_turns_differ_from_kinematics(
    made: WorkingCycle, duration: float, asked: tuple[str, ...], word: str
) -> None:
    said = differs(made, duration, frozenset(asked))
    assert (word in said) if word else (said == "")


def test_least_values_of_intervals() -> None:
    """A cosine of 48 samples: its bottom between two of them to h^4 / 384, and ends elsewhere.

    h = 2 pi / 47, so 1e-6; the samples alone miss it by up to h^2 / 8 = 2e-3.
    """
    t = np.linspace(0.3, 0.3 + 2.0 * math.pi, 48)
    found = lowest(t, np.cos(t))
    place = int(np.searchsorted(t, math.pi)) - 1
    assert found[place] == pytest.approx(-1.0, abs=2e-6)
    ends = np.minimum(np.cos(t)[:-1], np.cos(t)[1:])
    np.testing.assert_array_equal(np.delete(found, place), np.delete(ends, place))
