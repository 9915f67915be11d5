"""Names and units of one machine in the figures, tables and sentences of the report."""

from __future__ import annotations

from dataclasses import dataclass

from ...study.paper import PaperStudy
from ...units import DEG_PER_RAD, M_PER_MM, MM_PER_M
from ..reading import Units, units_of

_E62 = "estimate of the E62 class identified from the published ratios; not the maker's data"
_OTHER = "numbers of the model; those of the package's combers are estimates, no maker's data"


@dataclass(frozen=True)
class Terms:
    """Names and units.

    Attributes:
        compared: True if there are published numbers of this kind of machine.
        mark: What every figure says of its numbers.
        stop: Name of the stop that is closed while the jaw is open.
        stroke: Units of its coordinate.
        stroke_si: SI unit of that coordinate.
        rate_si: SI unit of spring rates, as in names of columns.
        rate_factor: Spring rates from SI to ``rate_unit``.
        rate_unit: Unit of spring rates.
        preload_kind: What a preload is: a length or an angle.
        preload_factor: Preloads from SI to ``preload_unit``.
        preload_unit: Unit of preloads.
    """

    compared: bool
    mark: str
    stop: str
    stroke: Units
    stroke_si: str
    rate_si: str
    rate_factor: float
    rate_unit: str
    preload_kind: str
    preload_factor: float
    preload_unit: str

    def of_paper(self, what: str) -> str:
        """Number of the figure or table of the paper, in brackets; empty for other machines."""
        return f" ({what} of the paper)" if self.compared else ""


def terms(study: PaperStudy) -> Terms:
    """Names and units of the machine of a study."""
    mechanism = study.mechanism
    stop = mechanism.stop(study.phase_one.stop)
    units = units_of(mechanism, stop.index)
    if units_of(mechanism, mechanism.springs[0].index).noun == "angle":
        spring = ("N_m_per_rad", 1.0, "N m/rad", "angle", DEG_PER_RAD, "deg")
    else:
        spring = ("N_per_m", M_PER_MM, "N/mm", "length", MM_PER_M, "mm")
    mark = _E62 if study.compared else _OTHER
    stroke_si = "rad" if units.noun == "angle" else "m"
    return Terms(study.compared, mark, stop.name, units, stroke_si, *spring)
