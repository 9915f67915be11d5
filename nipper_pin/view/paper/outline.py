"""Sections of the report in their order, with numbers, for headings, links and contents."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

from ...study.paper import PaperStudy
from .supplements import Supplements


@dataclass(frozen=True)
class Section:
    """A section, or a part of one.

    Attributes:
        name: In links.
        number: As in "5.2".
        title: What it is about.
        parts: Its parts.
    """

    name: str
    number: str
    title: str
    parts: tuple[Section, ...] = field(default=())


def outline(study: PaperStudy, supplements: Supplements) -> tuple[Section, ...]:
    """The numbered sections of a report.

    Args:
        study: The study.
        supplements: Results of other studies; without them their sections are left out.
    """
    titles = [
        ("machine", "The machine"),
        ("conditions", "Conditions"),
        *([("agreement", "Agreement")] if study.compared else []),
        ("studies", "The three studies"),
        ("kinematics", "Kinematics of phases 1 and 2"),
        ("questions", "What the study leaves open" if study.compared
         else "What stands behind these numbers"),
        *([] if supplements.sensitivities is None else [("changes", "Sensitivities")]),
        *([] if supplements.identification is None else [("fit", "Identification")]),
        ("method", "Method"),
        ("accuracy", "Accuracy and limits"),
    ]  # fmt: skip
    found = []
    for number, (name, title) in enumerate(titles, start=1):
        parts = _questions(study, number) if name == "questions" else ()
        found.append(Section(name, str(number), title, tuple(parts)))
    return tuple(found)


def by_name(sections: tuple[Section, ...]) -> Mapping[str, Section]:
    """Sections and their parts by their names."""
    return {item.name: item for section in sections for item in (section, *section.parts)}


def _questions(study: PaperStudy, section: int) -> Iterator[Section]:
    titles = [
        ("counts", "Number of collisions, and when the jaw is at rest"),
        ("shafts", "Held shafts, or shafts that jump"),
        ("stop", f"Does the {study.phase_one.stop} stay on its stop in phase 1?"),
        *([] if study.fixed_step is None else [("steps", "Error of a fixed step")]),
        ("share", "Why the first two rebounds take 1 - e² of the time"),
        ("map", "Reading the map"),
    ]
    for number, (name, title) in enumerate(titles, start=1):
        yield Section(name, f"{section}.{number}", title)
