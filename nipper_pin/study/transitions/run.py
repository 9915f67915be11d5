"""Transitions of many cases as they come in, from both engines."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ...arrays import FloatArray
from ...errors import NipperError, SimulationError
from ...hybrid.result.rebound_errors import rebound_error
from ...mechanism import Mechanism
from ...reduced import ReducedModel, Status, transitions
from ...reduced.kernels import layout as rows
from ...reduced.kernels.layout import FAILS, HOLDS, UNKNOWN
from ..cases import Cases, Settings, one_of
from ..true_transition import TrueTransition, assumed_transition, transition_of_turns
from ..turn_transition import TurnTransition, touch_turns, turn_transition
from .table import FAILED, REDUCED, REDUCED_TURN, TURN, TransitionTable

# Cases of one batch, and columns of its table; few cases have more collisions.
_BATCH, _COLUMNS = 4096, 32
_STATUS = {int(status): status.name.lower() for status in Status}
_PREMISE = {HOLDS: True, FAILS: False, UNKNOWN: None}
_AT_REST, _TOO_MANY, _UNTOLD = (
    _STATUS[status] for status in (Status.AT_REST, Status.TOO_MANY_COLLISIONS, Status.UNTOLD)
)


class Run:
    """Results of all cases as they come in.

    Args:
        settings: What they share.
        true: Whether the transition is that of the turn where its premise does not hold.
    """

    def __init__(
        self, mechanism: Mechanism, cases: Cases, settings: Settings, *, true: bool
    ) -> None:
        """Begin with none."""
        n = len(cases.speed_rpm)
        self._mechanism, self._cases, self._settings = mechanism, cases, settings
        self._true = true
        self._premise = np.full(n, None, dtype=object)
        self._engine = np.full(n, "direct", dtype="U12")
        self._outcome = np.full(n, FAILED, dtype="U24")
        self._message = [""] * n
        self._collisions = np.zeros(n, dtype=np.int64)
        # Duration, its error, share.
        self._rest = np.full((n, 3), np.nan)
        # Why whole turns are to be simulated, of cases for which that is put off.
        self._put_off: dict[int, str] = {}
        # Numbers of cases and their rows, which are trimmed to their longest series.
        self._rows: list[tuple[NDArray[np.int64], FloatArray]] = []

    def reduced(self, model: ReducedModel, *, keep_all: bool) -> list[int]:
        """Solve all cases by the reduced engine; returns those that it leaves to the other."""
        chosen = np.arange(len(self._outcome))
        most = self._settings.max_collisions
        for columns in sorted({min(_COLUMNS, most), most}):
            for start in range(0, len(chosen), _BATCH):
                self._batch(model, chosen[start : start + _BATCH], columns)
            chosen = np.flatnonzero(self._outcome == _TOO_MANY)
        if keep_all:
            return []
        left = np.flatnonzero(self._outcome != _AT_REST)
        for number in left:
            reason = str(self._outcome[number])
            if reason == _UNTOLD:
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
            rest_rate=self._settings.rest_rate,
            tolerance=self._settings.tolerance,
            max_collisions=columns,
            # Drives without a period have no repeated turn, so the premise is undefined.
            assumed=not (self._true and model.arrival.asked),
        )
        self._engine[chosen] = REDUCED
        self._outcome[chosen] = [_STATUS[status] for status in batch.status]
        self._collisions[chosen] = batch.collisions
        self._rest[chosen] = np.stack([batch.duration, batch.duration_error, batch.share], axis=1)
        self._premise[chosen] = [_PREMISE[told] for told in batch.premise]
        most = int(batch.collisions.max(initial=0))
        self._rows.append((chosen, batch.table[:, :, :most].copy()))

    def turns(self, numbers: list[int]) -> list[int]:
        """Follow whole turns by the reduced engine; returns the cases that it leaves.

        It keeps those whose turns show that the premise does not hold.
        """
        cases = self._cases
        left = list(numbers)
        try:
            touch_turns(self._mechanism)
            for number in numbers:
                try:
                    found = turn_transition(
                        self._mechanism,
                        speed_rpm=float(cases.speed_rpm[number]),
                        restitution=float(cases.restitution[number]),
                        stiffness=cases.stiffness[number],
                        preload=cases.preload[number],
                        settings=self._settings,
                    )
                except SimulationError as error:
                    if "status" not in error.evidence:
                        raise
                    continue
                if found.premise_holds is False:
                    self._keep_turn(number, found)
                    left.remove(number)
        except NipperError:
            # Tables cannot be made, or not as wide: the direct engine computes what is left.
            return left
        return left

    def _keep_turn(self, number: int, found: TurnTransition) -> None:
        """Store the transition of a turn of the reduced engine."""
        self._engine[number], self._premise[number] = REDUCED_TURN, False
        self._outcome[number] = found.outcome.name.lower()
        self._collisions[number] = found.table.shape[1]
        self._rest[number] = found.duration, found.duration_error, found.share
        self._message[number] = found.message
        self._rows.append((np.array([number]), found.table[None]))

    def direct(self, number: int, *, put_off: bool = False) -> bool:
        """Simulate one case by the direct engine.

        Args:
            number: The case.
            put_off: Whether to leave whole turns to another call, where the premise does not hold.

        Returns:
            Whether they were.
        """
        self._engine[number] = "direct"
        self._outcome[number], self._collisions[number] = FAILED, 0
        self._rest[number] = np.nan
        block = np.empty((rows.COLUMNS, 0))
        self._premise[number] = None
        try:
            mechanism, case = one_of(self._mechanism, self._cases, self._settings, number)
            why = self._put_off.pop(number, None)
            if why is None:
                found = assumed_transition(mechanism, case)
                if self._true and found.premise_holds is False:
                    why = found.solution.premise.why
                    if put_off:
                        self._put_off[number] = why
                        return True
            if why is not None:
                found = transition_of_turns(mechanism, case, why)
                self._engine[number] = TURN
            block = _collision_rows(found)
        except NipperError as error:
            self._message[number] = error.message
        else:
            self._rest[number] = _rest_numbers(found)
            self._outcome[number] = found.outcome.name.lower()
            self._collisions[number] = block.shape[1]
            self._message[number] = found.message or self._message[number]
            self._premise[number] = found.premise_holds
        self._rows.append((np.array([number]), block[None]))
        return False

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


def _rest_numbers(transition: TrueTransition) -> tuple[float, float, float]:
    """Duration, its stated error and the share of the first two rebounds; NaN without rest."""
    found, error = transition.transition, transition.duration_error
    if found is None or error is None:
        return np.nan, np.nan, np.nan
    share = np.nan if found.first_two_share is None else found.first_two_share
    return found.duration, error, share
