"""How fast a machine can run, as a figure: what is drawn, in which units, and the answer above."""

from __future__ import annotations

import numpy as np
import pytest
from matplotlib.collections import PolyCollection

from nipper_pin.study.speed_limit import SpeedLimit, SpeedRange, Verdict
from nipper_pin.view.studies.speed_limit_plot import speed_limit_figure


def up_to(limit: float | None) -> tuple[SpeedRange, ...]:
    if limit is None:
        return (SpeedRange(300.0, 900.0, Verdict.YES),)
    return SpeedRange(300.0, limit, Verdict.YES), SpeedRange(limit, 900.0, Verdict.NO)


def made_up(settles: float | None, repeats: float | None) -> SpeedLimit:
    """Three speeds; at the last one two turns differ, and the jaw is not at rest."""
    nan = float("nan")
    return SpeedLimit(
        model="m", title="a machine", stop="jaw", speed_rpm=np.array([300.0, 600.0, 900.0]),
        status=("followed",) * 3, turns=np.array([2, 2, 400]), repeats_after=np.array([1, 1, 2]),
        closing=np.array([34.0, 35.0, 36.0]), rest=np.array([36.0, 39.0, nan]),
        opening=np.array([47.0, 47.5, nan]), clamped_share=np.array([0.275, 0.2125, 0.0]),
        margin=np.array([11.0, 8.5, nan]),
        rests=np.array([[36.0, nan], [39.0, nan], [nan, nan]]),
        touches=np.array([[34.0, nan], [35.0, nan], [36.0, 36.5]]),
        settled=up_to(settles), single=up_to(repeats),
    )  # fmt: skip


def test_lines_of_a_speed_limit() -> None:
    figure = speed_limit_figure(made_up(544.7, 651.9))
    assert figure.get_suptitle().endswith("from 300 to 544.7 r/min")
    assert figure.get_supxlabel().splitlines()[0] == "a machine"
    above, below = figure.axes
    lines = {str(line.get_label()): line for line in above.lines}
    np.testing.assert_array_equal(lines["jaw opens"].get_ydata(), [47.0, 47.5, np.nan])
    np.testing.assert_array_equal(lines["jaw opens"].get_xdata(), [300.0, 600.0, 900.0])
    touches = lines["jaw touches first"]
    np.testing.assert_array_equal(touches.get_xdata(), [300, 300, 600, 600, 900, 900])
    np.testing.assert_array_equal(touches.get_ydata(), [34, np.nan, 35, np.nan, 36, 36.5])
    np.testing.assert_array_equal(
        lines["jaw comes to rest"].get_ydata(), [36, np.nan, 39, np.nan, np.nan, np.nan]
    )
    (held,) = [item for item in above.collections if isinstance(item, PolyCollection)]
    corners = {tuple(corner) for corner in held.get_paths()[0].vertices}
    assert corners == {(300.0, 36.0), (300.0, 47.0), (600.0, 39.0), (600.0, 47.5)}
    # A share is read in per cent, and an index begins again at 40.
    np.testing.assert_allclose(below.lines[0].get_ydata(), [27.5, 21.25, 0.0], rtol=1e-12)
    assert below.get_ylabel().split() == ["clamped", "[%", "of", "a", "turn]"]
    assert below.get_xlabel() == "cylinder speed [r/min]"
    assert above.yaxis.get_major_formatter()(42.0, 0) == "2"
    limits = [line.get_xdata()[0] for line in below.lines[1:]]
    assert limits == [544.7, 651.9]
    assert [text.get_text() for text in above.texts] == [
        "from 545 r/min: not at rest before it opens",
        "from 652 r/min: turns differ from one another",
    ]


@pytest.mark.parametrize("repeats", [None, 800.0])
def test_a_machine_that_settles_at_every_speed(repeats: float | None) -> None:
    figure = speed_limit_figure(made_up(None, repeats))
    assert figure.get_suptitle().endswith("at every speed")
    assert len(figure.axes[0].texts) == (repeats is not None)
