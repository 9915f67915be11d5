"""The file of a design problem: its keys, and what may stand there."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Literal

import msgspec
from msgspec import Meta

from ...hybrid.quantities import refuse_unknown
from ...mechanism import Mechanism
from ...mechanism.description import Positive
from ..identify.geometry import Sources
from ..identify.parameters import read_values
from ..sweep.axes import SPEED, find_target
from ..sweep.changes import check_paths
from ..sweep.job import versions
from ..sweep.study_file import check_bounds, without_visuals
from ..toml_files import Table, at_key, base_mechanism, model_beside, read_table, refuse
from .problem import Aim, Limit, Parameter, Problem
from .quantities import INDICES, QUANTITIES, check_fit, units

_Names = str | tuple[str, ...]
_MOST_AIMS = 2


class _ParameterTable(Table, frozen=True, kw_only=True):
    """A free number and its bounds."""

    path: str
    lower: float
    upper: float


class _LimitTable(Table, frozen=True, kw_only=True):
    """Limits of one quantity."""

    lower: float | None = None
    upper: float | None = None


class _OptimiseTable(Table, frozen=True, kw_only=True):
    """The problem."""

    title: str = ""
    model: str = "e62"
    minimise: _Names = ()
    maximise: _Names = ()
    speed_rpm: Positive | None = None
    rest_rate: Positive | None = None
    tolerance: Annotated[float, Meta(ge=1e-13, le=1e-6)] = 1e-10
    parameters: tuple[_ParameterTable, ...]
    constraints: dict[str, _LimitTable] = msgspec.field(default_factory=dict)
    set: dict[str, object] = msgspec.field(default_factory=dict)


class _FileTable(Table, frozen=True, kw_only=True):
    """The whole file."""

    format: Literal[1]
    optimise: _OptimiseTable


def read_problem(path: str | Path) -> Problem:
    """Read and check the file of a design problem.

    Args:
        path: The TOML file; a model that it names is searched beside it first.

    Raises:
        InputError: The file, or something that it names, cannot be used.
    """
    file = Path(path)
    table = read_table(file, _FileTable).optimise
    mechanism = base_mechanism(table.model, table.set, file, ("optimise.model", "optimise.set"))
    aims = _aims(table, file.name)
    limits = _limits(table, file.name)
    check_fit([item.quantity for item in aims], mechanism, f"{file.name}: optimise")
    check_fit(table.constraints, mechanism, f"{file.name}: optimise.constraints")
    speed = table.speed_rpm or mechanism.cylinder.rated_speed_rpm
    sources = Sources.of(mechanism)
    return Problem(
        title=table.title or mechanism.title,
        model=str(model_beside(table.model, file.parent)),
        changes={mechanism.shortcuts.get(key, key): value for key, value in table.set.items()},
        sources=replace(sources, urdf=without_visuals(mechanism)),
        speed_rpm=speed,
        parameters=_parameters(table, mechanism, sources, speed, file.name),
        aims=aims,
        limits=limits,
        units=units([item.quantity for item in aims] + list(table.constraints), mechanism),
        rest_rate=table.rest_rate,
        tolerance=table.tolerance,
        versions=versions(),
    )


def _aims(table: _OptimiseTable, file: str) -> tuple[Aim, ...]:
    aims = [
        Aim(quantity=name, sense=sense)
        for key, names, sense in (
            ("minimise", table.minimise, 1.0),
            ("maximise", table.maximise, -1.0),
        )
        for name in _known(_listed(names), f"{file}: optimise.{key}")
    ]
    named = [item.quantity for item in aims]
    if not 1 <= len(set(named)) == len(named) <= _MOST_AIMS:
        refuse(
            file,
            "optimise.minimise",
            named,
            "one quantity in minimise or maximise, or two that differ for a Pareto front",
        )
    return tuple(aims)


def _listed(names: _Names) -> tuple[str, ...]:
    return (names,) if isinstance(names, str) else names


def _known(names: Sequence[str], where: str) -> Sequence[str]:
    refuse_unknown(names, QUANTITIES, where)
    return names


def _limits(table: _OptimiseTable, file: str) -> tuple[Limit, ...]:
    limits = []
    _known(list(table.constraints), f"{file}: optimise.constraints")
    for name, item in table.constraints.items():
        key = f"optimise.constraints.{name}"
        given = {"lower": item.lower, "upper": item.upper}
        if item.lower is None and item.upper is None:
            refuse(file, key, given, "lower, upper or both")
        for side, value in given.items():
            if value is None:
                continue
            if not math.isfinite(value):
                refuse(file, f"{key}.{side}", value, "a finite number")
            if name in INDICES and not 0.0 <= value <= 40.0:
                refuse(file, f"{key}.{side}", value, "an index from 0 to 40")
        if item.lower is not None and item.upper is not None and item.lower > item.upper:
            refuse(file, key, [item.lower, item.upper], "lower below upper")
        if item.lower is not None:
            limits.append(Limit(quantity=name, side="lower", value=item.lower))
        if item.upper is not None:
            limits.append(Limit(quantity=name, side="upper", value=item.upper))
    return tuple(limits)


def _parameters(
    table: _OptimiseTable, mechanism: Mechanism, sources: Sources, speed: float, file: str
) -> tuple[Parameter, ...]:
    if not table.parameters:
        refuse(file, "optimise.parameters", [], "at least one [[optimise.parameters]]")
    found: list[Parameter] = []
    taken = {mechanism.shortcuts.get(name, name): f"optimise.set.{name}" for name in table.set}
    for place, item in enumerate(table.parameters):
        key = f"optimise.parameters[{place}]"
        if not item.lower < item.upper or not math.isfinite(item.upper - item.lower):
            refuse(file, key, [item.lower, item.upper], "lower below upper, both finite")
        with at_key(file, key):
            target = find_target(item.path, mechanism)
            if target.kind == "model":
                check_paths([target.path], mechanism)
            start = speed if target.path == SPEED else read_values(sources, [target.path])[0]
        if target.path in taken:
            refuse(file, key, item.path, f"not what {taken[target.path]} gives, too")
        taken[target.path] = key
        check_bounds(target, (item.lower, item.upper), mechanism, key, file)
        found.append(
            Parameter(
                name=item.path, target=target, lower=item.lower, upper=item.upper, start=start
            )
        )
    together = [item.target.path for item in found if item.target.kind == "model"]
    if together:
        with at_key(file, "optimise.parameters"):
            check_paths(together, mechanism)
    return tuple(found)
