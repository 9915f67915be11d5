"""The labelled drawing of the machine as a figure of the report."""

from __future__ import annotations

from ...study.paper import PaperStudy
from ..sketch.draw import drawn
from ..sketch.places import sketch
from .canvas import Plate, marked, plate
from .terms import terms


def machine_plate(study: PaperStudy) -> Plate:
    """Draw the machine in its touch configuration.

    Args:
        study: The study.
    """
    shown = sketch(study.mechanism)
    figure = drawn(shown)
    # What these say stands in the caption.
    figure.axes[0].set_title("")
    figure.supxlabel("")
    return plate(
        "mechanism",
        "The machine as the model describes it",
        f"Side view with the {study.mechanism.transition_stop} just touching: "
        f"{len(shown.links)} links, {len(shown.nodes)} joints and {len(shown.stops)} stops. "
        "Circle: pin; dashed circle: pin that closes a loop; box: slide; hatched: joint with the "
        "frame; blue: driven; red: spring; orange: stop, the arrow shows how it opens.",
        marked(figure, terms(study).mark),
    )
