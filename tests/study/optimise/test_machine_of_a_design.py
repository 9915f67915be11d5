"""The machine of a design has the numbers of that design, whichever were evaluated before."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from designs import parameter, problem

from nipper_pin import Mechanism, load
from nipper_pin.study.optimise.points import Evaluator

# Bounds of what may be free: numbers of the drives, links and points are another machine each.
FREE = {
    "drives.tension.ratio": (2.1, 2.3),
    "links.top_nipper.mass_kg": (1.1, 1.3),
    "points.eccentric_pin.radius_mm": (4.9, 5.1),
    "stops.steeve.restitution": (0.1, 0.4),
    "restitution": (0.1, 0.3),
    "stiffness": (8000.0, 10000.0),
    "preload": (9.0, 13.0),
    "speed_rpm": (500.0, 700.0),
}
PROBLEMS = {
    "settings": ["restitution", "stiffness", "preload", "speed_rpm"],
    "all backwards": list(FREE)[::-1],
}


def numbers(mechanism: Mechanism) -> np.ndarray:
    """What the numbers of a design can change, as the engines read it."""
    model = mechanism.model
    parts = [
        *([stop.restitution] for stop in mechanism.stops),
        *([item.stiffness, item.preload] for item in mechanism.springs),
        *(np.ravel(drive.law.evaluate(np.array([0.7]))) for drive in mechanism.drives),
        *([inertia.mass] for inertia in model.inertias),
        *(place.translation for place in model.jointPlacements),
        *(frame.placement.translation for frame in model.frames),
    ]
    return np.concatenate(parts)


@pytest.mark.parametrize("names", PROBLEMS.values(), ids=PROBLEMS)
def test_the_machine_is_that_of_its_numbers(names: list[str], tmp_path: Path) -> None:
    """Each number moved alone, the first design again, and again after more than are kept."""
    bounds = "".join(parameter(name, *FREE[name]) for name in names)
    asked = problem(tmp_path, f'minimise = "duration_s"\n{bounds}')
    source, count = Evaluator(asked), len(names)
    middle = np.full(count, 0.5)
    alone = [middle + 0.25 * unit for unit in np.eye(count)]
    others = list(np.random.default_rng(4).uniform(size=(17, count)))
    for z in (middle, *alone, middle, *others, middle):
        wanted = load(asked.model, asked.overrides(z))
        np.testing.assert_allclose(numbers(source.mechanism(z)), numbers(wanted), atol=1e-15)
        assert asked.speed(z) == asked.numbers(z).get("speed_rpm", asked.speed_rpm)
