"""An identification problem: free numbers with bounds, targets, limits; read from a TOML file."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Literal

import msgspec
from msgspec import Meta

from ....errors import InputError
from ....hybrid.result.quantities import refuse_unknown
from ....mechanism import Mechanism, numbers_of
from ....mechanism.files import Positive, Restitution
from ....tolerances.reduced import FINEST_TOLERANCE
from ....tolerances.study import COARSEST_FIT
from ...toml_files import Bounds, Table, base_mechanism, check_paths, read_table, refuse
from .measured import read_measured
from .targets import QUANTITIES, Condition, Target, conditions, stiffness_name
from .working_cycle import unfit

BUILT_IN = Path(__file__).with_name("paper_ratios.toml")
"""The problem of the published ratios."""

_NotNegative = Annotated[float, Meta(ge=0.0)]
_Tolerance = Annotated[float, Meta(ge=FINEST_TOLERANCE, le=COARSEST_FIT)]


class _Setting(Table, frozen=True, kw_only=True):
    """Settings of one transition."""

    speed_rpm: Positive
    restitution: Restitution | None = None
    stiffness_N_per_m: Positive | None = None
    stiffness_N_m_per_rad: Positive | None = None


class _TargetTable(Table, frozen=True, kw_only=True):
    """One number to come out; one of the two sigmas."""

    name: str
    quantity: str
    at: _Setting
    since: _Setting | None = None
    value: float
    sigma: Positive | None = None
    relative_sigma: Positive | None = None


class _ParameterTable(Bounds, frozen=True, kw_only=True):
    """Bounds of a free number and why they are where they are."""

    why: str = ""


class _LeastTable(Table, frozen=True, kw_only=True):
    """A least value."""

    low: float


class _LimitsTable(Table, frozen=True, kw_only=True):
    """Limits of the working cycle."""

    at: _Setting
    closing_index: Bounds | None = None
    opening_index: Bounds | None = None
    stop_force_N: _LeastTable | None = None
    jaw_opening_deg: _LeastTable | None = None


class _CaseTable(Table, frozen=True, kw_only=True):
    """How transitions are simulated."""

    rest_rate: Positive | None = None
    tolerance: _Tolerance = 1e-8


class _ProblemTable(Table, frozen=True, kw_only=True):
    """The whole file."""

    format: Literal[1]
    title: str
    model: str
    case: _CaseTable = _CaseTable()
    set: dict[str, object] = msgspec.field(default_factory=dict)
    parameters: dict[str, _ParameterTable]
    targets: tuple[_TargetTable, ...] = ()
    measured: str | None = None
    limits: _LimitsTable | None = None
    prior_weight: _NotNegative = 0.0
    absolute_sigma: bool = True


@dataclass(frozen=True, kw_only=True)
class Parameter:
    """A free number of the model.

    Attributes:
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
        stop_force_N: Least force on the stop while the jaw is open [N].
        jaw_opening_deg: Least widest opening of the jaw [deg].
    """

    at: Condition
    closing_index: tuple[float, float] | None
    opening_index: tuple[float, float] | None
    stop_force_N: float | None
    jaw_opening_deg: float | None


@dataclass(frozen=True, kw_only=True)
class Problem:
    """An identification problem.

    Attributes:
        mechanism: The model that it starts from.
        parameters: Free numbers.
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
    mechanism: Mechanism = field(repr=False)
    parameters: tuple[Parameter, ...]
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
    stiffness = stiffness_name(mechanism)
    targets = tuple(_target(item, stiffness, file.name) for item in table.targets)
    if table.measured is not None:
        targets += read_measured(file.parent / table.measured, stiffness)
    if not targets:
        message = f"{file.name}: nothing to aim at; give [[targets]], or measured = 'FILE.csv'"
        raise InputError(message, file=str(file))
    limits = _limits(table.limits, stiffness, file.name)
    _check_fit(mechanism, targets, limits, file.name)
    return Problem(
        title=table.title,
        mechanism=mechanism,
        parameters=_parameters(_by_path(table, mechanism, file.name), mechanism, file.name),
        targets=targets,
        limits=limits,
        prior_weight=table.prior_weight,
        rest_rate=table.case.rest_rate,
        tolerance=table.case.tolerance,
        absolute_sigma=table.absolute_sigma,
    )


def _check_fit(
    mechanism: Mechanism, targets: Sequence[Target], limits: Limits | None, file: str
) -> None:
    """Refuse targets and limits that this mechanism cannot have, whatever its numbers."""
    asked = [*conditions(targets), *([] if limits is None else [limits.at])]
    stiff = [at for at in asked if at.stiffness is not None]
    if stiff and len(mechanism.springs) != 1:
        names = [spring.name for spring in mechanism.springs]
        allowed = f"only with a model that has one spring; {mechanism.name} has {names}"
        refuse(file, "stiffness", stiff[0].stiffness, allowed)
    if limits is None:
        return
    reason = unfit(mechanism)
    if reason is not None:
        refuse(file, "limits", mechanism.name, reason)
    stop = mechanism.stop(mechanism.transition_stop)
    kinds = {joint.index: joint.kind for joint in mechanism.joints}
    if limits.jaw_opening_deg is not None and kinds[stop.index] != "revolute":
        allowed = f"only with a stop on a hinge; {stop.name} is on a slide"
        refuse(file, "limits.jaw_opening_deg", limits.jaw_opening_deg, allowed)


def _target(item: _TargetTable, stiffness: str, file: str) -> Target:
    key = f"targets: {item.name}"
    refuse_unknown([item.quantity], QUANTITIES, f"{file}: {key}")
    if (item.sigma is None) == (item.relative_sigma is None):
        refuse(file, key, item.sigma, "one of sigma and relative_sigma")
    sigma = item.sigma
    if sigma is None:
        sigma = abs(item.value) * (item.relative_sigma or 0.0)
    if not (math.isfinite(item.value) and sigma > 0.0):
        allowed = "a finite value, and one that is not zero with relative_sigma"
        refuse(file, f"{key}: value", item.value, allowed)
    return Target(
        name=item.name,
        quantity=item.quantity,
        at=_condition(item.at, stiffness, f"{key}: at", file),
        since=(
            None if item.since is None else _condition(item.since, stiffness, f"{key}: since", file)
        ),
        value=item.value,
        sigma=sigma,
    )


def _condition(item: _Setting, stiffness: str, key: str, file: str) -> Condition:
    for name in ("stiffness_N_per_m", "stiffness_N_m_per_rad"):
        if name != stiffness and getattr(item, name) is not None:
            refuse(file, f"{key}.{name}", getattr(item, name), f"with this model write {stiffness}")
    return Condition(item.speed_rpm, item.restitution, getattr(item, stiffness))


def _by_path(table: _ProblemTable, mechanism: Mechanism, file: str) -> dict[str, _ParameterTable]:
    """Free numbers by the paths that their shortcuts stand for, each once and not fixed as well."""
    taken = {mechanism.shortcuts.get(name, name): f"set.{name}" for name in table.set}
    free = {}
    for name, item in table.parameters.items():
        path = mechanism.shortcuts.get(name, name)
        if path in taken:
            allowed = f"a path that {taken[path]} does not give already"
            refuse(file, f"parameters.{name}", path, allowed)
        free[path], taken[path] = item, f"parameters.{name}"
    return free


def _parameters(
    table: dict[str, _ParameterTable], mechanism: Mechanism, file: str
) -> tuple[Parameter, ...]:
    if not table:
        message = f"{file}: nothing is free; give [parameters.NAME] with low and high"
        raise InputError(message, file=file)
    starts = numbers_of(mechanism, table)
    for (path, item), start in zip(table.items(), starts, strict=True):
        key, bounds = f"parameters.{path}", [item.low, item.high]
        if not item.low < item.high or not math.isfinite(item.high - item.low):
            refuse(file, key, bounds, "low below high, both finite")
        if not item.low <= start <= item.high:
            refuse(file, key, bounds, f"bounds around the model's own value {start:.9g}")
    check_paths(table, mechanism)
    return tuple(
        Parameter(path=path, low=item.low, high=item.high, start=start, why=item.why)
        for (path, item), start in zip(table.items(), starts, strict=True)
    )


def _limits(item: _LimitsTable | None, stiffness: str, file: str) -> Limits | None:
    if item is None:
        return None
    return Limits(
        at=_condition(item.at, stiffness, "limits.at", file),
        closing_index=_indices(item.closing_index, "limits.closing_index", file),
        opening_index=_indices(item.opening_index, "limits.opening_index", file),
        stop_force_N=None if item.stop_force_N is None else item.stop_force_N.low,
        jaw_opening_deg=None if item.jaw_opening_deg is None else item.jaw_opening_deg.low,
    )


def _indices(item: Bounds | None, key: str, file: str) -> tuple[float, float] | None:
    if item is None:
        return None
    if not 0.0 <= item.low < item.high <= 40.0:
        refuse(file, key, [item.low, item.high], "two indices between 0 and 40, low below high")
    return item.low, item.high
