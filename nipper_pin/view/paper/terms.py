"""Names and units of one machine in the figures, tables and sentences of the report."""

from __future__ import annotations

from dataclasses import dataclass

from ...hybrid.result.quantities import coordinate_unit
from ...mechanism import Mechanism
from ...study.paper import PaperStudy
from ...terms import Shown, named, shown_in
from ..naming import coordinate_shown, shown

_E62 = "estimate of the E62 class identified from the published ratios; not the maker's data"
_OTHER = "numbers of the model; those of the package's combers are estimates, no maker's data"

TIME = named("duration_s")
"""Time to rest."""
REBOUND_TIME = named("rebound_time_s")
SHARE = named("first_two_share")


@dataclass(frozen=True)
class Terms:
    """Names and units.

    Attributes:
        compared: True if there are published numbers of this kind of machine.
        mark: What every figure says of its numbers.
        stop: Name of the stop that is closed while the jaw is open.
        stroke: Its coordinate.
        lift: The same where it is small.
        stroke_si: SI unit of that coordinate.
        rebound: Amplitudes of rebounds.
        rate: Spring rates.
        rate_si: SI unit of spring rates, as in names of columns.
        preload: Preloads.
        preload_kind: What a preload is: a length or an angle.
    """

    compared: bool
    mark: str
    stop: str
    stroke: Shown
    lift: Shown
    stroke_si: str
    rebound: Shown
    rate: Shown
    rate_si: str
    preload: Shown
    preload_kind: str

    def of_paper(self, what: str) -> str:
        """Number of the figure or table of the paper, in brackets; empty for other machines."""
        return f" ({what} of the paper)" if self.compared else ""


def terms(study: PaperStudy) -> Terms:
    """Names and units of the machine of a study."""
    mechanism = study.mechanism
    stop = mechanism.stop(study.phase_one.stop)
    turns = coordinate_unit(mechanism, mechanism.springs[0].index) == "rad"
    return Terms(
        compared=study.compared,
        mark=_E62 if study.compared else _OTHER,
        stop=stop.name,
        stroke=coordinate_shown(mechanism, stop.index),
        lift=coordinate_shown(mechanism, stop.index, small=True),
        stroke_si=coordinate_unit(mechanism, stop.index),
        rebound=rebound(mechanism),
        rate=_shown("spring rate", "N m/rad" if turns else "N/m"),
        rate_si="N_m_per_rad" if turns else "N_per_m",
        preload=_shown("preload", "rad" if turns else "m"),
        preload_kind="angle" if turns else "length",
    )


def unit_text(quantity: Shown | str) -> str:
    """A unit with its Greek letter, which terminals do without."""
    return (quantity if isinstance(quantity, str) else quantity.unit).replace("um", "µm")


def rebound(mechanism: Mechanism) -> Shown:
    """How people read amplitudes of the jaw's rebounds."""
    return shown(mechanism, "rebound_amplitude")


def _shown(words: str, file_unit: str) -> Shown:
    unit, factor = shown_in(file_unit)
    return Shown(words=words, unit=unit, factor=factor)
