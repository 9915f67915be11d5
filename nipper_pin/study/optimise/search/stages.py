"""The parts of one search: the screen, descents by an aim, and the global check."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

from ...toml_files import no_machine
from ..points import Evaluator, Point
from ..problem.problem import Aim, Problem
from ..work import Work
from .descend import Descent, descend
from .infeasible import from_feasible_designs
from .samples import SHARE, Found, begins, evolve, look, samples, scales
from .trace import Scales


def screen(problem: Problem, seed: int, work: Work) -> list[Point]:
    """Evaluate samples of the whole box.

    Raises:
        SimulationError: None of them is a machine that can be simulated.
    """
    places, text = samples(problem, seed), problem.text()
    shares = range(0, len(places), SHARE)
    looked = work.all([partial(look, text, places[k : k + SHARE]) for k in shares])
    seen = [item for share in looked for item in share]
    if not any(item.usable for item in seen):
        error = no_machine(f"{len(seen)} samples", Evaluator(problem).at(problem.start).why)
        raise error
    return seen


@dataclass(frozen=True, eq=False)
class Search:
    """Descents and checks from one screen.

    Attributes:
        seen: Its screen.
        starts: Number of descents by each aim.
        seed: Seed of the global check.
        work: Does the parts.
    """

    problem: Problem
    seen: Sequence[Point]
    starts: int
    seed: int
    work: Work

    def scales(self, aim: Aim) -> Scales:
        """Sizes of an aim and of the limits."""
        return scales(self.problem, aim, self.seen)

    def descents(self, aim: Aim, *more: tuple[float, ...]) -> tuple[Descent, ...]:
        """Descents from all starts, the best first; the limits are met by that one at least."""
        problem, by = self.problem.with_aim(aim), self.scales(aim)
        text = problem.text()
        places = (*begins(self.seen, aim, by, self.starts), *more)
        found = self.work.all([partial(descend, text, by, z) for z in places])
        if not any(item.feasible for item in found):
            found += from_feasible_designs(problem, by, found, self.work)
        return tuple(sorted(found, key=lambda item: item.rank))

    def check(self, aim: Aim) -> tuple[Found, Descent | None]:
        """Differential evolution, and the descent from what it found."""
        problem, by = self.problem.with_aim(aim), self.scales(aim)
        text = problem.text()
        found = self.work.one(partial(evolve, text, by, self.seed, self.work.mapper))
        if not found.feasible:
            return found, None
        (polished,) = self.work.all([partial(descend, text, by, found.z)])
        return found, polished
