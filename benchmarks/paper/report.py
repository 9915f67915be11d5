"""The published ratios beside ours as one table, for a terminal and as Markdown, and all files."""

from __future__ import annotations

import json
from pathlib import Path

from rich.console import Console

from nipper_pin.hybrid.result.quantities import coordinate_unit
from nipper_pin.mechanism import Mechanism
from nipper_pin.outputs import complete_folder
from nipper_pin.terms import digits, shown_in
from nipper_pin.view.console import say

from ..views.sheet import Sheet
from .ratios import Ratio, agreement, ratio_values
from .study import IDENTIFIED, PaperStudy

_TEXTS = ("paper.json", "ratios.md")


def spring_unit(mechanism: Mechanism, quantity: str) -> tuple[str, float]:
    """Unit in which people read a spring's "stiffness" or "preload", and its factor."""
    turns = coordinate_unit(mechanism, mechanism.springs[0].index) == "rad"
    units = {"stiffness": ("N/m", "N m/rad"), "preload": ("m", "rad")}
    return shown_in(units[quantity][turns])


def ratio_words(study: PaperStudy) -> dict[str, str]:
    """All ratios by name in words: what changes, and between which two cases."""
    unit, factor = spring_unit(study.mechanism, "stiffness")
    speeds, e, rates = (each.values[[0, -1]] for each in study.studies)
    ends = {
        "speed": "{:g} to {:g} r/min".format(*speeds),
        "restitution": "e = {:g} to {:g}".format(*e),
        "stiffness": "{:.3g} to {:.3g} ".format(*(factor * rates)) + unit,
    }
    found = {}
    for name in ratio_values(study.studies):
        over, _, quantity = name.partition(".")
        what, _, last = quantity.rpartition("_")
        share = what == "first_two_share"
        words = "share of the first two rebounds" if share else what.replace("_", " ")
        found[name] = f"{words}, {f'{last} r/min' if share else ends[over]}"
    return found


def sheet(study: PaperStudy) -> Sheet:
    """The table: of a machine that nothing was published of, its ratios alone."""
    words = ratio_words(study)
    if not study.compared:
        rows = tuple((words[key], digits(v)) for key, v in ratio_values(study.studies).items())
        return Sheet("Changes over the three studies, and shares", ("ratio", "ours"), rows)
    return Sheet(
        "Published ratios beside ours",
        ("ratio", "published", "ours", "deviation"),
        tuple(
            (words[item.name], f"{item.published:g}", digits(item.ours), _percent(item))
            for item in study.ratios
        ),
    )


def _percent(item: Ratio) -> str:
    # Negative round-off is written as zero without a sign.
    return f"{round(100.0 * item.relative_deviation, 1) + 0.0:+.1f} %"


def sentences(study: PaperStudy) -> list[str]:
    """What has to be said below the table."""
    models = {study.mechanism.name: study.ratios, IDENTIFIED: study.identified or study.ratios}
    counted = {name: agreement(items).values() for name, items in models.items() if items}
    text = "{}: {} of {} within 4 %, {} within 10 %"
    return [*(text.format(k, n, of, far) for k, (of, n, far) in counted.items()), study.note]


def print_paper(study: PaperStudy, console: Console) -> None:
    """Print table and sentences."""
    sheet(study).show(console)
    for text in sentences(study):
        say(console, text)


def write_paper(study: PaperStudy, folder: str | Path) -> None:
    """Write the document, the table as Markdown and every figure as SVG.

    Raises:
        InputError: The folder cannot be written.
    """
    from nipper_pin.view.figure_file import save_figure

    from .figures import NAMES, figures

    with complete_folder(folder, (*_TEXTS, *(f"{name}.svg" for name in NAMES))) as new:
        document = json.dumps(study.record(), indent=1, allow_nan=False) + "\n"
        table = "\n\n".join([sheet(study).markdown(), *sentences(study)]) + "\n"
        for name, text in zip(_TEXTS, (document, table), strict=True):
            (new / name).write_text(text, encoding="utf-8")
        for name, figure in figures(study).items():
            save_figure(figure, new / f"{name}.svg", "svg")
