"""Text of a file or a path that would command a terminal is written out, wherever it is printed."""

from __future__ import annotations

import io
import json
import re
import shutil
import sys
from collections.abc import Callable
from pathlib import Path
from unicodedata import category

import pytest
from matplotlib.figure import Figure
from refusals import answer, packed, stored_run

import nipper_pin
from nipper_pin import Case, InputError, load, save, save_case, simulate
from nipper_pin.mechanism import find_model
from nipper_pin.view.console import Terminal, headline, paste, say, show_table
from nipper_pin.view.figure_file import plain

BASES = Path(__file__).parent / "bases"
# A title, a colour, a line that is cleared and one that is written over, and a turned direction.
CODES = "\x1b]0;x\x07\x1b[31mred\x9b2K\rover\bx\u202eabc\u2066d\u200b"
OWN = re.compile(r"\x1b\[[0-9;]*m")


def raw(text: str) -> set[str]:
    """Letters of an output that are no text."""
    return {letter for letter in text if not letter.isprintable()} - {"\n"}


def in_case(folder: Path) -> None:
    document = json.loads((folder / "case.json").read_text())
    (folder / "case.json").write_text(json.dumps({**document, "format": CODES}))


def in_run(folder: Path) -> None:
    document, arrays = stored_run(folder / "run.npz")
    (folder / "run.npz").write_bytes(packed({**document, "format": CODES}, arrays))


def in_plan(folder: Path) -> None:
    plan = json.loads((BASES / "plan.json").read_text())
    (folder / "plan.json").write_text(json.dumps({**plan, "format": CODES}))


def in_title(folder: Path) -> None:
    text = (folder / "pend" / "pend.toml").read_text()
    line = f"title = {json.dumps(CODES)}"
    (folder / "pend/pend.toml").write_text(re.sub("(?m)^title = .*", lambda _: line, text))


def in_name(folder: Path) -> None:
    text = (folder / "pend" / "pend.urdf").read_text()
    (folder / "pend" / "pend.urdf").write_text(text.replace('name="', 'name="\u202e\u200b', 3))


def in_path(folder: Path) -> None:
    (folder / CODES).mkdir()
    for file in ("run.npz", "case.json"):
        shutil.copy(folder / file, folder / CODES)


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A model, a case and a run without codes."""
    home = tmp_path_factory.mktemp("whole")
    shutil.copytree(find_model("hanging_pendulum"), home / "pend")
    for kind in ("urdf", "toml"):
        (home / f"pend/hanging_pendulum.{kind}").rename(home / f"pend/pend.{kind}")
    machine, case = load("hanging_pendulum"), Case(speed_rpm=60.0, max_collisions=1)
    save_case(machine, case, home / "case.json")
    save(simulate(machine, case), home / "run.npz")
    return home


@pytest.mark.parametrize(("change", "words"), [
    (in_case, ["simulate", "--case", "case.json"]), (in_plan, ["plot", "."]),
    (in_run, ["view", "--solution", "run.npz"]),
    (in_title, ["check", "pend"]), (in_title, ["simulate", "pend"]),
    (in_name, ["check", "pend"]), (in_name, ["simulate", "pend"]),
    (in_path, ["view", "--solution", f"{CODES}/no.npz"]),
    (in_path, ["simulate", "--case", f"{CODES}/no.json"]),
    (in_path, ["check", CODES]), (in_path, ["simulate", "--case", CODES]),
    (in_path, ["compare", f"{CODES}/run.npz", "run.npz"]), (in_path, ["new", CODES]),
    (in_path, ["simulate", "--json", f"{CODES}/x\udcff"]),
    (in_path, ["simulate", "--set", f"{CODES}=1"]), (in_path, ["sweep", CODES]),
    (in_path, ["optimise", CODES]), (in_path, ["plot", CODES]),
    (in_path, ["check", "e62", "--drawing", f"{CODES}/m.svg"]),
])  # fmt: skip
def test_no_code_of_a_file_reaches_the_terminal(
    change: Callable[[Path], None], words: list[str], whole: Path, here: Path
) -> None:
    shutil.copytree(whole, here, dirs_exist_ok=True)
    change(here)
    _, out, err = answer(words)
    assert out + err
    assert not raw(out + err)


def test_no_letter_that_is_none_is_printed() -> None:
    """In a table, a sentence, a heading, a command and an error; colours of our own stay.

    Codes, marks of direction, and what separates lines and paragraphs; of others every thousandth.
    """
    kinds, others = {"Cc", "Cf", "Zl", "Zp", "Zs"}, map(chr, range(sys.maxunicode + 1))
    every = [letter for letter in others if not letter.isprintable()
             and (category(letter) in kinds or ord(letter) % 1000 == 0)]  # fmt: skip
    text, stream = "word ".join(every), io.StringIO()
    console = Terminal(file=stream, force_terminal=True, color_system="truecolor", width=100)
    say(console, text, style="red")
    headline(console, text)
    paste(console, text)
    show_table(console, ["name", "value"], [[text, "1"]])
    printed = stream.getvalue()
    assert OWN.search(printed)
    assert not raw(OWN.sub("", printed))
    assert not raw(InputError(text).message)


def test_tables_and_figures_are_written_in_one_place() -> None:
    """By that console, and by the file that draws texts as they stand."""
    found = [
        (file.name, line.strip())
        for file in Path(nipper_pin.__file__).parent.rglob("*.py")
        for line in file.read_text(encoding="utf-8").splitlines()
        if re.search(r"\bConsole\(|\.savefig\(", line)
    ]
    assert {name for name, _ in found} == {"figure_file.py"}
    assert all(line.startswith("plain(") for _, line in found if "document," not in line), found


# Names and titles that look like markup or formulas.

FORMULA = "$\\frac{$"


def test_plain_texts(tmp_path: Path) -> None:
    """Titles, labels, legends and names beside an axis; powers of ten stay formulas."""
    figure = Figure()
    axes = figure.subplots()
    axes.semilogy([0.0, 1.0], [1.0, 100.0], label=FORMULA)
    axes.legend(title=FORMULA)
    axes.set_xticks([0.0, 1.0], [FORMULA, "b"])
    for write in (axes.set_title, axes.set_xlabel, axes.set_ylabel, figure.suptitle):
        write(FORMULA)
    figure.text(0.5, 0.5, FORMULA)
    with pytest.raises(ValueError, match="frac"):
        figure.savefig(tmp_path / "figure.svg")
    plain(figure).savefig(tmp_path / "figure.svg")
    assert "10^{2}" in (tmp_path / "figure.svg").read_text(encoding="utf-8")
