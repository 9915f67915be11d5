"""One run, from its case to its solution."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import fields as dataclass_fields
from typing import Any

from ..dynamics import ShaftMotion, System
from ..errors import InputError, UnknownNameError
from ..mechanism import Mechanism, need_mechanism, rad_s_from_rpm
from ..mechanism.parallel import led
from .case import Case, Window
from .parallel import for_all
from .result.solution import Solution
from .run.phase_manager import PhaseManager
from .run.windows import start_of, transition, turns


def simulate(
    mechanism: Mechanism,
    case: Case | None = None,
    progress: Callable[[int, int], None] | None = None,
    **fields: Any,
) -> Solution:
    """Simulate a mechanism.

    Args:
        mechanism: The mechanism.
        case: What to simulate.
        progress: Called with (turns done, turns in all) after each turn.
        fields: Fields of ``Case`` in place of a case, such as ``speed_rpm=650.0`` or
            ``window="cycle"``; the speed is the rated one if none is given.

    Returns:
        The solution; its ``outcome`` says how the run ended.

    Raises:
        SimulationError: The motion cannot be followed; the message says where and why.
        InputError: The mechanism does not close in its touch configuration, or is only its name.
        UnknownNameError: A case has no such field.
    """
    need_mechanism(mechanism, "simulate")
    if case is None:
        case = _case(mechanism, fields)
    elif fields or not isinstance(case, Case):
        message = (
            f"simulate takes a case, nip.Case(speed_rpm=650.0), or its fields, speed_rpm=650.0, "
            f"and this is {', '.join([repr(case), *fields])}"
        )
        raise InputError(message, case=case)
    began = time.perf_counter()
    touching = case.window is Window.TRANSITION
    cylinder = mechanism.cylinder
    angle = cylinder.angle_at_touch_rad if touching else cylinder.angle_from_index(case.start_index)
    shaft = ShaftMotion(mechanism, rad_s_from_rpm(case.speed_rpm), angle)
    system = System(led(mechanism), shaft, case.drive)
    before = system.body.evaluations
    manager = PhaseManager(system, case, start_of(system, case))
    outcome, repeated = (transition(manager), None) if touching else turns(manager, progress)
    events, segments = for_all(mechanism, manager.events, manager.segments)
    return Solution(
        mechanism=mechanism,
        case=case,
        shaft=shaft,
        events=events,
        segments=segments,
        outcome=outcome,
        evaluations=system.body.evaluations - before,
        wall_s=time.perf_counter() - began,
        repeated_from=repeated,
    )


def _case(mechanism: Mechanism, given: Mapping[str, Any]) -> Case:
    """The case with these fields, at the rated speed if that is none of them."""
    known = [item.name for item in dataclass_fields(Case)]
    for name in given:
        if name not in known:
            raise UnknownNameError(kind="field of a case", name=name, known=known, where="simulate")
    return Case(**{"speed_rpm": mechanism.cylinder.rated_speed_rpm, **given})
