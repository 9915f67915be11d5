"""Checks of a panel beyond its nodes, registered by the force elements of a machine.

The nodes of a panel resolve motion that is smooth. Force elements may do something between two
nodes: each kind of element that a machine has brings the check that looks for it, and a machine
without such elements has none.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from ...chebyshev import nodes
from ...dynamics import ConstraintSet, Elements, System
from ..case import Resolution
from .panel import Panel
from .residual_check import shows_end, shows_forces, shows_turns


class PanelCheck(Protocol):
    """One check of a panel."""

    @property
    def name(self) -> str:
        """Name of the effect that it checks."""
        ...

    def resolved(self, phase: ConstraintSet, panel: Panel) -> bool:
        """Return whether the nodes of a panel show it; a panel that does not is made shorter."""
        ...

    def resolved_at_end(self, phase: ConstraintSet, panel: Panel, t_end: float) -> bool:
        """Return whether a flight panel shows it at the event that ends it, at t_end [s]."""
        ...

    def refuse(self, panel: Panel, t_end: float) -> None:
        """Raise an error if the motion up to t_end [s] is one that no element describes."""
        ...


@dataclass(frozen=True)
class _Nothing:
    """A check that finds nothing wrong; others override what they look for."""

    system: System
    elements: Elements
    tolerance: float

    def resolved(self, phase: ConstraintSet, panel: Panel) -> bool:
        del phase, panel
        return True

    def resolved_at_end(self, phase: ConstraintSet, panel: Panel, t_end: float) -> bool:
        del phase, panel, t_end
        return True

    def refuse(self, panel: Panel, t_end: float) -> None:
        del panel, t_end


class TableEnds(_Nothing):
    """Motion beyond the rows of a table, where no force is known.

    Such forces bend the motion to its start, however early the event is that ends it.
    """

    name = "ends of tables"

    def resolved(self, phase: ConstraintSet, panel: Panel) -> bool:
        """Return whether the panel stays where tables give the forces."""
        del phase
        return not self.elements.runs_off(panel.q)

    def refuse(self, panel: Panel, t_end: float) -> None:
        """Raise ElementError if the motion leaves a table; no node may show it."""
        times = panel.t + panel.h * nodes(panel.order).samples
        times = np.append(times[times < t_end], min(t_end, panel.t + panel.h))
        self.elements.check(panel.interpolate(times)[0], times)


class HeatOfLaws(_Nothing):
    """Heat of force laws, which may be those of a user: looked at where the motion is accepted."""

    name = "heat of force laws"

    def refuse(self, panel: Panel, t_end: float) -> None:
        """Raise ElementError if a law takes heat for work."""
        before = panel.times <= t_end
        self.elements.check_heat(panel.q[before], panel.v[before], panel.times[before])


class DamperTurns(_Nothing):
    """Points of a damper that pass one another closely between two nodes."""

    name = "turns of dampers between points"

    def resolved(self, phase: ConstraintSet, panel: Panel) -> bool:
        """Return whether the nodes show how dampers turn."""
        del phase
        return shows_turns(self.elements, panel, self.tolerance)


class BetweenNodes(_Nothing):
    """Rows of tables, kinks of laws and points that meet, between two nodes or at the end."""

    name = "forces between nodes"

    def resolved(self, phase: ConstraintSet, panel: Panel) -> bool:
        """Return whether a flight panel obeys the equations of motion there."""
        return not panel.integrated or shows_forces(self.system, phase, panel, self.tolerance)

    def resolved_at_end(self, phase: ConstraintSet, panel: Panel, t_end: float) -> bool:
        """Return whether it obeys them where an event ends it."""
        return shows_end(self.system, phase, panel, self.tolerance, t_end)


def panel_checks(system: System, resolution: Resolution) -> tuple[PanelCheck, ...]:
    """Return the checks that the force elements of a machine need, the cheapest first."""
    elements = system.elements
    if elements is None:
        return ()
    mechanism = system.mechanism
    with_tables = bool(mechanism.tabulated_springs)
    damped = any(strut.damping > 0.0 for strut in mechanism.struts)
    with_laws = bool(mechanism.forces)
    kinds = (
        (TableEnds, with_tables), (HeatOfLaws, with_laws), (DamperTurns, damped),
        (BetweenNodes, True),
    )  # fmt: skip
    tolerance = resolution.tolerance
    return tuple(kind(system, elements, tolerance) for kind, needed in kinds if needed)
