"""Charts of a turn, combined for a case and evaluated, compiled."""

from __future__ import annotations

from ...arrays import FloatArray
from . import layout as rows
from .arrival_check import prepare
from .compiled import part
from .layout import Tables, Work
from .panel import cell_at
from .turn_layout import Charts, TurnWork


@part
def tables_of(charts: Charts, c: int) -> Tables:
    """One chart as a reduced model."""
    return Tables(
        charts.equation[c], charts.gaps[c], charts.inertia[c], charts.residual[c],
        charts.largest[c], charts.steepest_x[c], charts.steepest_u[c], charts.travel[c],
        charts.low[c], charts.high[c], charts.inertia_residual[c], 0.0, 0.0, 0.0, 1.0, 1.0,
    )  # fmt: skip


@part
def visit(charts: Charts, work: TurnWork, c: int, speed: float, gravity: float,
          stiffness: FloatArray, preload: FloatArray) -> None:  # fmt: skip
    """Combine a chart for the case when it is first visited."""
    if work.ready[c]:
        return
    mixed = work.mixed[c]
    one = Work(work.case[c], mixed, work.poly, work.nodes, work.series, work.sizes[c], work.line[c])
    prepare(tables_of(charts, c), one, speed, gravity, stiffness, preload)
    work.case[c, rows.SPAN], work.case[c, rows.TRACED] = charts.span[c], 1.0
    cells, count_u, count_x = charts.equation.shape[2:]
    zero = work.case[c, rows.SCALE] * -charts.low[c] - 1.0
    for cell in range(cells):
        for i in range(count_u):
            older, old = 1.0, zero
            value = mixed[cell, i, 0] + zero * mixed[cell, i, 1]
            for m in range(2, count_x):
                older, old = old, 2.0 * zero * old - older
                value += old * mixed[cell, i, m]
            work.line[c, cell, i] = value
    work.ready[c] = True


@part
def surface(table: FloatArray, row: int, span: float, case: FloatArray, u: float,
            x: float) -> float:  # fmt: skip
    """Value of one function of (u, x), shape of ``table`` (functions, cells, Nu, Nx)."""
    _, cells, count_u, count_x = table.shape
    cell, place_u = cell_at(span, cells, u)
    place_x = case[rows.SCALE] * (x - case[rows.LOW]) - 1.0
    total = 0.0
    older, old = 0.0, 1.0
    for i in range(count_u):
        high = low = 0.0
        for m in range(count_x - 1, 0, -1):
            high, low = table[row, cell, i, m] + 2.0 * place_x * high - low, high
        total += old * (table[row, cell, i, 0] + place_x * high - low)
        older, old = old, (place_u if i == 0 else 2.0 * place_u * old - older)
    return total


@part
def off_rows(charts: Charts, c: int, begin: float, end: float, gaps: tuple[float, float],
             top: float, steepest: float) -> bool:  # fmt: skip
    """Whether a spring may leave the rows of its table between two travels.

    Args:
        c: The chart.
        begin: Travel [rad].
        end: Later travel [rad].
        gaps: Gaps at both.
        top: Largest gap between them.
        steepest: Largest derivative of the gap by the travel.
    """
    parts = charts.on_rows.shape[1]
    if parts == 0:
        return False
    width = charts.span[c] / parts
    last = min(int(end / width), parts - 1)
    for row in range(min(int(begin / width), last), last + 1):
        before, after = (row + 1) * width - begin, end - row * width
        if charts.on_rows[c, row] < min(
            top, gaps[0] + steepest * before, gaps[1] + steepest * after
        ):
            return True
    return False


@part
def off_rows_at(charts: Charts, c: int, x: float) -> bool:
    """Whether a spring is off the rows of its table at a gap, at any travel."""
    for row in range(charts.on_rows.shape[1]):
        if charts.on_rows[c, row] >= x:
            return False
    return bool(charts.on_rows.shape[1] > 0)


@part
def seen_by(charts: Charts, work: TurnWork, c: int, s: int, speed: float, u: float, x: float,
             v: float, dx: float, dw: float) -> tuple[float, float, float, float]:  # fmt: skip
    """Gap and rate of another stop, and bounds on their errors, from x and x' of a chart."""
    others = charts.others.shape[1]
    case, span = work.case[c], charts.span[c]
    gap = surface(charts.gaps[c], s, span, case, u, x)
    by_x = surface(charts.slopes[c], s, span, case, u, x)
    by_u = surface(charts.slopes[c], others + s, span, case, u, x)
    wrong_x, wrong_u = charts.slope_residual[c, s], charts.slope_residual[c, others + s]
    # The slopes change by less than themselves over the whole domain.
    bent = dx / (charts.high[c] - charts.low[c])
    d_gap = abs(by_x) * dx + charts.gap_residual[c, s]
    d_rate = (
        abs(by_x) * dw
        + abs(v) * (wrong_x + abs(by_x) * bent)
        + speed * (wrong_u + abs(by_u) * bent)
    )
    return gap, by_x * v + by_u * speed, d_gap, d_rate


@part
def other_of(charts: Charts, c: int, stop: int) -> int:
    """Place of a stop among the others of a chart."""
    for s in range(charts.others.shape[1]):
        if charts.others[c, s] == stop:
            return s
    return -1


@part
def chart_at(charts: Charts, stop: int, travel: float) -> int:
    """The chart of a stop that holds a travel from the start of the turn, or -1."""
    for c in range(len(charts.stop)):
        past = travel - charts.begin[c]
        if charts.stop[c] == stop and 0.0 <= past <= charts.travel[c]:
            return c
    return -1
