"""Figures of the report: one size and look, and the forms in which they are written."""

from __future__ import annotations

import io
import re
from dataclasses import dataclass
from html import escape

from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from ..plain_texts import plain
from ..style import SMALL, WIDTH_IN

# Of the height, for the line that says so.
_FOOT_IN = 0.16


@dataclass(frozen=True)
class Plate:
    """One numbered figure.

    Attributes:
        name: Name of its files.
        title: What it shows, in a few words.
        caption: What is to be seen, with the numbers.
        figure: The picture.
        svg: The figure as an SVG document.
        pdf: The figure as a PDF document.
    """

    name: str
    title: str
    caption: str
    figure: Figure
    svg: str
    pdf: bytes

    @property
    def inline_svg(self) -> str:
        """The figure as an element of a page that holds several of them.

        Identifiers get the figure's name in front, so that no two figures share one.
        """
        text = self.svg[self.svg.index("<svg") :]
        text = re.sub(r"<metadata>.*?</metadata>\s*", "", text, flags=re.DOTALL)
        text = re.sub(r'(\bid="|href="#|url\(#)', rf"\g<1>{self.name}-", text)
        head, tail = text.split(">", 1)
        head = re.sub(r'\s(width|height)="[^"]*"', "", head)
        return f'{head} role="img" aria-label="{escape(self.title)}">{tail}'


def plate(name: str, title: str, caption: str, figure: Figure) -> Plate:
    """Draw a figure, with the same bytes for the same numbers.

    Args:
        name: Name of its files.
        title: What it shows.
        caption: What is to be seen.
        figure: The picture; its layout is fixed by this.
    """
    picture, document = io.StringIO(), io.BytesIO()
    with rc_context({"svg.fonttype": "path", "svg.hashsalt": name, "pdf.fonttype": 42}):
        plain(figure).savefig(picture, format="svg", metadata={"Date": None, "Title": title})
        # The layout of the first drawing holds for the second.
        figure.set_layout_engine("none")
        figure.savefig(document, format="pdf", metadata={"CreationDate": None})
    return Plate(name, title, caption, figure, picture.getvalue(), document.getvalue())


def new_figure(height_in: float, mark: str) -> Figure:
    """Return an empty figure with a line on the kind of its numbers.

    Args:
        height_in: Height [in].
        mark: The line that says so.
    """
    figure = Figure(figsize=(WIDTH_IN, height_in), dpi=150, layout="constrained")
    FigureCanvasAgg(figure)
    return marked(figure, mark)


def marked(figure: Figure, mark: str) -> Figure:
    """Add a line on the kind of its numbers below a figure with a constrained layout.

    Args:
        figure: The figure.
        mark: The line.
    """
    height_in = figure.get_figheight()
    foot = _FOOT_IN / height_in
    figure.get_layout_engine().set(rect=(0.0, foot, 1.0, 1.0 - foot))  # type: ignore[union-attr, call-arg]
    figure.text(0.995, 0.02 / height_in, mark, ha="right", va="bottom", fontsize=6.0, color="0.45")
    return figure


def letter(axes: Axes, text: str) -> None:
    """Mark a panel in its upper left corner, outside."""
    axes.set_title(text, loc="left", fontsize=SMALL, fontweight="bold")


def grid(axes: Axes) -> None:
    """Thin lines behind the curves."""
    axes.grid(visible=True, which="major", color="0.9", linewidth=0.6)
    axes.set_axisbelow(True)
