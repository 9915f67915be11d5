"""The table of an inertial run tells between which speeds its shafts turn."""

from __future__ import annotations

import io

import numpy as np
import pytest
from rich.console import Console

from nipper_pin import Case, Mechanism, Solution, simulate
from nipper_pin.view.run.sampling import shaft_rates
from nipper_pin.view.run.table import print_solution


def _printed(solution: Solution) -> list[str]:
    text = io.StringIO()
    print_solution(solution, Console(file=text, width=120))
    return text.getvalue().splitlines()


@pytest.mark.parametrize("window", ["transition", "cycle"])
def test_it_tells_the_range_of_every_shaft(e62: Mechanism, window: str) -> None:
    """Rates on both sides of every event of the window lie within, and one may be its end."""
    solution = simulate(e62, Case(speed_rpm=450.0, window=window, drive="inertial"))
    lines = _printed(solution)
    start = next(i for i, line in enumerate(lines) if "Speeds of the driven joints" in line)
    rows = {line.split()[0]: line.split() for line in lines[start:] if "rad/s" in line}
    assert set(rows) == {"pendulum", "tension"}
    for drive in e62.drives:
        lowest, highest = shaft_rates(solution)[drive.name]
        assert rows[drive.name][2:4] == [f"{lowest:.6g}", f"{highest:.6g}"]
        rates = [v[drive.index] for event in solution.events[:-1]
                 for v in (event.v_before, event.v_after)]  # fmt: skip
        # The collision that a transition starts with has no motion before it.
        rates = rates[window == "transition" :]
        assert lowest - 1e-12 <= min(rates) <= max(rates) <= highest + 1e-12
        t = np.linspace(*solution.trajectory.span, 5000)
        held = drive.law.evaluate(solution.shaft.angle(t))[1] * solution.shaft.rate
        told = [float(word) for word in rows[drive.name][4:6]]
        assert told == pytest.approx([held.min(), held.max()], rel=1e-4)


def test_held_drives_have_no_such_table(e62: Mechanism) -> None:
    assert not any(
        "driven joints" in line for line in _printed(simulate(e62, Case(speed_rpm=450.0)))
    )
