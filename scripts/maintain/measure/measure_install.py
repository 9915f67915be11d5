"""What does an installation consist of, and does its command run the E62 without a display?

    python scripts/maintain/measure/measure_install.py [OTHER] [--extras view study all]

The wheel of this checkout is built, and installed by pip with the versions of constraints.txt into
fresh environments: alone, then with each extra. OTHER is the folder of another checkout, whose
wheel is installed alone. Sizes are those of all installed files, without compiled bytecode. In each
environment `nipper-pin simulate e62` then runs in an empty folder, without a display. Needs
hatchling and the package index that pip is set up for.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
import venv
from pathlib import Path

HERE = Path(__file__).resolve().parents[3]
EXTRAS = ("view", "study", "all")
_RUN = ("simulate", "e62", "--speed", "650")
_BYTES_PER_MB = 1e6
_DISPLAYS = ("DISPLAY", "WAYLAND_DISPLAY", "MPLBACKEND", "PYTHONPATH")


def build(checkout: Path, folder: Path) -> Path:
    """Build the wheel of a checkout.

    Args:
        checkout: Its folder.
        folder: Where the wheel is put.
    """
    command = [sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", str(folder)]
    subprocess.run(command, cwd=checkout, check=True, stdout=subprocess.DEVNULL)
    (wheel,) = folder.glob("*.whl")
    return wheel


def install(wheel: Path, extra: str, constraints: Path, home: Path) -> tuple[int, float]:
    """Install a wheel into a new environment.

    Args:
        wheel: The wheel.
        extra: One of its extras, or an empty text.
        constraints: Versions of what it needs.
        home: Folder of the environment.

    Returns:
        Number of installed packages, the wheel's own included, and the size of all files [MB].
    """
    venv.create(home, with_pip=False, symlinks=True)
    wanted = f"{wheel}[{extra}]" if extra else str(wheel)
    command = [sys.executable, "-m", "pip", "--python", str(home / "bin" / "python"), "install"]
    command += ["-qq", "--disable-pip-version-check", "--no-compile"]
    command += ["-c", str(constraints), wanted]
    subprocess.run(command, check=True)
    (site,) = home.glob("lib/python*/site-packages")
    size = sum(path.stat().st_size for path in site.rglob("*") if path.is_file())
    return sum(1 for _ in site.glob("*.dist-info")), size / _BYTES_PER_MB


def ending(home: Path, folder: Path) -> str:
    """Run the E62 with the command of an environment.

    Args:
        home: Folder of the environment.
        folder: Where the command runs.

    Returns:
        The last line that it printed.
    """
    bare = {name: value for name, value in os.environ.items() if name not in _DISPLAYS}
    command = [str(home / "bin" / "nipper-pin"), *_RUN]
    done = subprocess.run(command, cwd=folder, env=bare, capture_output=True, text=True, check=True)
    return done.stdout.strip().splitlines()[-1]


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("other", nargs="?", type=Path, metavar="OTHER")
    parser.add_argument("--extras", nargs="*", default=EXTRAS, metavar="NAME")
    options = parser.parse_args()
    asked = [("this version", HERE, extra) for extra in ("", *options.extras)]
    if options.other is not None:
        asked.append(("the other version", options.other.resolve(), ""))
    with tempfile.TemporaryDirectory() as name:
        work = Path(name)
        elsewhere = work / "elsewhere"
        elsewhere.mkdir()
        roots = dict.fromkeys(root for _, root, _ in asked)
        wheels = {root: build(root, work / f"wheel-{n}") for n, root in enumerate(roots)}
        print(f"{'':32s} packages      MB   {' '.join(_RUN)}")
        for number, (title, root, extra) in enumerate(asked):
            home = work / str(number)
            count, size = install(wheels[root], extra, root / "constraints.txt", home)
            said = ending(home, elsewhere)
            what = f"{title}, [{extra}]" if extra else title
            print(f"{what:32s} {count:8d} {size:7.1f}   {said}", flush=True)


if __name__ == "__main__":
    main()
