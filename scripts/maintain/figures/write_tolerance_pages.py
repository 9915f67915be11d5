"""Write the pages of tolerances from the modules of nipper_pin/tolerances.

Run: python scripts/maintain/figures/write_tolerance_pages.py [DOCS]
"""

from __future__ import annotations

import ast
import re
import sys
from dataclasses import dataclass
from pathlib import Path

import nipper_pin.tolerances

_FOLDER = Path(nipper_pin.tolerances.__file__).parent
_HEADING = re.compile(r"^# (.+)$", re.MULTILINE)
# Where the first sentence ends.
_END = re.compile(r"\. (?=[A-Z`])")
# Sections of the direct engine fill two pages.
_ERRORS = ("Stated errors", "Results: the premise, periodic turns and energy")
_PAGES = {
    "tolerances": ("Tolerances: models and dynamics", "mechanics"),
    "tolerances_motion": ("Tolerances: panels and events", "hybrid"),
    "tolerances_errors": ("Tolerances: stated errors and results", "hybrid"),
    "tolerances_reduced": ("Tolerances: reduced engine", "reduced"),
    "tolerances_study": ("Tolerances: studies", "study"),
}
_FIRST = """Small numbers decide whether something counts as zero, equal, converged or accurate
enough. The tolerance of a run is set in its case ([stated errors](accuracy.md)).
Each stands in `nipper_pin/tolerances/` with its unit (1 for a ratio), what it decides and where it
comes from: a derivation, a measurement, or a choice. eps is the spacing of
doubles above one. The unit of a coordinate is a radian or, of a slide, the reach of the machine as
a power of two.

Other pages: {others}."""
_NEXT = "How to read the table: [tolerances of models and dynamics](tolerances.md)."
_HEAD = """| name | value | unit | what it decides | where it comes from |
| --- | --- | --- | --- | --- |"""


@dataclass(frozen=True, kw_only=True)
class Tolerance:
    """A constant with its text.

    Attributes:
        section: Heading of the module that it stands below, or an empty text.
        name: Its name.
        value: Its value as it is written, eps for the spacing of doubles.
        unit: Its unit.
        decides: What it decides, one sentence.
        derivation: Where it comes from; empty if the text has one sentence only.
    """

    section: str
    name: str
    value: str
    unit: str
    decides: str
    derivation: str


def main(docs: str = "docs") -> None:
    """Write the pages.

    Args:
        docs: Folder of the pages.
    """
    written = pages()
    for name, text in written.items():
        (Path(docs) / f"{name}.md").write_text(text, encoding="utf-8")
    print(f"wrote {', '.join(written)} to {docs}")


def pages() -> dict[str, str]:
    """Return the text of each page, by its name."""
    found = {}
    for name, (title, module) in _PAGES.items():
        rows = tolerances((_FOLDER / f"{module}.py").read_text(encoding="utf-8"))
        if module == "hybrid":
            later = name == "tolerances_errors"
            rows = [row for row in rows if (row.section in _ERRORS) == later]
        lead = _NEXT
        if name == "tolerances":
            others = [f"[{text.partition(': ')[2]}]({key}.md)" for key, (text, _) in _PAGES.items()]
            lead = _FIRST.format(others=", ".join(others[1:]))
        found[name] = "\n\n".join([f"# {title}", lead, *_tables(rows)]) + "\n"
    return found


def tolerances(source: str) -> list[Tolerance]:
    """Read the constants of a module.

    Args:
        source: Its source; the text of a constant follows it.
    """
    headings = {source.count("\n", 0, hit.start()) + 1: hit[1] for hit in _HEADING.finditer(source)}
    body, found = ast.parse(source).body, []
    for place, node in enumerate(body):
        if not isinstance(node, ast.Assign):
            continue
        text = ast.literal_eval(ast.unparse(body[place + 1])).replace("``", "`")
        unit, _, sentences = " ".join(text.split()).removeprefix("[").partition("] ")
        decides, *derivation = _END.split(sentences, maxsplit=1)
        above = [line for line in headings if line < node.lineno]
        found.append(
            Tolerance(
                section=headings[max(above)] if above else "",
                name=ast.unparse(node.targets[0]),
                value=_written(ast.unparse(node.value)),
                unit=unit,
                decides=decides.rstrip("."),
                derivation="".join(derivation),
            )
        )
    return found


def _written(value: str) -> str:
    """Value of a constant as a reader writes it."""
    if "epsilon" in value:
        return f"{sys.float_info.epsilon:.3g}"
    return re.sub(r"\.0(?!\d)", "", value).replace(" * EPS", " eps").replace("e-0", "e-")


def _tables(rows: list[Tolerance]) -> list[str]:
    """Return a table for each section, below its heading."""
    parts, last = [], None
    for row in rows:
        if row.section != last:
            parts += [*([f"## {row.section}"] if row.section else []), _HEAD]
            last = row.section
        decides = row.decides[0].upper() + row.decides[1:]
        cells = (f"`{row.name}`", row.value, row.unit, decides, row.derivation)
        parts[-1] += f"\n| {' | '.join(cells)} |"
    return parts


if __name__ == "__main__":
    main(*sys.argv[1:])
