"""The site of docs/ as a reader opens it: links, Python reference, nothing from elsewhere."""

import posixpath
import re
import subprocess
import sys
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote

import pytest

ROOT = Path(__file__).parents[1]
LOADING = {"script": "src", "img": "src", "iframe": "src", "link": "href"}

pytestmark = pytest.mark.slow


class Page(HTMLParser):
    """Identifiers, links and what is loaded of one page."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.ids: set[str] = set()
        self.links: list[str] = []
        self.loaded: list[str] = []
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        found = {key: value for key, value in attrs if value}
        self.ids.update(found[key] for key in ("id", "name") if key in found)
        if tag == "a" and "href" in found:
            self.links.append(found["href"])
        if found.get("rel") not in ("prev", "next", "canonical"):
            self.loaded += [found[LOADING[tag]]] if found.get(LOADING.get(tag, "")) else []


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    pytest.importorskip("mkdocs")
    pytest.importorskip("mkdocstrings")
    folder = tmp_path_factory.mktemp("site")
    command = [sys.executable, "-m", "mkdocs", "build", "--strict", "--site-dir", str(folder)]
    subprocess.run(command, cwd=ROOT, check=True, capture_output=True)
    return folder


@pytest.fixture(scope="module")
def pages(site: Path) -> dict[str, Page]:
    # The page of what is not found is shown below any address, so its paths are absolute.
    return {
        file.relative_to(site).as_posix(): Page(file.read_text(encoding="utf-8"))
        for file in site.rglob("*.html")
        if file.name != "404.html"
    }


def test_links_lead_to_pages_and_headings(site: Path, pages: dict[str, Page]) -> None:
    missing = []
    for name, page in pages.items():
        for link in page.links:
            if re.match(r"[a-z]+:", link):
                continue
            path, _, heading = unquote(link).partition("#")
            target = posixpath.normpath(posixpath.join(posixpath.dirname(name), path or name))
            target = "index.html" if target == "." else target
            there = (site / target).exists()
            if target in pages and heading:
                there = heading in pages[target].ids
            if not there:
                missing.append((name, link))
    assert len(pages) == len(list((ROOT / "docs").rglob("*.md")))
    assert missing == []


def test_nothing_is_loaded_from_elsewhere(site: Path, pages: dict[str, Page]) -> None:
    for name, page in pages.items():
        assert page.loaded, name
        for file in page.loaded:
            assert not re.match(r"(?:https?:)?//", file), (name, file)
            place = (site / name).parent / file.partition("?")[0]
            assert file.startswith("data:") or place.exists(), (name, file)
    for sheet in site.rglob("*.css"):
        style = sheet.read_text(encoding="utf-8")
        assert not re.search(r"url\([\"']?(?:https?:)?//|@import", style), sheet
