"""Everything of the published study in one call."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from nipper_pin.hybrid import Case, Solution, simulate
from nipper_pin.mechanism import Mechanism, load

from .counts import Counts, collision_counts
from .drives import DriveComparison, compare_drives
from .fixed_step import FixedStep, fixed_step
from .phases import PhaseOne, kinematics, phase_one
from .published import Published, conditions
from .ratios import Ratio, agreement, ratio_values, ratios
from .shares import DurationMap, Shares, duration_map, shares
from .studies import Studies, run_studies

IDENTIFIED = "e62_identified"
_ESTIMATE = (
    "Numbers of the model are an estimate of the E62 class identified from the published "
    "ratios, never the maker's data; that they agree with these ratios validates nothing."
)
_ANY = (
    "Every result is as good as the numbers of the model; the combers that come with this "
    "package are estimates of their class, never a maker's data."
)


@dataclass(frozen=True)
class PaperStudy:
    """The published study done again, and the questions that it leaves open.

    Without published ratios, for a machine that is no E62, ``ratios`` and ``identified``, those of
    the identified model, are empty, and there is no scheme of fixed steps.
    """

    mechanism: Mechanism
    published: Published
    studies: Studies
    ratios: tuple[Ratio, ...]
    identified: tuple[Ratio, ...]
    motions: tuple[Solution, ...]
    kinematics: dict[str, float]
    counts: Counts
    drives: DriveComparison
    phase_one: PhaseOne
    fixed_step: FixedStep | None
    shares: Shares
    durations: DurationMap

    @property
    def compared(self) -> bool:
        """True if the published ratios are those of this kind of machine."""
        return bool(self.ratios)

    @property
    def note(self) -> str:
        """Note on the origin of the model's numbers, shown beside every result of them."""
        return _ESTIMATE if self.compared else _ANY

    def record(self) -> dict[str, Any]:
        """Return the study as plain data, SI units."""
        return {
            "model": self.mechanism.name,
            "title": self.mechanism.title,
            "note": self.note,
            "source": self.published.source,
            "ratios": [item.record() for item in self.ratios],
            "agreement": agreement(self.ratios),
            "changes": ratio_values(self.studies),
            "identified": {
                "model": IDENTIFIED,
                "ratios": [item.record() for item in self.identified],
                "agreement": agreement(self.identified),
            },
            "studies": {study.name: study.record() for study in self.studies},
            "collision_counts": self.counts.record(),
            "kinematics": self.kinematics,
            "drives": self.drives.record(),
            "phase_1": self.phase_one.record(),
            "fixed_step": None if self.fixed_step is None else self.fixed_step.record(),
            "shares": self.shares.record(),
            "duration_map": self.durations.record(),
        }


def paper_study(mechanism: Mechanism, say: Callable[[str], None]) -> PaperStudy:
    """Do the published study again and answer what it leaves open, telling what is being done.

    Raises:
        InputError: The mechanism has not one spring and, closed in its initial phase, one stop.
        SimulationError: A transition or turn cannot be simulated.
    """
    given = conditions(mechanism)
    say("three studies")
    studies = run_studies(mechanism, given)
    beside: tuple[Ratio, ...] = ()
    if given.ratios and mechanism.name != IDENTIFIED:
        beside = ratios(run_studies(load(IDENTIFIED), given), given)
    say("held and inertial shafts")
    drives = compare_drives(mechanism, given)
    say("phases 1 and 2")
    turn, stop = kinematics(mechanism, given.speeds_rpm[0]), phase_one(mechanism, given.speeds_rpm)
    steps = None
    if given.ratios:
        say("fixed steps as published")
        steps = fixed_step(mechanism, given)
    say("maps")
    motions = tuple(simulate(mechanism, Case(speed_rpm=speed)) for speed in given.speeds_rpm)
    return PaperStudy(
        mechanism, given, studies, ratios(studies, given), beside, motions, turn,
        collision_counts(studies, given), drives, stop, steps, shares(mechanism, given),
        duration_map(mechanism, given),
    )  # fmt: skip
