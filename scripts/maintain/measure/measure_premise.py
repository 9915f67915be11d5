"""Is a premise that is called true always true? Random transitions against simulated turns.

    python scripts/maintain/measure/measure_premise.py --cases 1000 --seed 1

For each case both engines say whether the machine arrives at the touch as a transition assumes. The
judge shares neither the tables of the reduced engine nor the way in which a solution follows its
own end: it simulates two turns from the jaw wide open, computes both, and reads the second. A
transition that differs from that by more than their stated errors must not be called true; exit
status 1 if one is.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from nipper_pin.arrays import FloatArray
from nipper_pin.errors import NipperError
from nipper_pin.hybrid import Case, EventKind, Solution, Window, simulate
from nipper_pin.mechanism import Mechanism, load, retuned
from nipper_pin.reduced import reduced_model, transitions

_NAMES = {True: "true", False: "false", None: "null"}
MODELS = ("e62", "e62_identified", "e62_offset_guide")
# Cases of one machine, for which the reduced engine samples its tables once.
GROUP = 25
# One number in so many has the values of the model's file, where most users are.
_PLAIN = 4


@dataclass(frozen=True)
class Drawn:
    """One random transition.

    Attributes:
        model: Name of the model.
        overrides: Numbers that differ from it, without those below.
        speed_rpm: Cylinder speed [r/min].
        restitution: e_N of the jaw.
        stiffness: Spring rate [N/m].
        preload: Deflection in the spring at zero [m].
    """

    model: str
    overrides: tuple[tuple[str, float], ...]
    speed_rpm: float
    restitution: float
    stiffness: float
    preload: float


@dataclass(frozen=True)
class Judged:
    """The stated premise of a transition, and the simulated turn.

    Attributes:
        holds: What the engine said.
        apart: Largest difference from the turn by the sum of both stated errors, of the first
            approach rate, the first rebound and the duration; infinite where the turn has none.
    """

    drawn: Drawn
    engine: str
    holds: bool | None
    apart: float

    @property
    def wrong(self) -> bool:
        """Called true, and the turn has another transition."""
        return self.holds is True and self.apart > 1.0


@dataclass(frozen=True)
class _Numbers:
    """Numbers of a transition and their stated errors, shape (4,) each."""

    values: FloatArray
    errors: FloatArray


def draw(count: int, seed: int) -> Iterator[tuple[Mechanism, list[Drawn]]]:
    """Random machines with random settings.

    Args:
        seed: The same seed draws the same.

    Yields:
        A machine and its cases.
    """
    random = np.random.default_rng(seed)
    left = count
    while left > 0:
        model = MODELS[int(random.integers(len(MODELS)))]
        overrides = {
            "stops.steeve.restitution": float(random.uniform(0.0, 1.0) ** 2),
            "points.eccentric_pin.radius_mm": float(random.uniform(3.0, 7.0)),
            "points.eccentric_pin.angle_deg": float(random.uniform(120.0, 230.0)),
            "drives.tension.ratio": float(random.uniform(1.8, 2.6)),
        }
        if random.integers(_PLAIN) == 0:
            overrides = {"stops.steeve.restitution": overrides["stops.steeve.restitution"]}
        n = min(GROUP, left)
        drawn = [
            Drawn(model, tuple(overrides.items()), *(float(x) for x in row))
            for row in random.uniform(
                (350.0, 0.0, 6000.0, 0.007), (750.0, 0.5, 12000.0, 0.014), (n, 4)
            )
        ]
        try:
            mechanism = load(model, overrides)
        except NipperError:
            continue
        left -= n
        yield mechanism, drawn


def judged(mechanism: Mechanism, drawn: list[Drawn]) -> list[Judged]:
    """Compare the premise of both engines with simulated turns.

    Args:
        mechanism: The machine.
        drawn: Its cases.

    Returns:
        One verdict for each case and engine; none where no transition or turn can be simulated.
    """
    found: list[Judged] = []
    reduced = _reduced(mechanism, drawn)
    for place, one in enumerate(drawn):
        tuned = retuned(
            mechanism,
            restitution={mechanism.transition_stop: one.restitution},
            stiffness=[one.stiffness],
            preload=[one.preload],
        )
        try:
            solution = simulate(tuned, Case(speed_rpm=one.speed_rpm))
            direct = _numbers(solution, 0.0)
            turn = _of_turn(tuned, one.speed_rpm)
            holds = solution.premise_holds
        except NipperError:
            continue
        if direct is not None:
            found.append(Judged(one, "direct", holds, _apart(direct, turn)))
        if (known := reduced[place]) is not None:
            found.append(Judged(one, "reduced", known[0], _apart(known[1], turn)))
    return found


def _apart(one: _Numbers, turn: _Numbers | None) -> float:
    if turn is None:
        return np.inf
    stated = one.errors + turn.errors
    return float((np.abs(one.values - turn.values) / stated).max())


def _of_turn(mechanism: Mechanism, speed_rpm: float) -> _Numbers | None:
    """The first closing of the second turn; None if there is none."""
    case = Case(speed_rpm=speed_rpm, window=Window.CYCLE, cycles=2, reuse_cycles=False)
    turns = simulate(mechanism, case)
    return _numbers(turns, turns.shaft.period)


def _numbers(solution: Solution, begin: float) -> _Numbers | None:
    """Approach rate, amplitude and time of the first rebound, and duration, from a time on."""
    stop = solution.mechanism.transition_stop
    hits = [hit for hit in solution.collisions if hit.stop == stop and hit.t >= begin]
    found = [item for item in solution.transitions if hits and item.t_start == hits[0].t]
    if not found:
        return None
    first = hits[0]
    amplitude, time = first.rebound_amplitude, first.rebound_time
    if amplitude is None or time is None:
        return None
    errors = solution.errors
    own = errors[first.event.number - 1]
    after = errors[min(first.event.number, len(errors) - 1)]
    end = next(
        event
        for event in solution.events[first.event.number :]
        if event.kind is EventKind.REST and stop in event.stops
    )
    relative = max(own.impulse, after.impulse)
    values = (first.approach_rate, amplitude, time, found[0].duration)
    stated = (
        own.impulse * abs(first.approach_rate),
        2.0 * relative * amplitude,
        own.time + after.time + relative * time,
        own.time + errors[end.number - 1].time,
    )
    return _Numbers(np.array(values), np.array(stated) + np.finfo(float).tiny)


def _reduced(mechanism: Mechanism, drawn: list[Drawn]) -> list[tuple[bool | None, _Numbers] | None]:
    """Verdicts and assumed transitions of the reduced engine; nothing of what it cannot have."""
    try:
        batch = transitions(
            reduced_model(mechanism),
            speed_rpm=[one.speed_rpm for one in drawn],
            restitution=[one.restitution for one in drawn],
            stiffness=[one.stiffness for one in drawn],
            preload=[one.preload for one in drawn],
            max_collisions=256,
        )
    except NipperError:
        return [None] * len(drawn)
    told = {1: True, 0: False, -1: None}
    found: list[tuple[bool | None, _Numbers] | None] = []
    for place in range(len(drawn)):
        if batch.status[place] != 0:
            found.append(None)
            continue
        values = (
            batch.approach_rate[place, 0],
            batch.rebound_amplitude[place, 0],
            batch.rebound_time[place, 0],
            batch.duration[place],
        )
        errors = (
            batch.rate_error[place, 0],
            batch.amplitude_error[place, 0],
            batch.rebound_error[place, 0],
            batch.duration_error[place],
        )
        numbers = _Numbers(np.array(values), np.array(errors))
        found.append((told[int(batch.premise[place])], numbers))
    return found


def main() -> int:
    """Measure, and print one table."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--cases", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    found: list[Judged] = []
    tried = 0
    for mechanism, drawn in draw(options.cases, options.seed):
        found += judged(mechanism, drawn)
        tried += len(drawn)
    print(f"{tried} cases, seed {options.seed}")
    print(
        f"{'engine':8} {'called':6} {'cases':>6} {'differ':>7} {'agree':>6} {'worst agreeing':>15}"
    )
    for engine in ("direct", "reduced"):
        for holds, name in _NAMES.items():
            some = [item for item in found if item.engine == engine and item.holds is holds]
            print(_row(engine, name, some))
    wrong = [item for item in found if item.wrong]
    for item in wrong:
        print(f"wrongly called true by {item.engine}, {item.apart:.3g} times stated: {item.drawn}")
    return 1 if wrong else 0


def _row(engine: str, name: str, some: Sequence[Judged]) -> str:
    agree = [item.apart for item in some if item.apart <= 1.0]
    worst = f"{max(agree):.2g}" if agree else "-"
    differ = len(some) - len(agree)
    return f"{engine:8} {name:6} {len(some):6d} {differ:7d} {len(agree):6d} {worst:>15}"


if __name__ == "__main__":
    sys.exit(main())
