"""Other people's solvers in the benchmark: the same transition, graded by the same four numbers."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import astuple
from functools import partial

from ..peers import available
from .certified import Certified
from .timing import timed
from .work_precision import Row, graded_four

# A setting is not repeated beyond this time [s].
_BUDGET_S, _QUICK_BUDGET_S = 5.0, 0.3

Say = Callable[[str], None]


def peer_rows(
    reference: Certified, *, quick: bool, repeats: int, say: Say
) -> tuple[list[Row], list[str]]:
    """Rows of the peers that are installed, and what could not be measured, and why."""
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
            run = partial(solve, setting)
            try:
                timing = timed(run, repeats, budget)
                *four, evaluations = astuple(run())
            except Exception as error:
                # A setting that is too coarse to find the bounces is a result, too.
                failed.append(f"{peer.NAME}, {setting.label}: {error}")
                continue
            rows.append(
                graded_four(
                    peer.NAME, setting.label, timing, four, reference,
                    evaluations=evaluations, version=version,
                )
            )  # fmt: skip
    return rows, failed
