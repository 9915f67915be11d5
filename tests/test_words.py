"""What commands print, word for word: reviewed texts in tests/__snapshots__ (`make snapshots`).

Each stands there as on terminals of 60, 80 or 200 columns.
"""

from __future__ import annotations

import io
import json
import shlex
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest
from programs import STUDIES
from rich.console import Console
from snapshots import Words
from waiting import notes

from benchmarks.stress import Campaign, Verdict
from benchmarks.views.stress_report import print_campaign
from nipper_pin import Case, load, save, simulate
from nipper_pin.cli import main
from nipper_pin.view.console import Terminal, paste, say, show_table, unbroken_console

BALL = Path(__file__).parent / "verification" / "models" / "bouncing_mass"

ALL = (60, 80, 200)
# The widths of its terminals and the command, by a name.
COMMANDS = {
    "transition": ((80,), "simulate e62 --speed 650"),
    "turn_with_forces": (ALL, "simulate e62 --speed 650 --window cycle --forces"),
    "twenty_turns": ((80,), "simulate e62 --speed 650 --window cycle --cycles 20"),
    "elastic_shafts": ((60,), "simulate e62 --window cycle --drive inertial"),
    "ended_in_mid_rebound": ((80,), "simulate e62 --speed 650 --set restitution=0.9 --forces"),
    "pulled_open_and_fast": ((80,), "simulate e62 --set preload=-5 --speed 1e5"),
    "without_restitution": ((80,), "simulate e62 --set restitution=0"),
    "threshold": ((80,), "simulate e62 --speed 650 --rest-rate 0.02"),
    "threshold_of_a_slide": ((80,), "simulate ball --speed 60.37 --rest-rate 0.02"),
    "press": ((60,), "simulate press --window cycle --forces"),
    "without_transition_stop": ((80,), "simulate sieve --window cycle --forces"),
    "check": (ALL, "check e62"),
    "check_of_a_change": ((80,), "check e62 --set preload=9 --start-index 21.5 --speed 500"),
    "check_of_a_press": ((80,), "check press"),
    "check_of_a_ball": ((80,), "check ball --start-index 0"),
    # Two stops at once; a ball without loss, whose names look like markup and formulas, which are
    # errors of the libraries that print tables and draw figures; masses in grams.
    "check_twins": ((60,), "check twins"),
    "twins": ((60,), "simulate twins --window cycle --start-index 0 --forces"),
    "check_between_two_stops": ((60,), "check between"),
    "between_two_stops": (
        (60,),
        "simulate between --window cycle --start-index 0 --forces --out run",
    ),
    "check_masses": ((60,), "check grams"),
    "provenance": ((60,), "check e62 --provenance"),
    "compare": (ALL, "compare e62 --set-b stiffness=11000"),
    "compare_turns_and_drives": ((80,), "compare e62 --cycles 2 --drive inertial"),
    "compare_machines": ((60,), "compare e62 e62_identified --speed 450 520"),
    "compare_kinds": ((80,), "compare e62 hanging_pendulum --window transition"),
    "compare_the_same": ((80,), "compare e62 --set preload=9 --start-index 22"),
    "compare_without_rest": ((80,), "compare e62 --speed 450 1900"),
    "compare_saved": ((80,), "compare saved.npz --set-b speed=620"),
    "levers": ((60, 80), "levers e62 --speed 650"),
    "new": ((60,), "new a_press"),
    "new_study": ((60,), "new --study optimise a_design.toml"),
    "new_of_the_gallery": ((80,), "new --from toggle_press another"),
    "export": ((60,), "export sieve a_sieve"),
    "gallery": (ALL, "new --list"),
    "sweep": ((60,), "sweep sweep.toml --out results --workers 1"),
    "fit": ((60,), "identify camera.toml --starts 1 --profiles 1 --workers 1"),
    "fit_of_one_number": ((80,), "identify one.toml --starts 1 --profiles 0 --workers 1"),
    "fit_beyond_a_limit": ((80,), "identify limits.toml --starts 1 --profiles 0 --workers 1"),
}


@pytest.fixture(scope="module")
def home(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Machines, a study and a saved run that commands name."""
    folder = tmp_path_factory.mktemp("home")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        assert main(["new", "press"]) == 0
        assert main(["new", "sieve", "--from", "sieve"]) == 0
    (folder / "ball").symlink_to(BALL)
    # Of a ball with a restitution of 0.465 on a table of 1,510 mm a turn, and what was misread.
    shutil.copytree(STUDIES / "words", folder, dirs_exist_ok=True)
    save(simulate(load("e62"), Case(speed_rpm=600.0)), folder / "saved.npz")
    return folder


@pytest.mark.parametrize(
    ("name", "width"), [(name, width) for name, (all_of, _) in COMMANDS.items() for width in all_of]
)
def test_words_of_a_command(
    name: str,
    width: int,
    home: Path,
    tmp_path: Path,
    words: Words,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    for item in home.iterdir():
        (tmp_path / item.name).symlink_to(item)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", str(width))
    # This one finds something wrong.
    assert main(shlex.split(COMMANDS[name][1])) == (name == "fit_beyond_a_limit")
    words(capsys.readouterr().out.replace(f"{tmp_path}/", "FOLDER/"))


@pytest.mark.parametrize("width", [60, 80])
def test_words_of_a_campaign(width: int, words: Words) -> None:
    """Cases by family and reasons; of the wrong ones twenty are shown."""
    told = [("right", "COMPLETED", "")] * 5 + [("refused", "InputError", "no")] * 3
    told += [("wrong", "energy", "it [gained] 3 J")] + [("wrong", "hang", "for 600 s")] * 27
    verdicts = tuple(
        Verdict(number, ("transitions", "chains")[number % 2], *item, "00", 0.5)
        for number, item in enumerate(told)
    )
    words(printed(lambda to: print_campaign(Campaign(23, verdicts, 12.5), to), width))


def printed(write: Callable[[Console], None], width: int, *, colours: bool = False) -> str:
    stream = io.StringIO()
    system = "standard" if colours else None
    write(Terminal(file=stream, width=width, force_terminal=colours, color_system=system))
    return stream.getvalue()


# The console.


def test_what_is_wrong_is_red(
    home: Path, words: Words, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """A contradicted fit; the user's own text has neither colours nor markup."""
    monkeypatch.chdir(home)
    monkeypatch.setenv("COLUMNS", "80")
    monkeypatch.setenv("FORCE_COLOR", "1")
    monkeypatch.setenv("TERM", "xterm")
    line = "identify wrong.toml --starts 1 --profiles 0 --workers 1 --json wrong.json --out wrong"
    assert main(shlex.split(line)) == 1
    out, err = capsys.readouterr()
    err = notes(err)
    assert (err.partition(": ")[2][:27], err.count("\n")) == ("THE DATA CONTRADICT THE FIT", 1)
    document = json.loads((home / "wrong.json").read_text(encoding="utf-8"))
    assert document["goodness"]["verdict"] == "contradicted"
    model = (home / "wrong" / "wrong.toml").read_text(encoding="utf-8")
    assert document["goodness"]["sentence"] in " ".join(model.replace("#", " ").split())
    words(out)


def test_text_is_printed_without_styles_of_its_own() -> None:
    """Numbers, paths and brackets of the user's are neither coloured nor taken for markup."""
    text = "[bold]a[/bold] 12 /a/path 'text' None True http://x.org :smile: " + "word " * 50
    for write in (say, paste):
        found = printed(lambda to: write(to, text), 10_000, colours=True)  # noqa: B023
        assert found == f"{text.strip() if write is say else text}\n"
    assert len(printed(lambda to: say(to, text), 60).splitlines()) > 1
    assert printed(lambda to: paste(to, text), 60) == f"{text}\n"
    heads, row = ("a [s]", "b[m]", ":smile:"), ("[red]x[/red]", "[/]", ":+1: 7")
    found = printed(lambda to: show_table(to, heads, [row]), 80)
    assert [part for part in (*heads, *row) if part not in found] == []


def test_without_a_terminal_sentences_are_whole(monkeypatch: pytest.MonkeyPatch) -> None:
    """A script that searches the output finds every sentence on a line of its own."""
    monkeypatch.setattr("sys.stdout", io.StringIO())
    monkeypatch.delenv("COLUMNS", raising=False)
    monkeypatch.setenv("TERM", "dumb")
    console = unbroken_console()
    with console.capture() as said:
        say(console, "one thing " * 500)
    assert said.get().count("\n") == 1
    monkeypatch.setenv("COLUMNS", "70")
    monkeypatch.setenv("TERM", "xterm")
    assert unbroken_console().width == 70
