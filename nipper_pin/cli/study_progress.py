"""How far a study is: two chains of work side by side, and when both will be done."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field

# Stages in their order and their processor time, measured for the E62 on one core [s].
STAGES: Mapping[str, float] = {
    "three studies": 1.8,
    "held and inertial shafts": 1.2,
    "phases 1 and 2": 0.9,
    "fixed steps as published": 2.0,
    "maps": 0.7,
}
REPORT: Mapping[str, float] = {"turns at many speeds": 2.5, "groups of figures": 9.5, "report": 1.5}
SENSITIVITIES = "sensitivities"
# Processor time of all sensitivities, for the length of the bar alone [s].
_SENSITIVITIES_S = 30.0
# Less than this part of a chain is no measure of the whole.
_ENOUGH = 0.15
# Columns of a terminal on which both chains are told of.
_WIDE = 110


@dataclass
class Work:
    """Two chains of work: stages one after the other, and sensitivities beside them.

    Attributes:
        stages: Stages and their processor times.
        beside: Whether there are sensitivities.
        clock: Gives the time [s].
    """

    stages: Mapping[str, float]
    beside: bool
    clock: Callable[[], float] = time.monotonic
    began: float = field(init=False)
    stage: str = field(default="", init=False)
    counts: dict[str, tuple[int, int]] = field(default_factory=dict, init=False)
    # Time at which a chain was last seen, and the part of it that was done.
    _seen: dict[str, tuple[float, float]] = field(default_factory=dict, init=False)

    def __post_init__(self) -> None:
        """Start the clock."""
        self.began = self.clock()

    def begin(self, stage: str) -> None:
        """Begin a stage: all that stand before it are done.

        Args:
            stage: Its name; one that is not known changes nothing but the text.
        """
        self.stage = stage
        if stage in self.stages:
            self._note("stages", self._stages_done())

    def part(self, name: str, done: int, total: int) -> None:
        """Some of a stage, or of the sensitivities, is done.

        Args:
            name: Its name.
            done: How many.
            total: Of how many.
        """
        self.counts[name] = (done, total)
        if name == SENSITIVITIES:
            self._note(SENSITIVITIES, done / total)
        elif self.stage in self.stages:
            self._note("stages", self._stages_done())

    @property
    def share(self) -> float:
        """Part of all work that is done."""
        here = self._seen.get("stages", (0.0, 0.0))[1]
        if not self.beside:
            return here
        there = self._seen.get(SENSITIVITIES, (0.0, 0.0))[1]
        total = sum(self.stages.values())
        return (here * total + there * _SENSITIVITIES_S) / (total + _SENSITIVITIES_S)

    def text(self, *, both: bool) -> str:
        """What is being done, and how much of what is counted.

        Args:
            both: Whether there is room for the sensitivities beside the stage.
        """
        parts = [self.stage]
        if self.stage in self.counts:
            parts[0] += " {} of {}".format(*self.counts[self.stage])
        if both and self.beside and SENSITIVITIES in self.counts:
            parts.append("{} {} of {}".format(SENSITIVITIES, *self.counts[SENSITIVITIES]))
        return ", ".join(part for part in parts if part)

    def left(self) -> float | None:
        """Time until both chains are done [s]; None while too little is done to tell."""
        chains = ["stages", *([SENSITIVITIES] if self.beside else [])]
        ends = []
        for chain in chains:
            seen, part = self._seen.get(chain, (0.0, 0.0))
            if part < _ENOUGH:
                return None
            ends.append(self.began + (seen - self.began) / part)
        return max(0.0, max(ends) - self.clock())

    def _note(self, chain: str, part: float) -> None:
        self._seen[chain] = (self.clock(), part)

    def _stages_done(self) -> float:
        names = list(self.stages)
        before = sum(self.stages[name] for name in names[: names.index(self.stage)])
        done, total = self.counts.get(self.stage, (0, 1))
        return (before + self.stages[self.stage] * done / total) / sum(self.stages.values())


@contextmanager
def shown(work: Work) -> Iterator[Callable[[], None]]:
    """Show work on a terminal, and nothing elsewhere.

    Args:
        work: The work.

    Yields:
        What has to be called after each change.
    """
    if not sys.stderr.isatty():
        yield lambda: None
        return
    from rich.progress import BarColumn, Progress, ProgressColumn, Task, TextColumn
    from rich.progress import TimeElapsedColumn as Gone
    from rich.text import Text

    from ..view.console import Terminal

    class Left(ProgressColumn):
        """Time left, asked anew whenever the bar is drawn."""

        def render(self, task: Task) -> Text:
            """Text of the column; empty while there is no estimate."""
            left = None if task.finished else work.left()
            return Text("" if left is None else f"about {left:.0f} s left")

    console = Terminal(stderr=True)
    # The longest line on a terminal of 60 columns, and room for the second chain on wide ones.
    bar = Progress(
        TextColumn("{task.description}", markup=False),
        BarColumn(bar_width=min(20, max(4, console.width - 56))),
        Gone(),
        TextColumn("gone"),
        Left(),
        console=console,
        transient=True,
    )
    with bar:
        task = bar.add_task("", total=1.0)
        yield lambda: bar.update(
            task, completed=work.share, description=work.text(both=console.width >= _WIDE)
        )
