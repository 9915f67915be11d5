"""Stress campaign: thousands of random and extreme trials, judged without a reference."""

from .campaign import Campaign, run_campaign
from .checks.invariants import CHECKS, violations
from .files import begin, keep
from .judging import REFUSED, RIGHT, WRONG, Verdict, judge
from .refusals import Excess, excesses
from .space import FAMILIES, Trial, trial

__all__ = [
    "CHECKS",
    "FAMILIES",
    "REFUSED",
    "RIGHT",
    "WRONG",
    "Campaign",
    "Excess",
    "Trial",
    "Verdict",
    "begin",
    "excesses",
    "judge",
    "keep",
    "run_campaign",
    "trial",
    "violations",
]
