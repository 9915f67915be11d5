"""Every quantity of a run, a turn and a design, once: name, words, symbol, unit, digits, holder.

Documents, tables, plots, reports, sweeps, optimisations, identifications and the live page take
them from here. What has to be computed of a run to read one stands in ``hybrid.result``.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

from .shown import Shown, shown_in


@dataclass(frozen=True, kw_only=True)
class Term:
    """What one quantity is called.

    Attributes:
        name: In files.
        words: For people.
        symbol: As in docs/notation.md; empty without one.
        unit: In files, empty without one. ``{gap}`` is the unit of the stop's coordinate.
        small: Whether it is of the size of rebounds: angles are read in mdeg, lengths in um.
        share: Whether it is read in per cent.
        decimals: Decimals in the unit that people read; None for four significant digits.
        only: "run" of what tables of many cases lack, "table" of what runs lack; empty if both
            have it.
        force: Unit of the force of the stops or drives that have it; empty if all do.
        held: Attribute of runs and tables that holds it, where it is not its name without unit.
    """

    name: str
    words: str
    symbol: str = ""
    unit: str = ""
    small: bool = False
    share: bool = False
    decimals: int | None = None
    only: Literal["", "run", "table"] = ""
    force: str = ""
    held: str = ""

    @property
    def attribute(self) -> str:
        """Attribute of runs and tables that holds it."""
        return self.held or self.name.removesuffix("_" + self.unit.replace(" ", "_"))

    def shown(self, gap: str = "rad") -> Shown:
        """How people read it.

        Args:
            gap: Unit of the coordinate of its stop, rad or m.
        """
        unit, factor = shown_in(self.unit.format(gap=gap), small=self.small, share=self.share)
        return Shown(
            words=self.words,
            unit=unit,
            factor=factor,
            decimals=self.decimals,
        )


def _both(
    name: str,
    words: str,
    symbol: str = "",
    per: str = "",
    only: Literal["", "run", "table"] = "",
) -> list[Term]:
    """A force or an impulse; of a stop on a hinge without a contact point it is a moment."""
    return [
        Term(name=f"{name}_{unit}{per}".replace(" ", "_"), words=words, symbol=symbol,
             unit=f"{unit}{per}", only=only, force=unit)
        for unit in ("N", "N m")
    ]  # fmt: skip


_COLLISION = (
    Term(name="t_s", words="time from the start", symbol="t", unit="s", decimals=3, only="run"),
    Term(name="time_s", words="time from the first collision", unit="s", decimals=3),
    Term(name="cylinder_angle_rad", words="cylinder angle", symbol="psi", unit="rad", decimals=3),
    Term(name="index", words="index", decimals=3, only="run"),
    Term(name="approach_rate", words="rate before", symbol="g_N_dot", unit="{gap}/s"),
    Term(name="separation_rate", words="rate after", symbol="w", unit="{gap}/s"),
    *_both("impulse", "impulse", "P_N", " s"),
    Term(name="energy_lost_J", words="energy lost", unit="J"),
    Term(name="rebound_amplitude", words="rebound amplitude", unit="{gap}", small=True),
    Term(name="rebound_time_s", words="rebound time", unit="s"),
    Term(name="time_error_s", words="error of the time", unit="s"),
    Term(name="impulse_error", words="relative error of rates and impulse", only="run"),
    Term(name="rate_error", words="error of the rate before", unit="{gap}/s", only="table"),
    *_both("impulse_error", "error of the impulse", "", " s", "table"),
    Term(
        name="amplitude_error",
        words="error of the amplitude",
        unit="{gap}",
        small=True,
        only="table",
    ),
    Term(name="rebound_error_s", words="error of the rebound time", unit="s", only="table"),
)
_TRANSITION = (
    Term(name="premise_holds", words="machine arrives as a transition assumes", only="run"),
    Term(name="duration_s", words="time to rest", unit="s"),
    Term(name="duration_error_s", words="error of the time to rest", unit="s"),
    Term(name="collisions", words="collisions", decimals=0, only="run"),
    Term(name="first_two_share", words="share of the first two rebounds", share=True),
)
_EVENTS = ("closing", "rest", "loss", "opening")
_TURN = (
    Term(name="turns", words="turns followed", decimals=0),
    Term(name="repeats_after", words="turns until the motion repeats", decimals=0),
    Term(name="clamped_time_s", words="time clamped", unit="s"),
    Term(name="clamped_time_error_s", words="error of the time clamped", unit="s", only="table"),
    Term(name="clamped_share", words="share of the turn clamped", share=True),
    *(
        term
        for event in _EVENTS
        for term in (
            Term(name=f"{event}_index", words=f"index of {event}", decimals=3),
            Term(name=f"{event}_index_error", words=f"error of the index of {event}"),
        )
    ),
    *_both("least_clamping_force", "smallest clamping force"),
    *_both("largest_clamping_force", "largest clamping force"),
    *_both("clamping_force_error", "error of both clamping forces", only="table"),
    Term(name="largest_gap", words="largest gap of a rebound", unit="{gap}", small=True),
    Term(name="largest_gap_error", words="error of the largest gap", unit="{gap}", small=True),
    Term(name="energy_lost_turn_J", words="energy lost in the turn", unit="J", held="energy_lost"),
    Term(
        name="energy_lost_turn_error_J",
        words="error of the energy lost",
        unit="J",
        held="energy_lost_error",
    ),
)
_TURN_STOP = (
    Term(name="collisions", words="collisions", decimals=0),
    *_both("impulse_sum", "sum of the impulses", "", " s"),
    *_both("impulse_sum_error", "error of the sum of the impulses", "", " s"),
    *_both("largest_impulse", "largest impulse", "", " s"),
    *_both("largest_impulse_error", "error of the largest impulse", "", " s"),
)
_TURN_DRIVE = (
    *_both("largest_torque", "largest torque between events"),
    *_both("largest_torque_error", "error of the largest torque", only="table"),
)
_DESIGN = (
    Term(name="clamping_force_N", words="clamping force", symbol="la_N", unit="N"),
    Term(name="stop_force_N", words="least force of the stop of the initial phase", unit="N"),
    Term(name="jaw_opening_deg", words="widest opening of the transition stop", unit="deg"),
    Term(
        name="stroke_mm",
        words="largest stroke with the transition stop closed",
        symbol="s",
        unit="mm",
    ),
    Term(name="rest_margin", words="indices from rest to opening", decimals=3),
    Term(name="speed_rpm", words="cylinder speed", unit="r/min"),
)
SUBJECTS: Mapping[str, tuple[Term, ...]] = {
    "A collision": _COLLISION,
    "A transition": _TRANSITION,
    "A turn": _TURN,
    "A stop in a turn": _TURN_STOP,
    "A drive in a turn": _TURN_DRIVE,
    "A design": _DESIGN,
}
"""All terms by what they are of."""
TERMS: Mapping[str, Term] = {item.name: item for group in SUBJECTS.values() for item in group}
"""All terms by their names in files."""


_NUMBERED = re.compile(r"(.+)_([1-9][0-9]{0,3})")


def term_of(name: str) -> tuple[Term, int]:
    """The term of a name in files, and the number of the collision behind it; 0 without one.

    Args:
        name: Such as ``duration_s``, or ``rebound_time_s_2`` of the second collision.

    Raises:
        KeyError: There is none.
    """
    if name in TERMS:
        return TERMS[name], 0
    found = _NUMBERED.fullmatch(name)
    if found is None or found[1] not in TERMS:
        raise KeyError(name)
    return TERMS[found[1]], int(found[2])
