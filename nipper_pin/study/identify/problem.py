"""An identification problem: free numbers with bounds, targets, limits; read from a TOML file."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Literal

import msgspec
from msgspec import Meta

from ...errors import InputError, ModelError
from ...hybrid.quantities import refuse_unknown
from ...mechanism import Mechanism
from ...mechanism.description import Positive, Restitution
from ..toml_files import Table, base_mechanism, read_table, refuse
from .geometry import Sources
from .measured import read_measured
from .parameters import read_values, with_values
from .targets import QUANTITIES, Condition, Target, conditions
from .working import unfit

BUILT_IN = Path(__file__).with_name("paper_ratios.toml")
"""The problem of the published ratios."""

_NotNegative = Annotated[float, Meta(ge=0.0)]
_Tolerance = Annotated[float, Meta(ge=1e-13, le=1e-4)]


class _Setting(Table, frozen=True, kw_only=True):
    """Settings of one transition."""

    speed_rpm: Positive
    restitution: Restitution | None = None
    stiffness: Positive | None = None


class _TargetTable(Table, frozen=True, kw_only=True):
    """One number to come out; one of the two sigmas."""

    name: str
    quantity: str
    at: _Setting
    since: _Setting | None = None
    value: float
    sigma: Positive | None = None
    relative_sigma: Positive | None = None


class _FreeTable(Table, frozen=True, kw_only=True):
    """Bounds of a free number and why they are where they are."""

    low: float
    high: float
    why: str = ""


class _LimitsTable(Table, frozen=True, kw_only=True):
    """Limits of the working cycle."""

    at: _Setting
    closing_index: tuple[float, float] | None = None
    opening_index: tuple[float, float] | None = None
    least_stop_force_N: float | None = None
    least_opening_deg: float | None = None


class _ProblemTable(Table, frozen=True, kw_only=True):
    """The whole file."""

    format: Literal[1]
    title: str
    model: str
    set: dict[str, object] = msgspec.field(default_factory=dict)
    free: dict[str, _FreeTable]
    targets: tuple[_TargetTable, ...] = ()
    measured: str | None = None
    limits: _LimitsTable | None = None
    prior_weight: _NotNegative = 0.0
    rest_rate: Positive | None = None
    tolerance: _Tolerance = 1e-8
    absolute_sigma: bool = True


@dataclass(frozen=True, kw_only=True)
class Free:
    """A free number of the model.

    Attributes:
        path: Its path.
        low: Lower bound, in the unit of the path's name.
        high: Upper bound.
        start: Value in the model.
        why: Where the bounds come from.
    """

    path: str
    low: float
    high: float
    start: float
    why: str

    @property
    def width(self) -> float:
        """Width of the range."""
        return self.high - self.low


@dataclass(frozen=True, kw_only=True)
class Limits:
    """What the working cycle must keep to; None where there is no such limit.

    Attributes:
        at: Settings at which forces are judged: the hardest that the machine has to stand.
        closing_index: Range of the index of touch.
        opening_index: Range of the index at which the jaw opens.
        least_stop_force_N: Least force on the stop while the jaw is open [N].
        least_opening_deg: Least widest opening of the jaw [deg].
    """

    at: Condition
    closing_index: tuple[float, float] | None
    opening_index: tuple[float, float] | None
    least_stop_force_N: float | None
    least_opening_deg: float | None


@dataclass(frozen=True, kw_only=True)
class Problem:
    """An identification problem.

    Attributes:
        title: What it is.
        sources: Texts of the model that it starts from.
        free: Free numbers.
        targets: Numbers to come out.
        limits: Limits of the working cycle, or None.
        prior_weight: Weight of the distance from the model's own values: a number that moves by
            its whole range costs as much as a target that is missed by this many sigmas.
        rest_rate: Separation rate at which transitions end [rad/s or m/s]; None: at their limit.
        tolerance: Relative accuracy of the transitions.
        absolute_sigma: Whether sigmas are standard deviations of measurements; if not they are
            weights alone, a judgement, and only the fit tells how large they are.
    """

    title: str
    sources: Sources = field(repr=False)
    free: tuple[Free, ...]
    targets: tuple[Target, ...]
    limits: Limits | None = None
    prior_weight: float = 0.0
    rest_rate: float | None = None
    tolerance: float = 1e-8
    absolute_sigma: bool = True


def read_problem(path: str | Path | None = None) -> Problem:
    """Read a problem.

    Args:
        path: TOML file; by default the built-in problem of the published ratios. Models and CSV
            files that it names are searched beside it.

    Raises:
        UnknownNameError: The file names something that does not exist.
        ModelError: A value of the file cannot be used.
        InputError: The measurements cannot be used.
    """
    file = BUILT_IN if path is None else Path(path)
    table = read_table(file, _ProblemTable)
    mechanism = base_mechanism(table.model, table.set, file)
    sources = Sources.of(mechanism)
    targets = tuple(_target(item, file.name) for item in table.targets)
    if table.measured is not None:
        targets += read_measured(file.parent / table.measured)
    if not targets:
        message = f"{file.name}: nothing to aim at; give [[targets]], or measured = 'FILE.csv'"
        raise InputError(message, file=str(file))
    _check_fit(mechanism, targets, table.limits, file.name)
    return Problem(
        title=table.title,
        sources=sources,
        free=_free(_by_path(table, mechanism, file.name), sources, file.name),
        targets=targets,
        limits=_limits(table.limits, file.name),
        prior_weight=table.prior_weight,
        rest_rate=table.rest_rate,
        tolerance=table.tolerance,
        absolute_sigma=table.absolute_sigma,
    )


def _check_fit(
    mechanism: Mechanism, targets: Sequence[Target], limits: _LimitsTable | None, file: str
) -> None:
    """Refuse targets and limits that this mechanism cannot have, whatever its numbers."""
    asked = [*conditions(targets), *([] if limits is None else [_condition(limits.at)])]
    stiff = [at for at in asked if at.stiffness is not None]
    if stiff and len(mechanism.springs) != 1:
        names = [spring.name for spring in mechanism.springs]
        allowed = f"only with a model that has one spring; {mechanism.name} has {names}"
        raise ModelError(file=file, key="stiffness", value=stiff[0].stiffness, allowed=allowed)
    if limits is None:
        return
    reason = unfit(mechanism)
    if reason is not None:
        raise ModelError(file=file, key="limits", value=mechanism.name, allowed=reason)
    stop = mechanism.stop(mechanism.transition_stop)
    kinds = {joint.index: joint.kind for joint in mechanism.joints}
    if limits.least_opening_deg is not None and kinds[stop.index] != "revolute":
        raise ModelError(
            file=file,
            key="limits.least_opening_deg",
            value=limits.least_opening_deg,
            allowed=f"only with a stop on a hinge; {stop.name} is on a slide",
        )


def _target(item: _TargetTable, file: str) -> Target:
    key = f"targets: {item.name}"
    refuse_unknown([item.quantity], QUANTITIES, f"{file}: {key}")
    if (item.sigma is None) == (item.relative_sigma is None):
        allowed = "one of sigma and relative_sigma"
        raise ModelError(file=file, key=key, value=item.sigma, allowed=allowed)
    sigma = item.sigma
    if sigma is None:
        sigma = abs(item.value) * (item.relative_sigma or 0.0)
    if not (math.isfinite(item.value) and sigma > 0.0):
        allowed = "a finite value, and one that is not zero with relative_sigma"
        raise ModelError(file=file, key=f"{key}: value", value=item.value, allowed=allowed)
    return Target(
        name=item.name,
        quantity=item.quantity,
        at=_condition(item.at),
        since=None if item.since is None else _condition(item.since),
        value=item.value,
        sigma=sigma,
    )


def _condition(item: _Setting) -> Condition:
    return Condition(item.speed_rpm, item.restitution, item.stiffness)


def _by_path(table: _ProblemTable, mechanism: Mechanism, file: str) -> dict[str, _FreeTable]:
    """Free numbers by the paths that their shortcuts stand for, each once and not fixed as well."""
    taken = {mechanism.shortcuts.get(name, name): f"set.{name}" for name in table.set}
    free = {}
    for name, item in table.free.items():
        path = mechanism.shortcuts.get(name, name)
        if path in taken:
            refuse(file, f"free.{name}", path, f"not what {taken[path]} gives, too")
        free[path], taken[path] = item, f"free.{name}"
    return free


def _free(table: dict[str, _FreeTable], sources: Sources, file: str) -> tuple[Free, ...]:
    if not table:
        message = f'{file}: nothing is free; give [free."PATH"] with low and high'
        raise InputError(message, file=file)
    starts = read_values(sources, tuple(table))
    for (path, item), start in zip(table.items(), starts, strict=True):
        if not item.low < item.high or not math.isfinite(item.high - item.low):
            allowed = "low below high, both finite"
            value = [item.low, item.high]
            raise ModelError(file=file, key=f"free.{path}", value=value, allowed=allowed)
        if not item.low <= start <= item.high:
            allowed = f"bounds around the model's own value {start:.9g}"
            value = [item.low, item.high]
            raise ModelError(file=file, key=f"free.{path}", value=value, allowed=allowed)
    _check_together(table, starts, sources)
    return tuple(
        Free(path=path, low=item.low, high=item.high, start=start, why=item.why)
        for (path, item), start in zip(table.items(), starts, strict=True)
    )


def _check_together(
    table: dict[str, _FreeTable], starts: Sequence[float], sources: Sources
) -> None:
    """Write the model's own values back: paths that contradict one another are found here."""
    with_values(sources, dict(zip(table, starts, strict=True)))


def _limits(item: _LimitsTable | None, file: str) -> Limits | None:
    if item is None:
        return None
    for key in ("closing_index", "opening_index"):
        value = getattr(item, key)
        if value is not None and not 0.0 <= value[0] < value[1] <= 40.0:
            allowed = "two indices between 0 and 40, the smaller one first"
            raise ModelError(file=file, key=f"limits.{key}", value=list(value), allowed=allowed)
    return Limits(
        at=_condition(item.at),
        closing_index=item.closing_index,
        opening_index=item.opening_index,
        least_stop_force_N=item.least_stop_force_N,
        least_opening_deg=item.least_opening_deg,
    )
