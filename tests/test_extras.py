"""What works without the libraries of the extras, and what the others say of the missing ones."""

import os
import subprocess
import sys
import tomllib
from collections.abc import Iterable
from importlib import metadata
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name
from waiting import notes

import nipper_pin as nip
from nipper_pin.cli import main
from nipper_pin.extras import EXTRAS, PACKAGES, require

ROOT = Path(__file__).resolve().parent.parent
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
MODULES = sorted({name for names in EXTRAS.values() for name in names})
OPTIMISE = str(ROOT / "scripts/optimise_rebound.toml")
SWEEP = str(ROOT / "scripts/sweep_spring.toml")


# The command, for which some libraries are not installed.
WITHOUT = """
import sys
sys.modules.update(dict.fromkeys(sys.argv.pop(1).split(",")))
from nipper_pin.cli import main
sys.exit(main())
"""


def run_without(
    modules: Iterable[str], *arguments: str, folder: Path
) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-c", WITHOUT, ",".join(modules), *arguments],
        cwd=folder, stdin=subprocess.DEVNULL, capture_output=True, text=True, check=False,
        env=os.environ | {"PYTHONPATH": os.pathsep.join(path for path in sys.path if path)},
    )  # fmt: skip


def distribution(module):
    return canonicalize_name(PACKAGES.get(module, module))


def test_all_is_all_that_the_commands_use() -> None:
    (whole,) = map(Requirement, PROJECT["optional-dependencies"]["all"])
    assert whole.name == PROJECT["name"]
    assert whole.extras == EXTRAS.keys() - {"peers"}
    assert "nipper-pin[all]" in PROJECT["optional-dependencies"]["dev"]


def test_modules_come_with_the_packages_that_are_named() -> None:
    owners = metadata.packages_distributions()
    known = [name for name in MODULES if name in owners]
    assert {"meshcat", "umsgpack", "PIL", "numba", "pyarrow", "tornado"} <= set(known)
    for name in known:
        assert distribution(name) in {canonicalize_name(owner) for owner in owners[name]}


@pytest.mark.sampled(2)
@pytest.mark.parametrize(
    "command",
    [
        ["simulate", "e62", "--speed", "650", "--json", "-"],
        ["simulate", "--window", "cycle", "--forces"],
        ["check", "e62"],
        ["new", "machine"],
    ],
)
def test_without_the_extras_the_same_is_printed(
    command: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:  # fmt: skip
    monkeypatch.setenv("COLUMNS", "120")
    # Of one length: sentences are folded as they are printed, the path included.
    here, there = tmp_path / "with", tmp_path / "none"
    here.mkdir()
    there.mkdir()
    done = run_without(MODULES, *command, folder=there)
    assert (done.returncode, notes(done.stderr)) == (0, "")
    assert done.stdout
    monkeypatch.chdir(here)
    assert main(command) == 0

    def timeless(text: str) -> list[str]:
        lines = text.splitlines()
        return [line for line in lines if not line.endswith(" ms") and "wall_s" not in line]

    bare = done.stdout.replace(str(there), str(here))
    assert timeless(bare) == timeless(capsys.readouterr().out)


def test_a_run_imports_nothing_of_the_extras(tmp_path: Path) -> None:
    """Nor does one that writes JSON alone pay for tables."""
    code = (
        "import sys\nfrom nipper_pin.cli import main\n"
        "assert main(['simulate', '--json', '-']) == 0\n"
        "assert not {'rich', 'scipy'} & sys.modules.keys()\n"
        "for words in ('simulate e62', 'simulate --window cycle --json a', 'check', 'new b'):\n"
        "    assert main(words.split()) == 0\n"
        f"print(sorted(set({MODULES!r}) & sys.modules.keys()), file=sys.stderr)\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True, check=True
    )
    assert notes(done.stderr) == "[]\n"


MISSING = [
    ("view", "matplotlib", ["simulate", "--out", "run"]),
    ("view", "meshcat", ["view", "--html", "page.html"]),
    ("view", "umsgpack", ["view", "--no-browser"]),
    ("view", "matplotlib", ["view", "--gif", "film.gif"]),
    ("view", "PIL", ["view", "--gif", "film.gif"]),
    ("live", "tornado", ["live", "--no-browser"]),
    ("live", "meshcat", ["live", "--no-browser"]),
    ("study", "numba", ["speed-limit"]),
    ("study", "matplotlib", ["speed-limit", "--plot", "limit.svg"]),
    ("study", "matplotlib", ["optimise", OPTIMISE]),
    ("sweep", "pyarrow", ["sweep", SWEEP, "--dry-run"]),
    ("sweep", "pyarrow", ["sweep", SWEEP]),
    ("cluster", "distributed", ["sweep", SWEEP, "--scheduler", "tcp://127.0.0.1:1"]),
    ("study", "matplotlib", ["plot", "sweep"]),
    ("study", "pyarrow", ["plot", "sweep"]),
]


@pytest.mark.sampled(4)
@pytest.mark.parametrize(
    ("extra", "module", "command"), MISSING, ids=lambda item: item if item in MODULES else item[0]
)
def test_a_missing_library_is_one_sentence_with_its_install_line(
    extra: str, module: str, command: list[str], tmp_path: Path
) -> None:
    done = run_without([module], *command, folder=tmp_path)
    assert (done.returncode, done.stdout) == (2, "")
    package = PACKAGES.get(module, module)
    assert done.stderr.startswith("nipper-pin: ")
    assert done.stderr.endswith(
        f' needs {package}, which is not installed: pip install "nipper-pin[{extra}]"\n'
    )
    assert done.stderr.count("\n") == 1
    # What a command makes before it computes is empty; nothing else is written.
    assert not [path for path in tmp_path.rglob("*") if path.is_file()]


def test_several_missing_libraries_are_one_list(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("nipper_pin.extras.installed", lambda name: name == "tornado")
    with pytest.raises(nip.InputError) as caught:
        require("view", "meshcat", "umsgpack", "PIL", what="a picture")
    assert caught.value.message == (
        "a picture needs meshcat, u-msgpack-python and pillow, which are not installed: "
        'pip install "nipper-pin[view]"'
    )
    with pytest.raises(nip.InputError) as caught:
        require("live", what="a page")
    assert caught.value.evidence == {"extra": "live", "packages": ("meshcat", "u-msgpack-python")}
    require("live", "tornado", what="a page")


def test_calls_of_python_name_the_install_line(
    e62: nip.Mechanism, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    solution = nip.simulate(e62, nip.Case(speed_rpm=650.0))
    monkeypatch.setattr("nipper_pin.extras.installed", lambda _: False)
    calls = {
        "view": [lambda: nip.view(solution), lambda: nip.view(solution, tmp_path / "page.html"),
                 lambda: nip.view(solution, tmp_path / "film.gif")],
        "study": [lambda: nip.transition_table(e62, speed_rpm=[450.0], engine="reduced")],
        "sweep": [lambda: nip.sweep(SWEEP, tmp_path / "sweep"),
                  lambda: nip.read_sweep(tmp_path / "sweep")],
    }  # fmt: skip
    for extra, asked in calls.items():
        for call in asked:
            with pytest.raises(nip.InputError, match=rf'pip install "nipper-pin\[{extra}\]"'):
                call()
    assert list(tmp_path.iterdir()) == []
