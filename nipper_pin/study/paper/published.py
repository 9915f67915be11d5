"""What the study published, read from the file beside this one."""

from __future__ import annotations

import tomllib
from dataclasses import dataclass
from functools import cache
from importlib import resources


@dataclass(frozen=True)
class Published:
    """Conditions and results of the published study.

    Attributes:
        source: Where it was published.
        speeds_rpm: Speeds of the first study [r/min].
        restitutions: Restitutions of the second.
        stiffnesses: Spring rates of the third [N/m].
        common_speed_rpm: Speed of the second and third [r/min].
        common_restitution: Restitution of the first and third; inferred, not printed.
        time_step_s: Fixed step of its integration [s].
        ratios: The ratios that are compared, by name.
        count_increase: Increase of the number of collisions with the restitution.
        count_changes: Whether the number of collisions changes with the spring rate.
    """

    source: str
    speeds_rpm: tuple[float, ...]
    restitutions: tuple[float, ...]
    stiffnesses: tuple[float, ...]
    common_speed_rpm: float
    common_restitution: float
    time_step_s: float
    ratios: dict[str, float]
    count_increase: float
    count_changes: bool


@cache
def published() -> Published:
    """Read the published numbers."""
    text = resources.files(__package__).joinpath("published.toml").read_text(encoding="utf-8")
    data = tomllib.loads(text)
    conditions, counts = data["conditions"], data["counts"]
    return Published(
        source=data["source"],
        speeds_rpm=tuple(conditions["speeds_rpm"]),
        restitutions=tuple(conditions["restitutions"]),
        stiffnesses=tuple(conditions["stiffnesses_N_per_m"]),
        common_speed_rpm=conditions["common_speed_rpm"],
        common_restitution=conditions["common_restitution"],
        time_step_s=conditions["time_step_s"],
        ratios=data["ratios"],
        count_increase=counts["restitution_increase"],
        count_changes=counts["stiffness_changes"],
    )
