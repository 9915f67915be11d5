"""Pages of docs/: their length, what they link to, and their place in the site."""

import inspect
import re
import shlex
import subprocess
from importlib import import_module
from pathlib import Path

import pytest
import yaml

import nipper_pin as nip
from nipper_pin.cli import _parser

ROOT = Path(__file__).parents[1]
DOCS = ROOT / "docs"
PAGES = sorted(DOCS.rglob("*.md"))
MOST = 1300
LINK = re.compile(r"\]\(([^)\s]+)\)")


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


@pytest.mark.parametrize(
    "page",
    ["README.md", "docs/index.md", "docs/python.md",
     pytest.param("docs/paper.md", marks=pytest.mark.slow)],
)  # fmt: skip
def test_listings_run(page, tmp_path, monkeypatch, capsys):
    """All Python of a page, one listing after the other, with a shorter table."""
    text = (ROOT / page).read_text(encoding="utf-8")
    listings = re.findall(r"^```python\n(.*?)^```", text, re.MULTILINE | re.DOTALL)
    assert listings
    monkeypatch.chdir(tmp_path)
    exec("\n".join(listings).replace("20_000", "8"), {})
    assert nip.Outcome.COMPLETED in capsys.readouterr().out or page != "README.md"


def commands(page: Path) -> list[list[str]]:
    """Words of every command line in a listing of a page, without what stands for a number."""
    lines = re.findall(r"^ {4}nipper-pin (.*)$", page.read_text(encoding="utf-8"), re.MULTILINE)
    found = [shlex.split(part, comments=True) for line in lines for part in line.split("&&")]
    words = [each[1:] if each[:1] == ["nipper-pin"] else each for each in found]
    return [each for each in words if "..." not in each]


def test_commands_of_the_pages_exist():
    seen = 0
    for page in [*PAGES, ROOT / "README.md"]:
        for words in commands(page):
            seen += 1
            try:
                _parser().parse_args(words)
            except SystemExit:
                pytest.fail(f"{page.name}: nipper-pin {shlex.join(words)}")
    assert seen > 30


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


def test_files_and_tests_that_pages_name_exist():
    """A path begins at the root, in the package, beside it or in a folder of tests."""
    places = (ROOT, ROOT / "nipper_pin", ROOT / "benchmarks")
    missing, seen = [], 0
    for page in [*PAGES, ROOT / "README.md", ROOT / "CONTRIBUTING.md"]:
        text = page.read_text(encoding="utf-8")
        for path, test in re.findall(r"`([\w./]+/\w+\.py)(?:::(\w+)(?:\[[^`]*\])?)?`", text):
            seen += 1
            found = [place / path for place in places if (place / path).exists()]
            if not found or (test and f"def {test}(" not in found[0].read_text(encoding="utf-8")):
                missing.append((page.name, path, test))
    assert seen > 30
    assert missing == []


def test_every_picture_is_shown():
    texts = [page.read_text(encoding="utf-8") for page in [*PAGES, ROOT / "README.md"]]
    pictures = [file for file in (DOCS / "images").rglob("*.*") if file.is_file()]
    assert len(pictures) > 50
    paths = [file.relative_to(DOCS).as_posix() for file in pictures]
    assert [path for path in paths if not any(path in text for text in texts)] == []


def test_every_picture_is_drawn_by_one_command():
    """But for those of the gallery, whose program draws what it lists."""
    command = ["make", "--dry-run", "pictures", "benchmark"]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True)
    browser = ROOT / "scripts/maintain/in_browser/draw_view_pictures.py"
    known = done.stdout + browser.read_text(encoding="utf-8")
    pictures = [file for file in (DOCS / "images").glob("*.*") if file.is_file()]
    assert len(pictures) > 15
    words = [file.name if "view_" not in file.name else f'"{file.stem[5:]}"' for file in pictures]
    assert [word for word in words if word not in known] == []


def test_every_page_is_in_the_navigation_once():
    site = yaml.safe_load((ROOT / "mkdocs.yml").read_text(encoding="utf-8"))
    pages = [str(page.relative_to(DOCS)) for page in PAGES]
    assert sorted(in_navigation(site["nav"])) == pages
    assert site["strict"] is True
    assert site["theme"]["font"] is False


def test_the_architecture_names_every_room():
    text = (DOCS / "architecture.md").read_text(encoding="utf-8")
    package = ROOT / "nipper_pin"
    modules = [each for each in package.rglob("*.py") if each.name != "__init__.py"]
    rooms = {each.parent.relative_to(package).parts for each in modules} - {()}
    assert len(rooms) > 30
    assert [room for room in rooms if f"`{room[0]}/`" not in text] == []
    assert [room for room in rooms if len(room) == 2 and f"`{room[1]}/`" not in text] == []


def referenced() -> dict[str, object]:
    """What the Python reference shows, by its last name."""
    paths = re.findall(r"^::: (\S+)$", (DOCS / "api.md").read_text(encoding="utf-8"), re.MULTILINE)
    found = {}
    for path in paths:
        module, _, name = path.rpartition(".")
        found[name] = getattr(import_module(module), name)
    assert len(found) == len(paths)
    return found


def test_every_public_name_is_in_the_reference():
    shown = referenced()
    assert set(nip.__all__) <= set(shown)
    for name in nip.__all__:
        if name != "view":  # the package's own name is the room of that name, which can be called
            assert shown[name] is getattr(nip, name)


def test_the_reference_is_written_for_its_readers():
    """Docstrings are there, and hold no markup that the pages would show as it is."""
    for name, value in referenced().items():
        texts = [inspect.getdoc(value)]
        if inspect.isclass(value):
            texts += [inspect.getdoc(each) for key, each in vars(value).items() if key[0] != "_"]
        assert len((texts[0] or "").split()) > 1, name
        assert not [text for text in texts if text and re.search(r":[a-z]+:`", text)], name


def test_comments_beside_code_are_not_cut_off():
    """A page shows 80 columns of a block of code, in the site and on a code host alike."""
    wide = []
    for page in [*PAGES, ROOT / "README.md"]:
        fenced = False
        for line in page.read_text(encoding="utf-8").splitlines():
            if line.startswith("```"):
                fenced = not fenced
            elif (fenced or line.startswith("    ")) and "# " in line and len(line) > 80:
                wide.append((page.name, line))
    assert wide == []
