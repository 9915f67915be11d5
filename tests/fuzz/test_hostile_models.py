"""Models that once ended in a traceback, a crash or a wait without end: one sentence for each."""

from __future__ import annotations

import re
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest
from matplotlib.figure import Figure

import nipper_pin
from nipper_pin import Case, InputError, NipperError, load, simulate
from nipper_pin.cli import main
from nipper_pin.mechanism import find_model
from nipper_pin.view.plain_texts import plain
from nipper_pin.view.run.plots import plot_solution

LIP = '<box size="0.012 0.2 0.0003"/>'
TABLE = '\n[springs.tab]\njoint = "jaw"\nfile = "t.csv"\n'
HEAD = b"coordinate_deg,torque_N_m\n"


def chain(text: str, count: int = 10_000) -> str:
    """Links that hang from one another by fixed joints."""
    rows = [
        f'<link name="c{k}"/><joint name="j{k}" type="fixed">'
        f'<parent link="{f"c{k - 1}" if k else "rocker"}"/><child link="c{k}"/></joint>'
        for k in range(count)
    ]
    return text.replace("</robot>", "".join(rows) + "</robot>")


def mesh(text: str) -> str:
    return text.replace(LIP, '<mesh filename="bad.stl"/>')


def toml(old: str, new: str) -> Callable[[str], str]:
    return lambda text: re.sub(old, lambda _: new, text, count=1, flags=re.MULTILINE)


HOSTILE: dict[
    str, tuple[Callable[[str], str] | None, Callable[[str], str] | None, dict[str, bytes]]
]
HOSTILE = {
    "colour": (lambda text: re.sub('rgba="[^"]*"', 'rgba="1 x 0 1"', text), None, {}),
    "deep xml": (lambda text: text.replace("</robot>", "<a>" * 10**5 + "</a>" * 10**5 + "</robot>"),
                 None, {}),
    "chain of links": (chain, None, {}),
    "mesh cut off": (mesh, None, {"bad.stl": b"solid x\nfacet normal nan"}),
    "mesh of no length": (mesh, None, {"bad.stl": b"\0" * 80 + b"\xff\xff\xff\x7f" + b"\0" * 10}),
    "mesh of no numbers": (mesh, None, {"bad.stl": b"solid x\nfacet normal 0 0 1\nouter loop\n"
                           b"vertex nan 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n"}),
    "deep toml": (None, lambda text: text + "\nx = " + "[" * 10**5 + "]" * 10**5 + "\n", {}),
    "long number": (None, toml(r"^degrees_of_freedom = \d+", f"degrees_of_freedom = {'9' * 5000}"),
                    {}),
    "escape in a title": (None, toml("^title = .*$", r'title = "a\u001b[2Jb"'), {}),
    "control character of eight bits": (None, toml("^title = .*$", r'title = "\u009b2J"'), {}),
    "text that is turned round": (None, toml("^title = .*$", r'title = "\u202etxt"'), {}),
    "formula as a name": (lambda text: text.replace('"jaw"', '"=jaw"'),
                          lambda text: text.replace("jaw", "=jaw"), {}),
    "formula as a key": (None, toml(r"^\[stops\.jaw\]", '[stops."=1+1"]'), {}),
    "text of bytes": (None, lambda text: text + TABLE, {"t.csv": HEAD + b"\xff\xfe,1\n"}),
    "long field": (None, lambda text: text + TABLE, {"t.csv": HEAD + b"1" * 200_000 + b",1\n"}),
}  # fmt: skip


@pytest.mark.parametrize("name", HOSTILE)
def test_a_hostile_model_is_refused(
    name: str, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    urdf, table, files = HOSTILE[name]
    folder = tmp_path / "m"
    shutil.copytree(find_model("e62"), folder)
    for suffix, change in (("urdf", urdf), ("toml", table)):
        text = (folder / f"e62.{suffix}").read_text(encoding="utf-8")
        (folder / f"m.{suffix}").write_text(text if change is None else change(text))
        (folder / f"e62.{suffix}").unlink()
    for file, content in files.items():
        (folder / file).write_bytes(content)
    with pytest.raises(NipperError):
        load(folder)
    assert main(["check", str(folder)]) == 2
    assert "nipper-pin: " in capfd.readouterr().err


def test_markup_in_names_is_printed_as_it_is(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Closing tags that open nothing are errors of the library that prints tables."""
    folder = tmp_path / "m"
    folder.mkdir()
    model = find_model("hanging_pendulum")
    for suffix in ("urdf", "toml"):
        text = (model / f"hanging_pendulum.{suffix}").read_text(encoding="utf-8")
        text = text.replace('"jaw"', '"[/x]jaw"').replace("stops.jaw]", 'stops."[/x]jaw"]')
        text = re.sub("^title = .*$", 'title = "[bold]t[/y]"', text, flags=re.MULTILINE)
        (folder / f"m.{suffix}").write_text(text.partition("[shortcuts]")[0])
    out = str(tmp_path / "run")
    for words in (["check"], ["simulate", "--speed", "300", "--forces", "--out", out]):
        assert main([words[0], str(folder), *words[1:]]) == 0
        said = capsys.readouterr().out
        assert said.startswith("[bold]t[/y]")
        assert "[/x]jaw" in said


@pytest.mark.slow
def test_dollars_in_names_are_no_formulas(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Nor in any figure: each is made plain before it is written."""
    folder = tmp_path / "m"
    folder.mkdir()
    model = find_model("hanging_pendulum")
    name = r"$\\frac{$jaw"
    for suffix in ("urdf", "toml"):
        text = (model / f"hanging_pendulum.{suffix}").read_text(encoding="utf-8")
        text = text.replace('"jaw"', f'"{name}"' if suffix == "toml" else '"$\\frac{$jaw"')
        text = text.replace("stops.jaw]", f'stops."{name}"]').partition("[shortcuts]")[0]
        (folder / f"m.{suffix}").write_text(text)
    run = ["simulate", str(folder), "--speed", "300", "--window", "cycle"]
    assert main([*run, "--out", str(tmp_path / "run")]) == 0
    assert "$\\frac{$jaw" in capsys.readouterr().out
    # Figures are written in one place, which draws texts as they stand.
    saved = [
        (file.name, line.strip())
        for file in Path(nipper_pin.__file__).parent.rglob("*.py")
        for line in file.read_text(encoding="utf-8").splitlines()
        if ".savefig(" in line
    ]
    assert {name for name, _ in saved} == {"figure_file.py"}
    assert all(line.startswith("plain(") for _, line in saved if "document," not in line), saved


def test_plain_texts(tmp_path: Path) -> None:
    """Titles, labels, legends and names beside an axis; powers of ten stay formulas."""
    figure = Figure()
    axes = figure.subplots()
    axes.semilogy([0.0, 1.0], [1.0, 100.0], label="$\\frac{$")
    axes.legend(title="$\\frac{$")
    axes.set_xticks([0.0, 1.0], ["$\\frac{$", "b"])
    for write in (axes.set_title, axes.set_xlabel, axes.set_ylabel, figure.suptitle):
        write("$\\frac{$")
    figure.text(0.5, 0.5, "$\\frac{$")
    with pytest.raises(ValueError, match="frac"):
        figure.savefig(tmp_path / "figure.svg")
    plain(figure).savefig(tmp_path / "figure.svg")
    assert "10^{2}" in (tmp_path / "figure.svg").read_text(encoding="utf-8")


def test_links_in_a_circle_are_no_model(tmp_path: Path) -> None:
    loop = tmp_path / "loop"
    loop.symlink_to(loop)
    with pytest.raises(NipperError, match="loop"):
        load(loop)


def test_more_turns_than_a_machine_lives_are_refused() -> None:
    with pytest.raises(InputError, match="from 1 to 1,000,000"):
        Case(speed_rpm=450.0, window="cycle", cycles=10**20)


def test_a_title_is_no_formula(tmp_path: Path) -> None:
    """Dollars of a title are drawn as they are."""
    folder = tmp_path / "m"
    shutil.copytree(find_model("e62"), folder)
    for suffix in ("urdf", "toml"):
        (folder / f"e62.{suffix}").rename(folder / f"m.{suffix}")
    text = (folder / "m.toml").read_text(encoding="utf-8")
    (folder / "m.toml").write_text(toml("^title = .*$", "title = '$\\frac{$'")(text))
    run = simulate(load(folder), Case(speed_rpm=650.0))
    assert run.mechanism.title == "$\\frac{$"
    assert plot_solution(run, tmp_path / "plots")
