"""Pages of docs/: their length, what they link to, and their place in the site."""

import inspect
import re
import shlex
import subprocess
import sys
from importlib import import_module
from pathlib import Path

import pytest

import nipper_pin as nip
from nipper_pin.cli import _parser

ROOT = Path(__file__).parents[1]
DOCS = ROOT / "docs"
PAGES = sorted(DOCS.rglob("*.md"))
MOST = 1300
LINK = re.compile(r"\]\(([^)\s]+)\)")


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(DOCS)))
def test_page_is_short(page):
    words = sum(any(map(str.isalnum, each)) for each in page.read_text(encoding="utf-8").split())
    assert words <= MOST


@pytest.mark.usefixtures("here")
@pytest.mark.parametrize("page", ["README.md", "docs/index.md", "docs/python.md"])
def test_listings_run(page, capsys):
    """All Python of a page, one listing after the other, with a shorter table."""
    text = (ROOT / page).read_text(encoding="utf-8")
    listings = re.findall(r"^```python\n(.*?)^```", text, re.MULTILINE | re.DOTALL)
    assert listings
    text = "\n".join(listings).replace("20_000", "8")
    exec(text, {})
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
            except SystemExit as ended:
                if not ended.code:
                    continue
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
    """Also that Makefile, models and programs name; a path begins at the root or in a package."""
    places = (ROOT, ROOT / "nipper_pin", ROOT / "benchmarks")
    pages = [*PAGES, *ROOT.glob("*.md"), ROOT / "Makefile", *ROOT.glob("models/*/*.toml")]
    pages += [*ROOT.glob("scripts/*.toml"), *ROOT.glob("scripts/**/*.py")]
    missing, seen = [], 0
    for page in pages:
        text = page.read_text(encoding="utf-8")
        named = re.findall(r"`([\w./]+/\w+\.py)(?:::(\w+)(?:\[[^`]*\])?)?`", text)
        named += [(path, "") for path in re.findall(r"\bscripts/[a-z0-9_/]+\.[a-z]+", text)]
        for path, test in named if page.name != "CHANGELOG.md" else ():
            seen += 1
            found = [place / path for place in places if (place / path).exists()]
            if not found or (test and f"def {test}(" not in found[0].read_text(encoding="utf-8")):
                missing.append((page.name, path, test))
    assert seen > 50
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


def test_the_architecture_names_every_room():
    text = (DOCS / "architecture.md").read_text(encoding="utf-8")
    package = ROOT / "nipper_pin"
    modules = [each for each in package.rglob("*.py") if each.name != "__init__.py"]
    rooms = {each.parent.relative_to(package).parts for each in modules} - {()}
    assert len(rooms) > 30
    assert [room for room in rooms if f"`{room[0]}/`" not in text] == []
    assert [room for room in rooms if len(room) == 2 and f"`{room[1]}/`" not in text] == []


def test_the_reference_shows_every_public_name_and_is_written_for_its_readers():
    """Docstrings are there, describe every argument, and hold no markup shown as it is."""
    paths = re.findall(r"^::: (\S+)$", (DOCS / "api.md").read_text(encoding="utf-8"), re.MULTILINE)
    places = [path.rpartition(".") for path in paths]
    shown = {name: getattr(import_module(module), name) for module, _, name in places}
    assert len(shown) == len(paths)
    for name in nip.__all__:
        # The package's own name of the view is the room of that name, which can be called.
        assert name == "view" or shown[name] is getattr(nip, name)
    for name, value in shown.items():
        inner = vars(value).values() if inspect.isclass(value) else ()
        texts = [inspect.getdoc(each) or "" for each in (value, *inner)]
        assert len(texts[0].split()) > 1, name
        assert not [text for text in texts if re.search(r":[a-z]+:`", text)], name
        for item in filter(inspect.isfunction, (value, *inner)):
            if "Args:" in (text := inspect.getdoc(item) or ""):
                described = " ".join(re.findall(r"^ +([\w, *]+): ", text, re.MULTILINE))
                told = set(re.split(r"[ ,*]+", described))
                assert set(inspect.signature(item).parameters) - {"self", "cls"} <= told, name


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


@pytest.mark.slow
def test_the_site_is_built_and_loads_nothing_from_elsewhere(tmp_path):
    """Links, headings and the navigation are checked by the build, whose warnings are errors."""
    pytest.importorskip("mkdocs")
    pytest.importorskip("mkdocstrings")
    command = [sys.executable, "-m", "mkdocs", "build", "--strict", "--site-dir", str(tmp_path)]
    subprocess.run(command, cwd=ROOT, check=True, capture_output=True)
    pages = [file for file in tmp_path.rglob("*.html") if file.name != "404.html"]
    assert len(pages) == len(PAGES)
    for page in pages:
        text = page.read_text(encoding="utf-8")
        tags = re.findall(r"<(?:script|img|iframe|link)\b[^>]*>", text)
        tags = [tag for tag in tags if not re.search(r'rel="?(prev|next|canonical)', tag)]
        found = re.findall(r'\b(?:src|href)="?([^"\s>]+)', " ".join(tags))
        assert found, page
        for file in found:
            there = (page.parent / file.partition("?")[0]).exists()
            assert file.startswith("data:") or there, (page, file)
    for sheet in tmp_path.rglob("*.css"):
        style = sheet.read_text(encoding="utf-8")
        assert not re.search(r"url\([\"']?(?:https?:)?//|@import", style), sheet
