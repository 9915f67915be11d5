"""Other people's solvers in the benchmark: the same transition, graded by the same four numbers."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

from ..peers import Four, available
from .certified import Certified
from .timing import Timing, timed
from .work_precision import Row

# As they are known to package indices, for the header.
PACKAGES = ("mujoco", "scikit-sundae")
# A setting is not repeated beyond this time [s].
_BUDGET_S, _QUICK_BUDGET_S = 5.0, 0.3

Say = Callable[[str], None]


def peer_rows(
    reference: Certified, *, quick: bool, repeats: int, say: Say
) -> tuple[list[Row], list[str]]:
    """Time and grade the peers that are installed.

    Returns:
        Rows, and what could not be measured and why.
    """
    mechanism = reference.mechanism()
    budget = _QUICK_BUDGET_S if quick else _BUDGET_S
    rows: list[Row] = []
    failed: list[str] = []
    for peer, version in available():
        say(f"peer {peer.NAME}")
        try:
            solve = peer.prepare(mechanism, reference.speed_rpm)
        except Exception as error:
            # Foreign programs fail in ways of their own; the others are still worth measuring.
            failed.append(f"{peer.NAME}: {error}")
            continue
        for setting in peer.SETTINGS:
            if quick and not setting.quick:
                continue
            last: list[Four] = []

            def run(setting: Any = setting, solve: Any = solve, last: list[Four] = last) -> None:
                last[:] = [solve(setting)]

            try:
                timing = timed(run, repeats, budget)
            except Exception as error:
                # A setting that is too coarse to find the bounces is a result, too.
                failed.append(f"{peer.NAME}, {setting.label}: {error}")
                continue
            found = last[0]
            four = (
                found.first_rebound_time_s,
                found.second_rebound_time_s,
                found.first_amplitude,
                found.transition_time_s,
            )
            rows.append(
                graded_peer(
                    peer.NAME, setting.label, version, timing, four, found.evaluations, reference
                )
            )
    return rows, failed


def graded_peer(
    name: str,
    setting: str,
    version: str,
    timing: Timing,
    four: Sequence[float],
    evaluations: int,
    reference: Certified,
) -> Row:
    """One row: first and second rebound time [s], first amplitude [rad], transition time [s]."""
    true = (*reference.rebound_times[:2], reference.amplitudes[0], reference.transition_time)
    errors = [float(found / exact - 1.0) for found, exact in zip(four, true, strict=True)]
    # max() would pass over what is not a number.
    known = all(math.isfinite(item) for item in errors)
    return Row(
        engine=name,
        setting=setting,
        wall_ms=timing.median_ms,
        first_ms=timing.first_ms,
        fastest_ms=timing.fastest_ms,
        spread_ms=timing.spread_ms,
        runs=timing.runs,
        error_duration=abs(errors[3]) if math.isfinite(errors[3]) else None,
        error_worst=max(abs(item) for item in errors) if known else None,
        evaluations=evaluations,
        version=version,
    )
