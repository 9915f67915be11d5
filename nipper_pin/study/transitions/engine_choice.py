"""Transitions of many cases, and the choice of the engine that computes them."""

from __future__ import annotations

from numpy.typing import ArrayLike

from ...dynamics import DriveMode
from ...extras import installed
from ...mechanism import Mechanism, need_mechanism
from ...reduced import reduced_model, unfit
from ...reduced.turns.model import unfit_turns
from ..cases import SPRING_KEYS, Cases, Settings, cases_of, spring_values
from ..engines import Engine, check_engine, chosen
from .run import Run
from .table import TransitionTable

# Tables cost 7 direct cases and loading compiled code 21 (measured 2026-11-22). A fixed number: the
# engine of a case does not depend on what the process computed before.
REDUCED_PAYS_FROM = 32
# Cases of one table whose premise does not hold: tables of turns cost as much as 2 to 15 direct
# turns, by how high the flights go.
TURNS_PAY_FROM = 16


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
        engine: "auto": the reduced engine for ``REDUCED_PAYS_FROM`` cases or more of a
            mechanism that it can represent, the direct one for all others. Where the premise of a
            transition does not hold, it is that of whole turns: of the reduced engine for
            ``TURNS_PAY_FROM`` such cases or more, of the direct one for fewer, and for those that
            the other cannot follow. "direct" or "reduced": that one alone, the transition as it is
            assumed.

    Returns:
        The table. A case that cannot be simulated is marked in it.

    Raises:
        InputError: A parameter is out of range or has another unit, by its size; or the reduced
            engine is asked for and cannot represent the mechanism.
    """
    need_mechanism(mechanism, "transition_table")
    given = (stiffness_N_per_m, preload_length_mm, stiffness_N_m_per_rad, preload_deg)
    springs = spring_values(mechanism, dict(zip(SPRING_KEYS, given, strict=True)))
    settings = Settings(
        drive=drive, rest_rate=rest_rate, tolerance=tolerance, max_collisions=max_collisions
    )
    cases = cases_of(mechanism, speed_rpm, restitution, *springs)
    return table_of(mechanism, cases, settings, engine)


def table_of(
    mechanism: Mechanism, cases: Cases, settings: Settings, engine: Engine = "auto"
) -> TransitionTable:
    """Compute the transitions of cases; results and errors as of :func:`transition_table`."""
    check_engine(engine, settings)
    run = Run(mechanism, cases, settings, true=engine == "auto")
    drive, count = DriveMode(settings.drive), len(cases.speed_rpm)
    model, why = chosen(
        lambda: reduced_model(mechanism, drive),
        engine=engine,
        count=count,
        pays_from=REDUCED_PAYS_FROM,
        unfit=lambda: unfit(mechanism, drive),
    )
    left = list(range(count))
    turns = engine == "auto" and installed("numba") and unfit_turns(mechanism, drive) is None
    if model is not None:
        left = run.reduced(model, keep_all=engine == "reduced")
        if turns and len(left) >= TURNS_PAY_FROM:
            left, turns = run.turns(left), False
        if left:
            why += f"; {len(left)} that its tables do not cover: direct"
    turns = turns and len(left) >= TURNS_PAY_FROM
    late = [number for number in left if run.direct(number, put_off=turns)]
    if len(late) >= TURNS_PAY_FROM:
        late = run.turns(late)
    for number in late:
        run.direct(number)
    return run.table(why)
