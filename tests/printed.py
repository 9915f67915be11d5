"""Where the parts of a page come to stand when Chromium prints it: by the link targets of the PDF.

Chromium writes a destination, its page and its height, for each place that a link of the page leads
to. So links to all parts are added behind the last one, where they move nothing.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

from playwright.sync_api import Page

# Parts get names where they have none, and each figure, table row and section a mark at its end.
_MARK = """() => {
  const links = document.createElement('div'), found = [];
  const link = name => {
    const item = document.createElement('a');
    item.href = '#' + name; item.textContent = '.'; links.append(item, ' '); };
  const parts = document.querySelectorAll(
    'main h1, main h2, main h3, main p, main ol, main ul, main li, main nav, main figure,' +
    ' main figcaption, main table, main tr, main section, main footer');
  [...parts].forEach((part, k) => {
    if (!part.id) part.id = 'part-' + k;
    const next = part.nextElementSibling;
    found.push([part.id, part.localName, part.className, next]);
    link(part.id);
    if (['figure', 'tr', 'section'].includes(part.localName)) {
      const end = document.createElement('i');
      end.id = 'end-' + part.id;
      (part.localName === 'tr' ? part.lastElementChild : part).append(end);
      link(end.id); }
  });
  document.querySelector('main').append(links);
  return found.map(([name, kind, kinds, next]) => [name, kind, kinds, next ? next.id : '']);
}"""


@dataclass(frozen=True)
class Part:
    """A part of the page.

    Attributes:
        name: Its identifier.
        kind: Its element.
        classes: Its classes.
        following: Identifier of the element after it; empty for the last one.
    """

    name: str
    kind: str
    classes: str
    following: str


@dataclass(frozen=True)
class Printed:
    """A printed page.

    Attributes:
        parts: Its parts in their order.
        pages: Number of the sheet by the name of a part, and of its end by "end-" before it.
        count: Number of sheets.
        size_mm: Width and height of the sheets [mm].
    """

    parts: tuple[Part, ...]
    pages: dict[str, int]
    count: int
    size_mm: tuple[float, float]


def printed(page: Page) -> Printed:
    """Print a page by its own rules, and read where its parts are."""
    parts = tuple(Part(*row) for row in page.evaluate(_MARK))
    text = page.pdf(prefer_css_page_size=True).decode("latin-1")
    sheets = _sheets(text)
    places = re.findall(r"/([\w-]+) \[(\d+) 0 R /XYZ", text)
    width, height = re.findall(r"/MediaBox \[0 0 ([\d.]+) ([\d.]+)\]", text)[0]
    return Printed(
        parts,
        {name: sheets.index(number) for name, number in places},
        len(sheets),
        (float(width) * 25.4 / 72.0, float(height) * 25.4 / 72.0),
    )


def _sheets(text: str) -> list[str]:
    """Numbers of the objects of all sheets, in the order of the document."""
    objects = dict(re.findall(r"\n(\d+) 0 obj\n(<<.*?)endobj", text, flags=re.DOTALL))
    (root,) = re.findall(r"/Type /Catalog\s*/Pages (\d+) 0 R", text)

    def below(number: str) -> list[str]:
        kids = re.search(r"/Kids \[(.*?)\]", objects[number], flags=re.DOTALL)
        if kids is None:
            return [number]
        return [leaf for kid in re.findall(r"(\d+) 0 R", kids[1]) for leaf in below(kid)]

    return below(root)
