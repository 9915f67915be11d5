"""Largest share of refused cases of a family, since refusing all would pass all checks."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass

from ..tolerances import FALSE_ALARM
from .judging import REFUSED, Verdict

# Refused of 385 cases of each family (benchmarks/README.md), 10,000 cases of seed 421; of linkages,
# 385 cases of that seed alone.
_CASES = 385
MEASURED = {
    "ordinary": 3, "speed": 3, "restitution": 3, "spring": 0, "mass ratio": 2, "little inertia": 5,
    "reach": 189, "dead centre": 289, "grazing": 89, "edges": 136, "together": 0, "gravity": 2,
    "overlap": 0, "many cycles": 0, "tolerance": 1, "rough table": 48, "threshold": 3,
    "inertial drive": 0, "bouncing mass": 0, "two stops": 0, "chain": 34, "hard elements": 23,
    "spring tables": 79, "near points": 68, "slots": 153, "nipper with elements": 148,
    "linkage": 0,
}  # fmt: skip
# A share measured on 385 cases is accurate to a few percent; two more are allowed.
_MORE, _ROOM = 1.2, 0.02


@dataclass(frozen=True)
class Excess:
    """A family, or "all", of which more cases are refused than this share, which may be."""

    family: str
    refused: int
    cases: int
    share: float


def allowed_share(family: str) -> float:
    """Share of a family's cases that may be refused; that of all cases for "all".

    A family that is not measured may not refuse more than all others together.
    """
    one = MEASURED.get(family, sum(MEASURED.values()) / len(MEASURED)) / _CASES
    return min(_MORE * one + _ROOM, 0.5 * (1.0 + one))


def excesses(verdicts: Iterable[Verdict]) -> list[Excess]:
    """Families, and all together, of which more is refused than chance explains."""
    from scipy.special import bdtrc

    refused, cases = Counter[str](), Counter[str]()
    for verdict in verdicts:
        for family in (verdict.family, "all"):
            cases[family] += 1
            refused[family] += verdict.word == REFUSED
    found = []
    for family, count in cases.items():
        share = allowed_share(family)
        # Chance of as many refusals or more among so many cases.
        if refused[family] and bdtrc(refused[family] - 1, count, share) < FALSE_ALARM:
            found.append(Excess(family, refused[family], count, share))
    return found
