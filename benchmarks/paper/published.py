"""Published numbers, read from the file beside this one, and the same numbers of other machines."""

from __future__ import annotations

import tomllib
from dataclasses import dataclass, replace
from functools import cache
from importlib import resources
from typing import Any

from nipper_pin.mechanism import Mechanism

from ..peers.planar_model import e62_laws


@dataclass(frozen=True)
class Published:
    """Conditions and results of the published study, or conditions of the same for another machine.

    The common speed is that of the studies of restitutions and spring rates [N/m or N m/rad], the
    common restitution, which is inferred and not printed, that of speeds and spring rates.
    """

    source: str
    speeds_rpm: tuple[float, ...]
    restitutions: tuple[float, ...]
    stiffnesses: tuple[float, ...]
    common_speed_rpm: float
    common_restitution: float
    ratios: dict[str, float]
    count_increase: float | None


@cache
def published() -> Published:
    """Read the published numbers."""
    text = resources.files(__package__).joinpath("published.toml").read_text(encoding="utf-8")
    data = tomllib.loads(text)
    given: dict[str, Any] = {
        key: tuple(value) if isinstance(value, list) else value
        for key, value in data["conditions"].items()
    }
    return Published(source=data["source"], ratios=data["ratios"], **given)


def conditions(mechanism: Mechanism) -> Published:
    """The published study if the mechanism is an E62 in all but its numbers, or the same for it.

    For another machine speeds stand to its rated speed and spring rates to its own one as the
    published ones to those of the E62, and there is nothing to compare with.
    """
    given = published()
    if e62_laws(mechanism) is not None or not mechanism.springs:
        return given
    faster = mechanism.cylinder.rated_speed_rpm / given.speeds_rpm[0]
    middle = given.stiffnesses[len(given.stiffnesses) // 2]
    stiffer = mechanism.springs[0].stiffness / middle
    speeds = tuple(float(round(faster * speed)) for speed in given.speeds_rpm)
    return replace(
        given,
        speeds_rpm=speeds,
        stiffnesses=tuple(stiffer * rate for rate in given.stiffnesses),
        common_speed_rpm=speeds[given.speeds_rpm.index(given.common_speed_rpm)],
        ratios={},
        count_increase=None,
    )
