"""Everything of the published study in one call."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from ...hybrid.case import Case
from ...hybrid.result.solution import Solution
from ...hybrid.simulate import simulate
from ...mechanism import Mechanism, load
from .counts import Counts, collision_counts
from .designs import DesignMap, design_map
from .drives import DriveComparison, compare_drives
from .fixed_step import FixedStep, fixed_step
from .kinematics import Kinematics, kinematics
from .phase_one import PhaseOne, phase_one
from .published import Published, conditions
from .ratios import Ratio, ratio_values, ratios, within
from .shares import Shares, shares
from .studies import Studies, run_studies

NEAR, FAR = 0.04, 0.10
IDENTIFIED = "e62_identified"
"""Model whose numbers were identified from the same ratios; shown beside every other one."""


@dataclass(frozen=True)
class PaperStudy:
    """The published study done again, and the questions that it leaves open.

    Attributes:
        mechanism: The mechanism.
        published: What was published; for a machine that is no E62 its own conditions.
        studies: Transitions over speed, restitution and spring rate.
        ratios: Published ratios beside ours; empty for a machine that is no E62.
        identified: The same of the identified model; empty if that is the mechanism.
        motions: Transitions at the published speeds, with their motion.
        kinematics: Phases 1 and 2 over a turn.
        counts: Numbers of collisions against the threshold.
        drives: Held and inertial shafts.
        phase_one: Whether the steeve stays on its stop.
        fixed_step: The published scheme against ours; None without a hand-derived equation.
        shares: Shares of the first two rebounds over the restitution.
        designs: Map of the transition time.
    """

    mechanism: Mechanism
    published: Published
    studies: Studies
    ratios: tuple[Ratio, ...]
    identified: tuple[Ratio, ...]
    motions: tuple[Solution, ...]
    kinematics: Kinematics
    counts: Counts
    drives: DriveComparison
    phase_one: PhaseOne
    fixed_step: FixedStep | None
    shares: Shares
    designs: DesignMap

    @property
    def compared(self) -> bool:
        """True if the published ratios are those of this kind of machine."""
        return bool(self.ratios)

    def within(self, deviation: float) -> int:
        """Number of ratios that deviate by no more than this."""
        return within(self.ratios, deviation)

    def record(self) -> dict[str, Any]:
        """Return the study as plain data, SI units."""
        return {
            "model": self.mechanism.name,
            "title": self.mechanism.title,
            "note": note(self),
            "source": self.published.source,
            "ratios": [item.record() for item in self.ratios],
            "agreement": _agreement(self.ratios),
            "changes": ratio_values(self.studies),
            "identified": {
                "model": IDENTIFIED,
                "ratios": [item.record() for item in self.identified],
                "agreement": _agreement(self.identified),
            },
            "studies": {study.name: study.record() for study in self.studies},
            "collision_counts": self.counts.record(),
            "kinematics": self.kinematics.record(),
            "drives": self.drives.record(),
            "phase_1": self.phase_one.record(),
            "fixed_step": None if self.fixed_step is None else self.fixed_step.record(),
            "shares": self.shares.record(),
            "duration_map": self.designs.record(),
        }


def note(study: PaperStudy) -> str:
    """Note on the origin of the model's numbers, shown beside every result of them."""
    if study.compared:
        return (
            "Numbers of the model are an estimate of the E62 class identified from the published "
            "ratios, never the maker's data; that they agree with these ratios validates nothing."
        )
    return (
        "Every result is as good as the numbers of the model; the combers that come with this "
        "package are estimates of their class, never a maker's data."
    )


def _agreement(items: Sequence[Ratio]) -> dict[str, int]:
    return {
        "of": len(items),
        "within_4_percent": within(items, NEAR),
        "within_10_percent": within(items, FAR),
    }


def paper_study(mechanism: Mechanism, say: Callable[[str], None] | None = None) -> PaperStudy:
    """Do the published study again and answer what it leaves open.

    Args:
        mechanism: The E62 or another set of numbers for it; or another comber, on which the same
            is done without a comparison.
        say: Told what is being done.

    Raises:
        InputError: The mechanism has not one spring and, closed in its initial phase, one stop.
        SimulationError: A transition or turn cannot be simulated.
    """
    tell = say or (lambda _: None)
    given = conditions(mechanism)
    tell("three studies")
    studies = run_studies(mechanism, given)
    beside: tuple[Ratio, ...] = ()
    if given.ratios and mechanism.name != IDENTIFIED:
        beside = ratios(run_studies(load(IDENTIFIED), given), given)
    tell("held and inertial shafts")
    drives = compare_drives(mechanism, given)
    tell("phases 1 and 2")
    turns, stop = kinematics(mechanism, given.speeds_rpm), phase_one(mechanism, given.speeds_rpm)
    steps = None
    if given.ratios:
        tell("fixed steps as published")
        steps = fixed_step(mechanism, given)
    tell("maps")
    return PaperStudy(
        mechanism=mechanism,
        published=given,
        studies=studies,
        ratios=ratios(studies, given),
        identified=beside,
        motions=tuple(simulate(mechanism, Case(speed_rpm=speed)) for speed in given.speeds_rpm),
        kinematics=turns,
        counts=collision_counts(studies, given),
        drives=drives,
        phase_one=stop,
        fixed_step=steps,
        shares=shares(mechanism, given),
        designs=design_map(mechanism, given),
    )
