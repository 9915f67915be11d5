"""The file of a design problem: its keys and their allowed values."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Literal

import msgspec
from msgspec import Meta

from ....hybrid.result.quantities import refuse_unknown
from ....hybrid.result.turns import INDICES
from ....mechanism import Mechanism, number_of
from ....mechanism.files import Positive
from ....tolerances.reduced import FINEST_TOLERANCE
from ....tolerances.study import COARSEST_DESIGN
from ...sweep.axes import SPEED, find_target
from ...sweep.study_file import check_bounds, without_visuals
from ...toml_files import (
    Bounds,
    Table,
    at_key,
    base_mechanism,
    check_paths,
    model_beside,
    read_table,
    refuse,
)
from .problem import Aim, Limit, Parameter, Problem
from .quantities import QUANTITIES, check_fit, units

_Names = str | tuple[str, ...]
_MOST_AIMS = 2


class _CaseTable(Table, frozen=True, kw_only=True):
    """How transitions are simulated."""

    speed_rpm: Positive | None = None
    rest_rate: Positive | None = None
    tolerance: Annotated[float, Meta(ge=FINEST_TOLERANCE, le=COARSEST_DESIGN)] = 1e-10


class _LimitTable(Table, frozen=True, kw_only=True):
    """Limits of one quantity."""

    low: float | None = None
    high: float | None = None


class _FileTable(Table, frozen=True, kw_only=True):
    """The whole file."""

    format: Literal[1]
    title: str = ""
    model: str = "e62"
    minimise: _Names = ()
    maximise: _Names = ()
    case: _CaseTable = _CaseTable()
    set: dict[str, object] = msgspec.field(default_factory=dict)
    parameters: dict[str, Bounds]
    limits: dict[str, _LimitTable] = msgspec.field(default_factory=dict)


def read_problem(path: str | Path) -> Problem:
    """Read and check the file of a design problem.

    Args:
        path: The TOML file; a model that it names is searched beside it first.

    Raises:
        InputError: The file, or something that it names, cannot be used.
    """
    file = Path(path)
    table = read_table(file, _FileTable)
    mechanism = base_mechanism(table.model, table.set, file)
    aims = _aims(table, file.name)
    limits = _limits(table, file.name)
    check_fit([item.quantity for item in aims], mechanism, f"{file.name}: minimise, maximise")
    check_fit(table.limits, mechanism, f"{file.name}: limits")
    speed = table.case.speed_rpm or mechanism.cylinder.rated_speed_rpm
    return Problem(
        title=table.title or mechanism.title,
        model=str(model_beside(table.model, file.parent)),
        changes={mechanism.shortcuts.get(key, key): value for key, value in table.set.items()},
        name=mechanism.name,
        urdf=without_visuals(mechanism),
        document=mechanism.description,
        folder=mechanism.mesh_folder,
        speed_rpm=speed,
        parameters=_parameters(table, mechanism, speed, file.name),
        aims=aims,
        limits=limits,
        units=units([item.quantity for item in aims] + list(table.limits), mechanism),
        rest_rate=table.case.rest_rate,
        tolerance=table.case.tolerance,
    )


def _aims(table: _FileTable, file: str) -> tuple[Aim, ...]:
    aims = [
        Aim(quantity=name, sense=sense)
        for key, names, sense in (
            ("minimise", table.minimise, 1.0),
            ("maximise", table.maximise, -1.0),
        )
        for name in _known((names,) if isinstance(names, str) else names, f"{file}: {key}")
    ]
    named = [item.quantity for item in aims]
    if not 1 <= len(set(named)) == len(named) <= _MOST_AIMS:
        refuse(
            file,
            "minimise",
            named,
            "one quantity in minimise or maximise, or two that differ for a Pareto front",
        )
    return tuple(aims)


def _known(names: Sequence[str], where: str) -> Sequence[str]:
    refuse_unknown(names, QUANTITIES, where)
    return names


def _limits(table: _FileTable, file: str) -> tuple[Limit, ...]:
    limits: list[Limit] = []
    sides: tuple[Literal["low", "high"], ...] = ("low", "high")
    _known(list(table.limits), f"{file}: limits")
    for name, item in table.limits.items():
        key = f"limits.{name}"
        if item.low is None and item.high is None:
            refuse(file, key, {"low": None, "high": None}, "low, high or both")
        for side in sides:
            value = getattr(item, side)
            if value is None:
                continue
            if not math.isfinite(value):
                refuse(file, f"{key}.{side}", value, "a finite number")
            if name in INDICES and not 0.0 <= value <= 40.0:
                refuse(file, f"{key}.{side}", value, "an index from 0 to 40")
            limits.append(Limit(quantity=name, side=side, value=value))
        if item.low is not None and item.high is not None and item.low > item.high:
            refuse(file, key, [item.low, item.high], "low below high")
    return tuple(limits)


def _parameters(
    table: _FileTable, mechanism: Mechanism, speed: float, file: str
) -> tuple[Parameter, ...]:
    if not table.parameters:
        refuse(file, "parameters", [], "at least one [parameters.NAME]")
    found: list[Parameter] = []
    taken = {mechanism.shortcuts.get(name, name): f"set.{name}" for name in table.set}
    for name, item in table.parameters.items():
        key = f"parameters.{name}"
        if not item.low < item.high or not math.isfinite(item.high - item.low):
            refuse(file, key, [item.low, item.high], "low below high, both finite")
        with at_key(file, key):
            target = find_target(name, mechanism)
            if target.kind == "model":
                check_paths([target.path], mechanism)
            start = speed if target.path == SPEED else number_of(mechanism, target.path)
        if target.path in taken:
            refuse(file, key, name, f"a path that {taken[target.path]} does not give already")
        taken[target.path] = key
        check_bounds(target, (item.low, item.high), mechanism, key, file)
        found.append(Parameter(name=name, target=target, low=item.low, high=item.high, start=start))
    together = [item.target.path for item in found if item.target.kind == "model"]
    if together:
        with at_key(file, "parameters"):
            check_paths(together, mechanism)
    return tuple(found)
