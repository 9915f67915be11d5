"""The file of a sweep: its keys, and what may stand there."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Literal
from xml.etree import ElementTree

import msgspec
import numpy as np
from msgspec import Meta

from ...dynamics import DriveMode
from ...errors import InputError, NipperError
from ...mechanism import Mechanism, changed
from ...mechanism.files import Positive, parse_xml
from ...texts import MOST_TEXT, read_text
from ..toml_files import Table, at_key, base_mechanism, check_paths, read_table, refuse
from ..turns import MOST_TURNS, TURNS
from .axes import SPEED, Axis, Target, find_target
from .job import COLUMNS, TURN_COLUMNS, Job, TurnJob, versions
from .plan import Plan
from .quantities import check_quantities, default, units_of
from .samples import MOST_SAMPLES, Layout, Method, Samples

_MOST_SCENARIOS = 10**12
_MOST_POINTS = 2**20
_Count = Annotated[int, Meta(ge=1)]


class _CaseTable(Table, frozen=True, kw_only=True):
    """Settings of all scenarios."""

    window: Literal["transition", "cycle"] = "transition"
    turns: Annotated[int, Meta(ge=1, le=MOST_TURNS)] | None = None
    least_force_N: Annotated[float, Meta(ge=0.0)] | None = None
    speed_rpm: Positive | None = None
    drive: Literal["held", "inertial"] = "held"
    rest_rate: Positive | None = None
    tolerance: Annotated[float, Meta(ge=1e-13, le=1e-3)] = 1e-10
    max_collisions: _Count = 256


class _SamplesTable(Table, frozen=True, kw_only=True):
    """How sampled parameters are drawn."""

    method: Method
    count: _Count
    seed: Annotated[int, Meta(ge=0)] = 1


class _ParameterTable(Table, frozen=True, kw_only=True):
    """One parameter: values, or bounds with points (a grid) or without (samples)."""

    values: tuple[float, ...] = ()
    low: float | None = None
    high: float | None = None
    points: Annotated[int, Meta(ge=2, le=_MOST_POINTS)] | None = None
    scale: Literal["linear", "log"] = "linear"


class _StudyTable(Table, frozen=True, kw_only=True):
    """The whole file."""

    format: Literal[1]
    title: str = ""
    model: str = "e62"
    chunk: Annotated[int, Meta(ge=1, le=_MOST_POINTS)] | None = None
    quantities: tuple[str, ...] | None = None
    case: _CaseTable = _CaseTable()
    set: dict[str, object] = msgspec.field(default_factory=dict)
    samples: _SamplesTable | None = None
    parameters: dict[str, _ParameterTable]


def read_plan(path: str) -> Plan:
    """Read and check the file of a sweep.

    Args:
        path: The TOML file; a model that it names is searched beside it first.

    Raises:
        InputError: The file, or something that it names, cannot be used.
    """
    file = Path(path)
    table = read_table(file, _StudyTable)
    mechanism = base_mechanism(table.model, table.set, file)
    turn = _turn(table.case, mechanism, file.name)
    turns = turn is not None
    quantities = table.quantities
    if quantities is None:
        quantities = default(mechanism, turns=turns)
    check_quantities(quantities, mechanism, f"{file.name}: quantities", turns=turns)
    columns = TURN_COLUMNS if turns else COLUMNS
    _check_columns(list(table.parameters), quantities, file.name, columns)
    axes = tuple(
        _axis(name, item, mechanism, file.name, turns=turns)
        for name, item in table.parameters.items()
    )
    if not axes:
        message = f"{file.name}: nothing varies; give [parameters.NAME]"
        raise InputError(message, file=str(file), key="parameters")
    _check_apart(axes, table, mechanism, file.name)
    samples = _samples(table, axes, file.name)
    total = Layout(axes, samples).total
    if total > _MOST_SCENARIOS:
        message = f"{file.name}: parameters: {total} scenarios; at most {_MOST_SCENARIOS}"
        raise InputError(message, key="parameters", scenarios=total)
    speed = table.case.speed_rpm
    job = Job(
        name=mechanism.name,
        urdf=without_visuals(mechanism),
        document=mechanism.description,
        folder=mechanism.mesh_folder,
        axes=axes,
        speed_rpm=mechanism.cylinder.rated_speed_rpm if speed is None else speed,
        drive=DriveMode(table.case.drive),
        rest_rate=table.case.rest_rate,
        tolerance=table.case.tolerance,
        max_collisions=table.case.max_collisions,
        quantities=quantities,
        versions=versions(),
        drawn=_words(samples),
        units=units_of(axes, quantities, mechanism, turns=turns),
        study=read_text(file, MOST_TEXT),
        turn=turn,
    )
    return Plan(title=table.title, job=job, samples=samples, chunk=table.chunk)


def _turn(case: _CaseTable, mechanism: Mechanism, file: str) -> TurnJob | None:
    """What is followed in a sweep of whole turns."""
    if case.window == "cycle":
        if not mechanism.transition_stop:
            refuse(file, "case.window", case.window, "a model with a stop that clamps")
        return TurnJob(turns=case.turns or TURNS, least_force_N=case.least_force_N or 0.0)
    for key in ("turns", "least_force_N"):
        if getattr(case, key) is not None:
            refuse(file, f"case.{key}", getattr(case, key), "only with window = 'cycle'")
    return None


def _words(samples: Samples | None) -> str:
    """Settings that determine the points of the samples, except for their number."""
    if samples is None:
        return ""
    whole = "" if samples.method == "sobol" else f" of {samples.count}"
    return f"{samples.method}{whole}, seed {samples.seed}"


def _check_columns(
    names: Sequence[str], quantities: Sequence[str], file: str, columns: Sequence[str]
) -> None:
    """Refuse names that stand twice at the head of the results."""
    for place, name in enumerate(quantities):
        if name in quantities[:place]:
            refuse(file, "quantities", name, "every name once")
    for name in names:
        if name in (*columns, *quantities):
            refuse(file, f"parameters.{name}", name,
                   "not the name of a column of the results; write the path instead")  # fmt: skip


def _axis(
    name: str, item: _ParameterTable, mechanism: Mechanism, file: str, *, turns: bool
) -> Axis:
    key = f"parameters.{name}"
    if item.values:
        if item.low is not None or item.high is not None or item.points is not None:
            refuse(file, key, "values and bounds", "either values, or low and high")
        low, high = min(item.values), max(item.values)
    elif item.low is None or item.high is None:
        refuse(file, key, "no values", "values = [...], or low and high")
    else:
        low, high = item.low, item.high
    for value in (low, high, *item.values):
        if not math.isfinite(value):
            refuse(file, key, value, "finite numbers")
    if not item.values and not low < high:
        refuse(file, key, [low, high], "low below high")
    if item.scale == "log" and not low > 0.0:
        refuse(file, key, low, "numbers above zero with scale = 'log'")
    values = item.values
    if len(set(values)) != len(values):
        refuse(file, key, list(values), "values that differ")
    if item.points is not None:
        spaced = np.geomspace if item.scale == "log" else np.linspace
        values = tuple(float(value) for value in spaced(low, high, item.points))
    with at_key(file, key):
        target = find_target(name, mechanism, turns=turns)
        if target.kind == "model":
            check_paths([target.path], mechanism)
    check_bounds(target, (low, high), mechanism, key, file)
    return Axis(name=name, target=target, low=low, high=high, scale=item.scale, values=values)


def check_bounds(
    target: Target, bounds: tuple[float, float], mechanism: Mechanism, key: str, file: str
) -> None:
    """Refuse a column of the table that leaves its range; it would refuse the whole table.

    Dimensions are not judged here: a machine that cannot be built is a marked row.

    Args:
        target: What the parameter changes.
        bounds: Its least and its largest value, in the unit of the model's file.
        key: Key of the study, for messages.
        file: Name of the study, for messages.

    Raises:
        ModelError: A bound is no value that the model can have.
    """
    if target.kind == "speed" and not bounds[0] > 0.0:
        refuse(file, key, bounds[0], "speeds above 0 r/min")
    if target.kind in ("speed", "model"):
        return
    for value in bounds:
        try:
            changed(mechanism, {target.path: value})
        except NipperError as error:
            refuse(file, key, value, error.message)


def _check_apart(
    axes: tuple[Axis, ...], table: _StudyTable, mechanism: Mechanism, file: str
) -> None:
    """Refuse parameters that contradict one another or what is fixed."""
    fixed = {mechanism.shortcuts.get(name, name): f"set.{name}" for name in table.set}
    if table.case.speed_rpm is not None:
        fixed[SPEED] = "case.speed_rpm"
    for axis in axes:
        key = f"parameters.{axis.name}"
        if axis.target.path in fixed:
            allowed = f"a path that {fixed[axis.target.path]} does not give already"
            refuse(file, key, axis.target.path, allowed)
        fixed[axis.target.path] = key
    moving = [axis.target.path for axis in axes if axis.target.kind == "model"]
    if moving:
        with at_key(file, "parameters"):
            check_paths(moving, mechanism)


def _samples(table: _StudyTable, axes: tuple[Axis, ...], file: str) -> Samples | None:
    drawn = [axis.name for axis in axes if not axis.values]
    if not drawn:
        if table.samples is not None:
            refuse(file, "samples", table.samples.method, "a parameter without points or values")
        return None
    if table.samples is None:
        refuse(file, f"parameters.{drawn[0]}", "no points", "points, or a table [samples]")
    method, count = table.samples.method, table.samples.count
    if count > MOST_SAMPLES[method]:
        refuse(file, "samples.count", count, f"at most {MOST_SAMPLES[method]} with {method}")
    return Samples(method=method, count=count, seed=table.samples.seed)


def without_visuals(mechanism: Mechanism) -> str:
    """The URDF without what is only looked at; workers need not have the files of its meshes."""
    root = parse_xml(mechanism.urdf, f"{mechanism.name}.urdf")
    for link in root.findall("link"):
        for visual in link.findall("visual"):
            link.remove(visual)
    return ElementTree.tostring(root, encoding="unicode")
