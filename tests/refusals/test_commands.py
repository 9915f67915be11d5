"""Lines that commands refuse: one sentence, status 2, and nothing is begun.

The lines stand in the reviewed texts, each above its sentence.
"""

from __future__ import annotations

import shlex
import shutil
from pathlib import Path

import pytest
from programs import STUDIES, main
from snapshots import Words, blocks, without_the_machine

from nipper_pin import Case, Mechanism, save, save_case, simulate
from tests.refusals.bases import model


@pytest.fixture(scope="module")
def home(tmp_path_factory: pytest.TempPathFactory, e62: Mechanism) -> Path:
    """Files that lines name."""
    folder = Path(shutil.copytree(STUDIES, tmp_path_factory.mktemp("home"), dirs_exist_ok=True))
    for name in ("full", "out", "other"):
        (folder / name).mkdir()
    for name, text in (("file", "mine"), ("full/notes.txt", "mine"), ("other/mine.toml", "")):
        (folder / name).write_text(text, encoding="utf-8")
    (folder / "broken.npz").write_bytes(b"PK\x03\x04 not an archive")
    (folder / "loop").symlink_to("loop")
    (folder / "press.toml").write_text("drawing = 1\n", encoding="utf-8")
    model("small with rows", (), folder)
    case = Case(speed_rpm=600.0)
    save_case(e62, case, folder / "case.json")
    for name, window in (("before", "transition"), ("cycle", "cycle"), ("out/solution", "cycle")):
        save(simulate(e62, Case(speed_rpm=600.0, window=window)), folder / f"{name}.npz")
    return folder


def held(folder: Path) -> dict[Path, bytes]:
    """Everything in a folder, with the contents of files."""
    return {path: path.read_bytes() if path.is_file() else b"" for path in folder.rglob("*")}


@pytest.mark.parametrize("table", ["comparisons", "new", "runs", "settings", "studies", "usage"])
def test_sentences(
    table: str,
    home: Path,
    words: Words,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(home)
    there, text = held(home), ""
    for line in (item.name for item in blocks(__file__, f"test_sentences[{table}]")):
        try:
            status = main(shlex.split(line))
        except SystemExit as ended:
            status = ended.code
        out, err = capsys.readouterr()
        # A parser says how a command is used before it says what is wrong.
        usage, _, said = err.rpartition(": error: ")
        assert (status, out, said.count("\n")) == (2, "", 1), (line, err)
        assert (usage != "") == usage.startswith("usage: ") == (table == "usage")
        assert held(home) == there, line
        said = said.removeprefix("nipper-pin: ").replace(str(home), "HOME")
        text += f"{line}\n    {without_the_machine(said)}"
    words(text, masked=False)
