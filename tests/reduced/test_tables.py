"""When the tables of a domain are fine enough, on functions that are known."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from nipper_pin import ConvergenceError
from nipper_pin.reduced.tables import series2d
from nipper_pin.reduced.tables.functions import Samples
from nipper_pin.reduced.tables.tables import Domain, resolved

WEIGHTS = np.ones(1)


class Noisy:
    """One smooth function of (u, x) with noise of a given size: no series becomes finer than it."""

    def __init__(self, noise: float) -> None:
        self.noise = noise

    def grid(self, u: Any, x: Any) -> Any:
        return np.zeros((len(u), len(x), 1))

    def at(self, u: Any, x: Any, q: Any) -> Samples:
        random = np.random.default_rng(len(u))
        value = np.sin(u) * np.cos(x) + self.noise * random.uniform(-1.0, 1.0, len(u))
        none = np.zeros((0, len(u)))
        return Samples(q, value[None], none, none, np.ones(len(u)))


@pytest.mark.parametrize("tolerance", [1e-8, 1e-4, 1e-3])
def test_noise_of_samples_is_accepted_up_to_the_root_of_the_tolerance(tolerance: float) -> None:
    """Where no refinement helps any more, half of the digits that were asked for have to be there.

    A tail sums some fifty coefficients of the noise, each of a tenth of it: between one and ten
    times the noise.
    """
    domain, root = Domain(1.0, -0.1, 1.0), tolerance**0.5
    tables, _ = resolved(Noisy(0.05 * root), domain, WEIGHTS, tolerance)  # type: ignore[arg-type]
    assert tolerance < max(series2d.tails(tables.equation, WEIGHTS)) <= root
    with pytest.raises(ConvergenceError, match="not resolved") as caught:
        resolved(Noisy(2.0 * root), domain, WEIGHTS, tolerance)  # type: ignore[arg-type]
    assert root < caught.value.evidence["residual"] < 40.0 * root


def test_tails_are_the_worst_of_all_functions_and_cells() -> None:
    """The last two orders of each function and cell are added up; the largest sum counts.

    Sums over functions or cells, or without the weights, would be other numbers of this array.
    """
    coefficients = np.zeros((2, 3, 4, 5))
    coefficients[0, 1, 3, 0], coefficients[0, 1, 2, 1] = 2.0, -3.0
    coefficients[0, 2, 3, 2] = 4.0
    coefficients[1, 0, 0, 4], coefficients[1, 0, 1, 3] = -7.0, 1.0
    coefficients[1, 2, 0, 4], coefficients[0, 0, 0, 3] = 6.0, 10.0
    coefficients[1, 1, 0, 0] = 1e3
    by_u, by_x = series2d.tails(coefficients, np.array([1.0, 2.0]))
    assert by_u == 5.0
    assert by_x == 16.0
