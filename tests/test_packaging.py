import email
import re
import subprocess
import sys
import tarfile
import tomllib
import zipfile
from importlib import metadata
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

import nipper_pin
from nipper_pin.extras import EXTRAS, PACKAGES

ROOT = Path(__file__).resolve().parent.parent
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
LOCK = (ROOT / "constraints.txt").read_text(encoding="utf-8").splitlines()
PINNED = {
    canonicalize_name(line.partition("==")[0]) for line in LOCK if line and not line.startswith("#")
}


def build(kind, source, folder):
    command = [sys.executable, "-m", "hatchling", "build", "-t", kind, "-d", str(folder)]
    done = subprocess.run(command, cwd=source, text=True, capture_output=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    (built,) = folder.glob("*.whl" if kind == "wheel" else "*.tar.gz")
    return built


def names(wheel):
    with zipfile.ZipFile(wheel) as archive:
        return set(archive.namelist())


def under(folder):
    return {
        path.relative_to(ROOT / folder).as_posix()
        for path in (ROOT / folder).rglob("*")
        if path.is_file() and "__pycache__" not in path.parts
    }


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    return build("wheel", ROOT, tmp_path_factory.mktemp("wheel"))


def test_wheel_holds_the_package_and_the_models_and_nothing_else(wheel):
    code = {f"nipper_pin/{name}" for name in under("nipper_pin")}
    models = {f"nipper_pin/models/{name}" for name in under("models")}
    assert {"nipper_pin/py.typed", "nipper_pin/cli/__init__.py"} <= code
    assert {"nipper_pin/models/e62/e62.urdf", "nipper_pin/models/e62/e62.toml"} <= models
    found = names(wheel)
    assert {name for name in found if ".dist-info/" not in name} == code | models
    assert any(name.endswith(".dist-info/licenses/LICENSE") for name in found)


def test_wheel_asks_for_the_libraries_of_a_run_and_offers_the_others(wheel):
    """Its version stands once, in the package: what builds the wheel has to find it there."""
    with zipfile.ZipFile(wheel) as archive:
        (name,) = [item for item in archive.namelist() if item.endswith(".dist-info/METADATA")]
        about = email.message_from_bytes(archive.read(name))
    assert about["Version"] == nipper_pin.__version__
    asked = [Requirement(text) for text in about.get_all("Requires-Dist")]
    plain = {item.name for item in asked if item.marker is None}
    assert plain == {"pin", "coal", "eigenpy", "numpy", "scipy", "msgspec", "rich"}
    assert set(about.get_all("Provides-Extra")) == {*EXTRAS, "all", "dev", "docs"}
    for extra, modules in EXTRAS.items():
        marked = [item for item in asked if item.marker and item.marker.evaluate({"extra": extra})]
        assert {item.name for item in marked} == {PACKAGES.get(name, name) for name in modules}


def test_every_public_name_is_at_the_door():
    """Names that come only when asked for are listed and given like all others, and no more."""
    assert len(set(nipper_pin.__all__)) == len(nipper_pin.__all__)
    assert {*nipper_pin.__all__, "__version__"} == set(dir(nipper_pin))
    for name in nipper_pin.__all__:
        assert getattr(nipper_pin, name).__name__.rpartition(".")[2] == name
        assert callable(getattr(nipper_pin, name))
    star = {}
    exec("from nipper_pin import *", star)
    assert set(nipper_pin.__all__) <= star.keys()
    with pytest.raises(AttributeError, match="nothing_of_this_name"):
        _ = nipper_pin.nothing_of_this_name
    with pytest.raises(ImportError, match="nothing_of_this_name"):
        from nipper_pin import nothing_of_this_name  # noqa: F401


@pytest.mark.slow
def test_wheel_built_from_the_sdist_is_the_same(wheel, tmp_path):
    sdist = build("sdist", ROOT, tmp_path)
    with tarfile.open(sdist) as archive:
        archive.extractall(tmp_path, filter="data")
    source = tmp_path / sdist.name.removesuffix(".tar.gz")
    with zipfile.ZipFile(wheel) as one, zipfile.ZipFile(build("wheel", source, tmp_path)) as two:
        assert {name: one.read(name) for name in one.namelist()} == {
            name: two.read(name) for name in two.namelist()
        }


def test_lock_is_plain_versions():
    for line in LOCK:
        if not line.startswith("#"):
            assert re.fullmatch(r"[A-Za-z0-9._-]+==[A-Za-z0-9.+!]+", line), line
        assert "://" not in line
        assert "index" not in line


def requirements(name, extra):
    """Requirements of a package: of this one as its project says, of others as installed."""
    if name != "nipper-pin":
        return metadata.requires(name) or []
    return PROJECT["optional-dependencies"][extra] if extra else PROJECT["dependencies"]


def test_lock_covers_everything_that_is_installed_for_the_package():
    todo = [(Requirement("nipper-pin[dev]"), "")]
    needed, seen = set(), set()
    while todo:
        requirement, extra = todo.pop()
        if requirement.marker and not requirement.marker.evaluate({"extra": extra}):
            continue
        name = canonicalize_name(requirement.name)
        needed.add(name)
        for wanted in {"", *requirement.extras} - {extra for one, extra in seen if one == name}:
            seen.add((name, wanted))
            todo += [(Requirement(text), wanted) for text in requirements(name, wanted)]
    needed.remove("nipper-pin")
    # These live on the far side of several requirements: proof that the walk reaches them.
    assert {"cmeel", "cmeel-boost", "libpinocchio", "libcoal", "eigenpy"} <= needed
    assert {"llvmlite", "markupsafe", "tornado", "httpx"} <= needed
    # Environments bring their own setuptools.
    assert needed - PINNED <= {"setuptools"}


def test_citation_and_changelog_are_of_this_version():
    """One version in the package, in what people cite and on top of the list of changes."""
    citation = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    assert re.findall(r"^version: (.*)$", citation, re.MULTILINE) == [nipper_pin.__version__]
    released = re.findall(
        r"^## \[(\d.*?)\] - (.*)$", (ROOT / "CHANGELOG.md").read_text(), re.MULTILINE
    )
    assert released[0][0] == nipper_pin.__version__
    assert f"date-released: {released[0][1]}\n" in citation
