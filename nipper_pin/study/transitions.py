"""Transitions of many cases of one mechanism, each by the engine that suits it.

The reduced engine solves a transition a hundred times faster than the direct one, but has to sample
its tables first and knows only what they cover. What it cannot do the direct engine does, case by
case, and the result says which engine computed what.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from importlib.util import find_spec
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..arrays import FloatArray
from ..dynamics.system import DriveMode
from ..errors import InputError, NipperError
from ..hybrid.case import Case, Resolution
from ..hybrid.rebound_errors import rebound_error
from ..mechanism import Mechanism, need_mechanism
from ..reduced import ReducedModel, Status, reduced_model, transitions, unfit
from ..reduced import layout as rows
from ..reduced.inputs import check_run
from ..reduced.layout import FAILS, HOLDS, UNKNOWN
from ..reduced.results import CollisionRows
from .cases import Cases, cases_of, spring_values
from .true_transition import TrueTransition, assumed_transition, transition_of_turns

Engine = Literal["auto", "direct", "reduced"]

# Cases from which the reduced engine is worth its start. That costs 50 ms for the tables and, once
# a process, 310 ms for loading compiled code: 60 to 140 direct runs of 2.5 to 6 ms each. A fixed
# number, so that the engine of a case does not depend on what a process did before.
REDUCED_PAYS_FROM = 64
# Cases of one batch, and columns of its table; few cases have more collisions.
_BATCH, _COLUMNS = 4096, 32
FAILED = "failed"
TURN = "turn"
"""Engine of a case for which whole turns were simulated, since the premise does not hold."""
_STATUS = {int(status): status.name.lower() for status in Status}
_PREMISE = {HOLDS: True, FAILS: False, UNKNOWN: None}
_AT_REST, _TOO_MANY = _STATUS[Status.AT_REST], _STATUS[Status.TOO_MANY_COLLISIONS]


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class TransitionTable(CollisionRows):
    """Transitions of n cases; the rows have shape (n, most), NaN beyond the last collision.

    Attributes:
        model: Name of the model.
        why: Why the engine was chosen, and how many cases it left to the other one.
        engine: Engine of each case, "reduced", "direct", or "turn": the direct one on whole turns,
            because the premise of a transition does not hold, shape (n,).
        outcome: How each case ended: "at_rest"; "no_rest" or "too_many_collisions"; "failed"; and,
            if the reduced engine was forced, its :class:`~nipper_pin.reduced.Status` in lower case.
        message: For each case why it failed, or why the reduced engine left it to the direct one;
            empty for all others.
        speed_rpm: Cylinder speed of each case [r/min], shape (n,).
        restitution: e_N of the transition stop, shape (n,).
        stiffness: Spring rates, shape (n, springs) [N/m or N m/rad].
        preload: Deflections in the springs at zero, shape (n, springs) [m or rad].
        collisions: Collisions of the transition stop that were computed, shape (n,).
        duration: Time from the first collision to rest [s], NaN without rest, shape (n,).
        duration_error: Stated error of it [s], shape (n,).
        first_two_share: Share of the first two rebounds in the duration, NaN with fewer,
            shape (n,).
        premise_holds: True or False: whether the machine arrives in its initial phase, as a
            transition assumes; None where it was not asked, shape (n,).
        table: All rows, shape (n, rows, most). The errors are bounds where the reduced engine
            computed and estimates where the direct one did; see ``docs/accuracy.md``.
        mechanism: The mechanism, with the values that no column changes.
    """

    model: str
    why: str
    engine: NDArray[np.str_]
    outcome: NDArray[np.str_]
    message: tuple[str, ...]
    speed_rpm: FloatArray
    restitution: FloatArray
    stiffness: FloatArray
    preload: FloatArray
    collisions: NDArray[np.int64]
    duration: FloatArray
    duration_error: FloatArray
    first_two_share: FloatArray
    premise_holds: NDArray[np.object_]
    table: FloatArray
    mechanism: Mechanism

    def __len__(self) -> int:
        """Number of cases."""
        return len(self.duration)

    def __repr__(self) -> str:
        """One line."""
        from .table_summary import line

        return line(self)

    def _repr_html_(self) -> str:
        from .table_summary import page

        return page(self)

    def to_frame(self, library: str | None = None, *, collisions: int = 2) -> Any:
        """All cases as a data frame: names and units of the JSON document and of study files.

        Args:
            library: "pandas", "polars" or "pyarrow"; by default the first that is installed.
            collisions: Number of collisions that have columns, ``approach_rate_1`` and so on.

        Raises:
            InputError: It is not installed, or a number is out of range.
        """
        from ..frames import data_frame
        from .table_summary import columns

        return data_frame(columns(self, collisions), library)


def transition_table(
    mechanism: Mechanism,
    *,
    speed_rpm: ArrayLike,
    restitution: ArrayLike | None = None,
    stiffness_N_per_m: ArrayLike | None = None,
    preload_length_mm: ArrayLike | None = None,
    stiffness_N_m_per_rad: ArrayLike | None = None,
    preload_deg: ArrayLike | None = None,
    rest_rate: float | None = None,
    tolerance: float = 1e-10,
    max_collisions: int = 256,
    drive: DriveMode = DriveMode.HELD,
    engine: Engine = "auto",
) -> TransitionTable:
    """Compute the transitions of many cases of one mechanism.

    Args:
        mechanism: The mechanism.
        speed_rpm: Cylinder speeds [r/min], a number or shape (n,); so is the restitution.
        restitution: e_N of the transition stop; by default that of the mechanism.
        stiffness_N_per_m: Rates of the springs on slides [N/m], shape (n,) with one such spring or
            (n, such springs), in the order of the mechanism; by default those of the mechanism.
        preload_length_mm: Deflections in these springs at zero [mm], likewise.
        stiffness_N_m_per_rad: Rates of the springs on hinges [N m/rad], likewise.
        preload_deg: Deflections in these springs at zero [deg], likewise.
        rest_rate: None: the limit of the series. A number: rest at the first slower rebound.
        tolerance: Relative accuracy.
        max_collisions: Largest number of collisions of a case.
        drive: Behaviour of the driven shafts.
        engine: "auto": the reduced engine for :data:`REDUCED_PAYS_FROM` cases or more of a
            mechanism that it can represent, the direct one for all others; and whole turns of the
            direct one where the premise of a transition does not hold. "direct" or "reduced": that
            one alone, the transition as it is assumed.

    Returns:
        The table. A case that cannot be simulated is marked in it.

    Raises:
        InputError: A parameter is out of range or has another unit, by its size; or the reduced
            engine is asked for and cannot represent the mechanism.
    """
    need_mechanism(mechanism, "transition_table")
    springs = spring_values(
        mechanism,
        {
            "stiffness_N_per_m": stiffness_N_per_m,
            "preload_length_mm": preload_length_mm,
            "stiffness_N_m_per_rad": stiffness_N_m_per_rad,
            "preload_deg": preload_deg,
        },
    )
    return table_of(
        mechanism,
        cases_of(mechanism, speed_rpm, restitution, *springs),
        rest_rate=rest_rate,
        tolerance=tolerance,
        max_collisions=max_collisions,
        drive=drive,
        engine=engine,
    )


def table_of(
    mechanism: Mechanism,
    cases: Cases,
    *,
    rest_rate: float | None = None,
    tolerance: float = 1e-10,
    max_collisions: int = 256,
    drive: DriveMode = DriveMode.HELD,
    engine: Engine = "auto",
) -> TransitionTable:
    """Compute the transitions of cases; arguments and errors as for :func:`transition_table`."""
    if engine not in ("auto", "direct", "reduced"):
        message = f"engine = {engine!r} cannot be used: auto, direct or reduced"
        raise InputError(message, engine=engine)
    if drive not in set(DriveMode):
        message = f"drive = {drive!r} cannot be used: held or inertial"
        raise InputError(message, drive=drive)
    check_run(rest_rate, tolerance, max_collisions)
    run = _Run(
        mechanism,
        cases,
        DriveMode(drive),
        rest_rate,
        tolerance,
        max_collisions,
        true=engine == "auto",
    )
    model, why = _chosen(mechanism, run.drive, len(cases.speed_rpm), engine)
    left = list(range(len(cases.speed_rpm)))
    if model is not None:
        left = run.reduced(model, keep_all=engine == "reduced")
        if left:
            why += f"; {len(left)} that its tables do not cover: direct"
    for number in left:
        run.direct(number)
    return run.table(why)


def _chosen(
    mechanism: Mechanism, drive: DriveMode, count: int, engine: Engine
) -> tuple[ReducedModel | None, str]:
    """The reduced model, or None for the direct engine, and the reason."""
    if engine == "direct":
        return None, "direct: asked for"
    if engine == "reduced":
        return reduced_model(mechanism, drive), "reduced: asked for"
    reason = unfit(mechanism, drive)
    if reason is not None:
        return None, f"direct: {reason}"
    if count < REDUCED_PAYS_FROM:
        return None, f"direct: the reduced engine pays from {REDUCED_PAYS_FROM} cases on"
    if find_spec("numba") is None:
        return None, "direct: the reduced engine needs numba, which is not installed"
    try:
        return reduced_model(mechanism), f"reduced: {count} cases of one mechanism"
    except NipperError as error:
        return None, f"direct: {error.message}"


class _Run:
    """Results of all cases as they come in."""

    def __init__(
        self,
        mechanism: Mechanism,
        cases: Cases,
        drive: DriveMode,
        rest_rate: float | None,
        tolerance: float,
        max_collisions: int,
        *,
        true: bool,
    ) -> None:
        n = len(cases.speed_rpm)
        self.drive = drive
        self._mechanism, self._cases = mechanism, cases
        self._rest_rate, self._tolerance = rest_rate, tolerance
        self._most = max_collisions
        self._true = true
        self._premise = np.full(n, None, dtype=object)
        self._engine = np.full(n, "direct", dtype="U7")
        self._outcome = np.full(n, FAILED, dtype="U24")
        self._message = [""] * n
        self._collisions = np.zeros(n, dtype=np.int64)
        # Duration, its error, share.
        self._rest = np.full((n, 3), np.nan)
        # Numbers of cases and their rows, which are trimmed to their longest series.
        self._rows: list[tuple[NDArray[np.int64], FloatArray]] = []

    def reduced(self, model: ReducedModel, *, keep_all: bool) -> list[int]:
        """Solve all cases by the reduced engine; returns those that it leaves to the other."""
        chosen = np.arange(len(self._outcome))
        for columns in sorted({min(_COLUMNS, self._most), self._most}):
            for start in range(0, len(chosen), _BATCH):
                self._batch(model, chosen[start : start + _BATCH], columns)
            chosen = np.flatnonzero(self._outcome == _TOO_MANY)
        if keep_all:
            return []
        untold = np.array([told is None for told in self._premise]) & model.arrival.asked
        left = np.flatnonzero((self._outcome != _AT_REST) | untold)
        for number in left:
            reason = str(self._outcome[number])
            if reason == _AT_REST:
                reason = model.arrival.why or "cannot tell how the machine arrives"
            self._message[number] = f"the reduced engine: {reason}"
        return [int(number) for number in left]

    def _batch(self, model: ReducedModel, chosen: NDArray[np.int64], columns: int) -> None:
        batch = transitions(
            model,
            speed_rpm=self._cases.speed_rpm[chosen],
            restitution=self._cases.restitution[chosen],
            stiffness=self._cases.stiffness[chosen],
            preload=self._cases.preload[chosen],
            rest_rate=self._rest_rate,
            tolerance=self._tolerance,
            max_collisions=columns,
            assumed=not self._true,
        )
        self._engine[chosen] = "reduced"
        self._outcome[chosen] = [_STATUS[status] for status in batch.status]
        self._collisions[chosen] = batch.collisions
        self._rest[chosen] = np.stack([batch.duration, batch.duration_error, batch.share], axis=1)
        self._premise[chosen] = [_PREMISE[told] for told in batch.premise]
        most = int(batch.collisions.max(initial=0))
        self._rows.append((chosen, batch.table[:, :, :most].copy()))

    def direct(self, number: int) -> None:
        """Simulate one case by the direct engine."""
        cases = self._cases
        self._engine[number] = "direct"
        self._outcome[number], self._collisions[number] = FAILED, 0
        self._rest[number] = np.nan
        block = np.empty((rows.COLUMNS, 0))
        self._premise[number] = None
        try:
            mechanism = retuned(
                self._mechanism,
                float(cases.restitution[number]),
                cases.stiffness[number],
                cases.preload[number],
            )
            case = Case(
                speed_rpm=float(cases.speed_rpm[number]),
                drive=self.drive,
                rest_rate=self._rest_rate,
                resolution=Resolution(tolerance=self._tolerance),
                max_collisions=self._most,
            )
            found = assumed_transition(mechanism, case)
            if self._true and found.premise_holds is False:
                found = transition_of_turns(mechanism, case, found.solution.premise.why)
                self._engine[number] = TURN
            block = _collision_rows(found)
        except NipperError as error:
            self._message[number] = error.message
        else:
            self._rest[number] = _rest(found)
            self._outcome[number] = found.outcome.name.lower()
            self._collisions[number] = block.shape[1]
            self._message[number] = found.message or self._message[number]
            self._premise[number] = found.premise_holds
        self._rows.append((np.array([number]), block[None]))

    def table(self, why: str) -> TransitionTable:
        """The table of all cases."""
        most = int(self._collisions.max(initial=0))
        table = np.full((len(self._outcome), rows.COLUMNS, most), np.nan)
        for chosen, block in self._rows:
            # A case that was done again has fewer or more collisions than at first.
            width = min(most, block.shape[2])
            table[chosen] = np.nan
            table[chosen, :, :width] = block[:, :, :width]
        duration, error, share = self._rest.T.copy()
        return TransitionTable(
            model=self._mechanism.name,
            why=why,
            engine=self._engine,
            outcome=self._outcome,
            message=tuple(self._message),
            speed_rpm=self._cases.speed_rpm,
            restitution=self._cases.restitution,
            stiffness=self._cases.stiffness,
            preload=self._cases.preload,
            collisions=self._collisions,
            duration=duration,
            duration_error=error,
            first_two_share=share,
            premise_holds=self._premise,
            table=table,
            mechanism=self._mechanism,
        )


def retuned(
    mechanism: Mechanism, restitution: float, stiffness: FloatArray, preload: FloatArray
) -> Mechanism:
    """The mechanism with other values; its tree does not depend on them and is not built again.

    Args:
        mechanism: The mechanism.
        restitution: e_N of the transition stop.
        stiffness: Spring rates, shape (springs,) [N/m or N m/rad].
        preload: Deflections in the springs at zero, shape (springs,) [m or rad].
    """
    stops = tuple(
        replace(stop, restitution=restitution) if stop.name == mechanism.transition_stop else stop
        for stop in mechanism.stops
    )
    springs = tuple(
        replace(spring, stiffness=float(k), preload=float(p))
        for spring, k, p in zip(mechanism.springs, stiffness, preload, strict=True)
    )
    return replace(mechanism, stops=stops, springs=springs)


def _collision_rows(transition: TrueTransition) -> FloatArray:
    """Collisions of the transition stop, shape (rows, collisions)."""
    hits, errors = transition.collisions, transition.errors
    found = np.full((rows.COLUMNS, len(hits)), np.nan)
    for i, (hit, error) in enumerate(zip(hits, errors, strict=True)):
        found[rows.TIME, i] = hit.t - hits[0].t
        found[rows.ANGLE, i] = hit.cylinder_angle
        found[rows.APPROACH, i] = hit.approach_rate
        found[rows.SEPARATION, i] = hit.separation_rate
        found[rows.IMPULSE, i] = hit.impulse
        found[rows.ENERGY, i] = hit.energy_lost
        found[rows.TIME_ERROR, i] = error.time
        found[rows.RATE_ERROR, i] = error.impulse * abs(hit.approach_rate)
        found[rows.IMPULSE_ERROR, i] = error.impulse * abs(hit.impulse)
        if hit.rebound_amplitude is None or hit.rebound_time is None:
            continue
        rebound = rebound_error(transition.solution, hit)
        found[rows.AMPLITUDE, i] = hit.rebound_amplitude
        found[rows.REBOUND, i] = hit.rebound_time
        found[rows.AMPLITUDE_ERROR, i] = rebound.amplitude
        found[rows.REBOUND_ERROR, i] = rebound.time
    return found


def _rest(transition: TrueTransition) -> tuple[float, float, float]:
    """Duration, its stated error and the share of the first two rebounds; NaN without rest."""
    found, error = transition.transition, transition.duration_error
    if found is None or error is None:
        return np.nan, np.nan, np.nan
    share = np.nan if found.first_two_share is None else found.first_two_share
    return found.duration, error, share
