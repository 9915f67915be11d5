"""Three studies of transitions whose numbers all differ."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np

from benchmarks.paper.studies import Studies, Study


def table(n: int = 2, scale: float = 1.0) -> Any:
    """Transitions whose numbers all differ."""
    place = np.arange(float(n))
    return SimpleNamespace(
        rebound_amplitude=scale * np.stack([2.0 + place, 4.0 + 3.0 * place, place], axis=1),
        rebound_time=scale * np.stack([20.0 - place, 50.0 + place, place], axis=1),
        duration=scale * (100.0 + 10.0 * place), first_two_share=0.9 + 0.01 * place,
        premise_holds=[False, None, True][:n],
        separation_rate=np.stack([9.0 + place, 1.0 + place, np.full(n, np.nan)], axis=1),
        time=np.stack([np.zeros(n), 5.0 + place, 7.0 + 2.0 * place], axis=1),
    )  # fmt: skip


def one_study(name: str, values: tuple[float, ...], scale: float = 1.0) -> Study:
    return Study(name, np.array(values), table(len(values), scale), table(len(values)))


STUDIES = Studies(
    one_study("speed", (450.0, 650.0)), one_study("restitution", (0.05, 0.25), 0.5),
    one_study("stiffness", (7e3, 11e3), 2.0),
)  # fmt: skip
