"""Pages of docs/: their length, what they link to, and their place in the site."""

import re
from pathlib import Path

import pytest
import yaml

ROOT = Path(__file__).parents[1]
DOCS = ROOT / "docs"
PAGES = sorted(DOCS.rglob("*.md"))
MOST = 1200
LINK = re.compile(r"\]\(([^)\s]+)\)")
LOADED = re.compile(r"<(?:script|link|img|iframe)[^>]+(?:src|href)=.?https?:", re.IGNORECASE)


def in_navigation(entry: object) -> list[str]:
    """Files below an entry of the navigation."""
    if isinstance(entry, str):
        return [entry]
    below = entry.values() if isinstance(entry, dict) else entry
    return [file for part in below for file in in_navigation(part)]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(DOCS)))
def test_page_is_short(page):
    words = sum(any(map(str.isalnum, each)) for each in page.read_text(encoding="utf-8").split())
    assert words <= MOST


def test_links_lead_to_files():
    targets = [
        (page, link.partition("#")[0])
        for page in [*PAGES, ROOT / "README.md", ROOT / "CHANGELOG.md"]
        for link in LINK.findall(page.read_text(encoding="utf-8"))
        if "://" not in link and not link.startswith("#")
    ]
    assert len(targets) > 50
    missing = [(page.name, path) for page, path in targets if not (page.parent / path).exists()]
    assert missing == []


def test_every_page_is_in_the_navigation_once():
    site = yaml.safe_load((ROOT / "mkdocs.yml").read_text(encoding="utf-8"))
    pages = [str(page.relative_to(DOCS)) for page in PAGES]
    assert sorted(in_navigation(site["nav"])) == pages
    assert site["strict"] is True
    assert site["theme"]["font"] is False


def test_pages_load_nothing_from_the_network():
    """Whoever reads the site, or builds it, may be offline."""
    for page in PAGES:
        text = page.read_text(encoding="utf-8")
        assert not LOADED.search(text), page
        assert not re.search(r"!\[[^\]]*\]\(https?:", text), page
        assert "```mermaid" not in text, page
