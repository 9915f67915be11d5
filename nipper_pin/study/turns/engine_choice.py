"""Turns of many cases, and the choice of the engine that follows them."""

from __future__ import annotations

from collections.abc import Mapping

from numpy.typing import ArrayLike

from ...dynamics import DriveMode
from ...errors import InputError
from ...given import LARGEST, flag, number, whole
from ...mechanism import Mechanism, need_mechanism
from ...reduced.turns import TurnModel, turn_model
from ...reduced.turns.model import unfit_turns
from ...reduced.turns.peak_torques import torque_model
from ..cases import SPRING_KEYS, Cases, cases_of, spring_values
from ..engines import Engine, check_engine, chosen
from .run import Run, TurnSettings
from .table import TurnTable

# Tables cost 3 direct cases and loading compiled code 10 to 13 (2026-11-22). A fixed number:
# the engine of a case does not depend on what the process computed before.
TURNS_PAY_FROM = 16
TURNS = 20
"""Turns that are followed unless another number is given."""
MOST_TURNS = 10_000


def turn_table(
    mechanism: Mechanism,
    *,
    speed_rpm: ArrayLike,
    restitution: ArrayLike | Mapping[str, ArrayLike] | None = None,
    stiffness_N_per_m: ArrayLike | None = None,
    preload_length_mm: ArrayLike | None = None,
    stiffness_N_m_per_rad: ArrayLike | None = None,
    preload_deg: ArrayLike | None = None,
    turns: int = TURNS,
    least_force_N: float = 0.0,
    torques: bool = False,
    rest_rate: float | None = None,
    tolerance: float = 1e-10,
    max_collisions: int = 256,
    drive: DriveMode = DriveMode.HELD,
    engine: Engine = "auto",
) -> TurnTable:
    """Follow whole turns of many cases of one mechanism, each until its turns repeat.

    Args:
        mechanism: The mechanism.
        speed_rpm: Cylinder speeds [r/min], a number or shape (n,); so are the restitutions.
        restitution: e_N of the transition stop, or of stops by name; by default the mechanism's.
        stiffness_N_per_m: Springs, all four as of `transition_table`.
        preload_length_mm: Likewise.
        stiffness_N_m_per_rad: Likewise.
        preload_deg: Likewise.
        turns: Largest number of turns of a case; fewer are computed where they repeat.
        least_force_N: Force above which the transition stop clamps [N]; [N m] at a hinge's stop
            without contact point.
        torques: Whether the largest torques of the drives are wanted; they cost a turn more.
        rest_rate: None: series end at their limit. A number: rest at the first slower rebound.
        tolerance: Relative accuracy.
        max_collisions: Largest number of collisions of a turn.
        drive: Behaviour of the driven shafts.
        engine: "auto": the reduced engine for ``TURNS_PAY_FROM`` cases or more of a mechanism
            whose turns it can follow, the direct one for all others. "direct" or "reduced": that
            one alone.

    Returns:
        The table. A case that cannot be followed is marked in it.

    Raises:
        InputError: A parameter is out of range or has another unit, by its size; no stop clamps; or
            the reduced engine is asked for and cannot follow the mechanism.
        SimulationError: The reduced engine is asked for, and a point of the turn is singular.
    """
    need_mechanism(mechanism, "turn_table")
    given = (stiffness_N_per_m, preload_length_mm, stiffness_N_m_per_rad, preload_deg)
    springs = spring_values(mechanism, dict(zip(SPRING_KEYS, given, strict=True)))
    settings = TurnSettings(turns=turns, least_force=least_force_N, torques=torques, drive=drive,
                            rest_rate=rest_rate, tolerance=tolerance,
                            max_collisions=max_collisions)  # fmt: skip
    _need_clamp(mechanism)
    cases = cases_of(mechanism, speed_rpm, restitution, *springs)
    return turns_of(mechanism, cases, settings, engine)


def turns_of(
    mechanism: Mechanism, cases: Cases, settings: TurnSettings, engine: Engine = "auto"
) -> TurnTable:
    """Follow turns of cases; results and errors as of :func:`turn_table`.

    Args:
        settings: What they share.
        engine: "auto", "direct" or "reduced".
    """
    check_engine(engine, settings)
    number("least_force_N", settings.least_force, 0.0, LARGEST)
    whole("turns", settings.turns, 1, MOST_TURNS)
    flag("torques", settings.torques)
    _need_clamp(mechanism)
    run = Run(mechanism, cases, settings)
    count = len(cases.speed_rpm)
    model, why = chosen(
        lambda: _model(mechanism, settings.drive, torques=settings.torques),
        engine=engine,
        count=count,
        pays_from=TURNS_PAY_FROM,
        unfit=lambda: unfit_turns(mechanism, settings.drive),
    )
    left = list(range(count))
    if model is not None:
        left = run.reduced(keep_all=engine == "reduced")
        if left:
            why += f"; {len(left)} that it cannot follow: direct"
    for place in left:
        run.direct(place)
    return run.table(why)


def _model(mechanism: Mechanism, drive: DriveMode, *, torques: bool = False) -> TurnModel:
    """The tables of a mechanism, which keeps them; those of its torques are made, too, if asked."""
    reason = unfit_turns(mechanism, drive)
    if reason is not None:
        message = f"{mechanism.name}: {reason}"
        raise InputError(message, model=mechanism.name)
    model = turn_model(mechanism)
    if torques:
        torque_model(mechanism, model.start_index, 1.0)
    return model


def _need_clamp(mechanism: Mechanism) -> None:
    if not mechanism.transition_stop:
        message = f"{mechanism.name} has no stop that could clamp, so its turns have no quantities"
        raise InputError(message, model=mechanism.name)
