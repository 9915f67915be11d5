"""The findings about a model as tables and sentences for a terminal."""

from __future__ import annotations

from collections.abc import Sequence

from rich.console import Console

from ...hybrid.result.quantities import force_unit
from ...mechanism import Mechanism, Stop
from ...study.check import ModelReport
from ...study.next_steps import NextSteps
from ...terms import counted, fixed
from ...units import MM_PER_M
from ..console import headline, paste, say, show_table
from ..reading import element_lines, law_text, stop_place


def print_report(
    report: ModelReport, steps: NextSteps, console: Console, *, provenance: bool = False
) -> None:
    """Print what is wrong with a model, what it is, and what was found about it.

    Args:
        steps: What is missing, and commands to run next.
        provenance: Print where each number comes from, too.
    """
    mechanism = report.mechanism
    say(console, mechanism.title or mechanism.name, style="bold")
    _wrong(steps.missing, console)
    _advice(report, console)
    headline(console, "Mechanism")
    say(
        console,
        f"{counted(len(mechanism.joints), 'moving link')}, "
        f"{counted(len(mechanism.joints), 'tree joint')}, "
        f"{counted(len(mechanism.closures), 'cut joint')}, "
        f"mobility {mechanism.degrees_of_freedom}, "
        f"{len(mechanism.drives)} of it driven",
    )
    if mechanism.side_view:
        say(console, f"axes: {mechanism.side_view}")
    if mechanism.closing:
        say(console, f"gaps: {mechanism.closing}")
    if mechanism.curves:
        say(console, f"curves: {mechanism.curves}")
    _joints(report, console)
    _stops(report, console)
    if law := law_text(mechanism):
        say(console, law)
    headline(console, "Cycle")
    say(console, f"at {report.speed_rpm:g} r/min: {_timing(report)}")
    for stop, index in report.releases:
        say(console, f"stop {stop} lets go at index {index:.3f}: its force falls to zero there")
    say(
        console,
        f"condition of the closures: at most {report.condition.value:.3g}, at index "
        f"{report.condition.index:.2f}; of the impact matrix {report.impact_condition.value:.3g}, "
        f"at index {report.impact_condition.index:.2f}",
    )
    _clearances(report, console)
    _provenance(report, console, whole=provenance)
    headline(console, "Next")
    for command in steps.commands:
        paste(console, command)


def _wrong(missing: Sequence[str], console: Console) -> None:
    if not missing:
        say(console, "Nothing is missing: the model can be simulated.")
        return
    headline(console, "To do")
    for text in missing:
        say(console, text)


def _advice(report: ModelReport, console: Console) -> None:
    if report.urdf.sentences:
        headline(console, "To look at")
    for text in report.urdf.sentences:
        say(console, f"{text[:1].upper()}{text[1:]}")
    for line in report.urdf.stops.splitlines():
        paste(console, line)


def _provenance(report: ModelReport, console: Console, *, whole: bool) -> None:
    sources = report.mechanism.provenance
    if not whole:
        count = len(sources)
        if count:
            say(console, f"Where {count} of its numbers come from: --provenance.")
        return
    headline(console, "Provenance")
    for path, text in sources.items():
        say(console, f"{path}: {text}")


def _joints(report: ModelReport, console: Console) -> None:
    mechanism = report.mechanism
    names = {joint.index: joint.name for joint in mechanism.joints}
    moved = {
        item.index: f"{item.multiplier:g} times {names[item.of]}" for item in mechanism.couplings
    } | {drive.index: f"drive {drive.name}" for drive in mechanism.drives}
    rows: list[tuple[str, ...]] = [
        (joint.name, joint.kind, joint.parent, joint.child, moved.get(joint.index, ""))
        for joint in mechanism.joints
    ]
    for closure in mechanism.closures:
        kind, first = "cut pin", closure.frame_a
        if closure.slot_frame is not None:
            kind, first = "pin in a slot", f"{closure.slot_frame} along {closure.slot_axis}"
        rows.append((closure.name, kind, first, closure.frame_b, ""))
    headings = ("joint", "kind", "parent", "child", "moved by")
    show_table(console, headings, rows, text=range(5))
    total = sum(item.mass_kg for item in report.masses)
    masses = ", ".join(f"{item.link} {item.mass_kg:.4g}" for item in report.masses)
    say(console, f"masses in kg: {masses}; together {total:.4g}")
    for line in element_lines(mechanism):
        say(console, line)


def _stops(report: ModelReport, console: Console) -> None:
    for stop in report.mechanism.stops:
        contact = stop.contact
        where = stop_place(report.mechanism, stop)
        if contact is not None:
            (x, _, z), (along, _, up) = MM_PER_M * contact.point, contact.normal
            where += (
                f", meeting at ({fixed(x, 2)}, {fixed(z, 2)}) mm, normal ({fixed(along, 3)}, "
                f"{fixed(up, 3)}), lever {_lever(report.mechanism, stop)}"
            )
        if stop.leader:
            where += f", closing together with {stop.leader}"
        say(
            console,
            f"stop {stop.name}: restitution {stop.restitution:g}, {where}; smallest force while "
            f"closed {_force(report, stop)}",
        )


def _lever(mechanism: Mechanism, stop: Stop) -> str:
    """Of a hinge a length; a slide parts its lips by so much of its own travel."""
    if mechanism.joints[stop.index].kind == "prismatic":
        return f"{stop.lever:.4g} of the travel"
    return f"{MM_PER_M * stop.lever:.2f} mm"


def _force(report: ModelReport, stop: Stop) -> str:
    force = report.stop_force.get(stop.name)
    if force is None and stop.name in report.struck:
        return "not seen: it bounces and does not come to rest"
    if force is None:
        return "not seen: it is never closed"
    return f"{force.value:.1f} {force_unit(report.mechanism, stop)} at index {force.index:.2f}"


def _timing(report: ModelReport) -> str:
    name = report.mechanism.transition_stop
    if report.closing_index is None:
        return f"stop {name} does not close. {report.outcome}" if name else report.outcome
    if name not in report.stop_force:
        return (
            f"stop {name} is struck first at index {report.closing_index:.3f} and does not come to "
            "rest"
        )
    opening = (
        "does not open again"
        if report.opening_index is None
        else f"opens at index {report.opening_index:.3f}"
    )
    return f"stop {name} closes at index {report.closing_index:.3f} and {opening}"


def _clearances(report: ModelReport, console: Console) -> None:
    headline(console, "Clearances below 20 mm")
    for item in report.clearances:
        verdict = "INTERFERENCE" if item.interferes else "meet" if item.may_touch else "clear"
        say(
            console,
            f"{verdict}: {item.link_a} ({item.shape_a}) and {item.link_b} ({item.shape_b}), "
            f"{MM_PER_M * item.distance_m:.3f} mm at index {item.index:.2f}",
        )
    if not report.clearances:
        say(console, "none: no two links that should not touch come so near")
