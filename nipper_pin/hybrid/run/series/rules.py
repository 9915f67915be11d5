"""Rules of what follows a collision, by what a machine has.

Bounces end at rest after a finite time: every machine with a stop has this rule. Two stops may also
throw one another open, jam a link between them, or bounce until nothing but round-off is left: only
a machine with two stops or more has these rules.
"""

from __future__ import annotations

from collections.abc import Sequence

from ....dynamics import System
from ...case import Case
from ...event import Event
from .bounces import Bounces
from .jams import Jams
from .nested import NestedBounces
from .struck import SeriesRule
from .vanishing import VanishingBounces


def series_rules(system: System, case: Case, events: Sequence[Event]) -> tuple[SeriesRule, ...]:
    """Return the rules of a machine, in the order in which they are asked.

    Args:
        events: The events of the run, as they are written down.
    """
    bounces = Bounces(system, case)
    if len(system.mechanism.stops) < 2:
        return (bounces,)
    rules: list[SeriesRule] = [Jams(system, events), NestedBounces(system, case)]
    if any(stop.at for stop in system.mechanism.stops):
        rules.append(VanishingBounces(system, case))
    return (*rules, bounces)
