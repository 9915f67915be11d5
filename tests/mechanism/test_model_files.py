"""Which files of a folder are a model, and how messages call them."""

from __future__ import annotations

import os
import shutil
import tempfile
from collections.abc import Iterator
from pathlib import Path

import pytest

from nipper_pin import InputError, ModelError, UnknownNameError, load
from nipper_pin.mechanism import find_model
from nipper_pin.mechanism.new_folder import check_new_folder, new_folder
from nipper_pin.texts import no_file

E62 = find_model("e62")


@pytest.fixture
def copied(tmp_path: Path) -> Path:
    """A copy of a model's folder, which has another name."""
    return Path(shutil.copytree(E62, tmp_path / "e62 (copy)"))


def test_a_copied_folder_is_a_model_of_its_own_name(copied: Path) -> None:
    mechanism = load(copied)
    assert mechanism.name == "e62 (copy)"
    assert mechanism.urdf == load("e62").urdf
    assert mechanism.mesh_folder == str(copied)
    assert find_model(copied) == copied


@pytest.mark.parametrize(("urdf", "toml"), [("robot.urdf", "stops.toml"), ("A.URDF", "b.TOML")])
def test_any_names_of_two_files(copied: Path, urdf: str, toml: str) -> None:
    (copied / "e62.urdf").rename(copied / urdf)
    (copied / "e62.toml").rename(copied / toml)
    (copied / "._e62.toml").write_text("what another system leaves behind", encoding="utf-8")
    assert load(str(copied)).name == "e62 (copy)"


def test_files_with_the_name_of_the_folder_come_before_others(copied: Path) -> None:
    for kind in ("urdf", "toml"):
        shutil.copy(copied / f"e62.{kind}", copied / f"{copied.name}.{kind}")
        (copied / f"e62.{kind}").write_text("", encoding="utf-8")
    assert load(copied).name == copied.name


@pytest.mark.parametrize("kind", ["urdf", "toml"])
def test_several_of_a_kind_are_listed(copied: Path, kind: str) -> None:
    shutil.copy(copied / f"e62.{kind}", copied / f"other.{kind}")
    with pytest.raises(ModelError, match=rf"several.*: e62\.{kind}, other\.{kind}$"):
        load(copied)


@pytest.mark.parametrize("kind", ["urdf", "toml"])
def test_none_of_a_kind(copied: Path, kind: str) -> None:
    (copied / f"e62.{kind}").unlink()
    with pytest.raises(ModelError, match=f"holds one {kind.upper()} file.*found .*e62"):
        load(copied)


NO_FILES = {
    "a folder": lambda path: path.mkdir(),
    "a named pipe": lambda path: os.mkfifo(path),
    "a link that leads nowhere": lambda path: path.symlink_to("gone"),
    "links in a circle": lambda path: path.symlink_to(path.name),
}


@pytest.mark.parametrize("kind", NO_FILES)
@pytest.mark.parametrize("name", ["e62 (copy).urdf", "e62 (copy).toml", "e62.urdf", "e62.toml"])
def test_what_stands_in_the_place_of_a_file_is_told(copied: Path, name: str, kind: str) -> None:
    """Under the name of the folder or any other; nobody waits for a pipe."""
    (copied / f"e62{name[-5:]}").unlink()
    NO_FILES[kind](copied / name)
    with pytest.raises(ModelError) as caught:
        load(copied)
    evidence = caught.value.evidence
    assert (evidence["key"], evidence["value"]) == (name, kind)
    if name.endswith(".toml") and kind != "a folder":
        with pytest.raises(InputError, match="circle" if "circle" in kind else kind):
            load(copied / name)


def test_names_that_nothing_has() -> None:
    for name in ("a\0b", "x" * 5000, "gone.toml"):
        assert no_file(Path(name)) == ""
        with pytest.raises(UnknownNameError):
            load(name)


@pytest.mark.parametrize("kind", NO_FILES)
def test_tables_and_meshes_that_are_no_files(tmp_path: Path, kind: str) -> None:
    bases = Path(__file__).parent.parent / "fuzz" / "bases"
    parts = Path(shutil.copytree(bases / "parts", tmp_path / "parts"))
    mesh = parts / "meshes" / "tetrahedron.stl"
    mesh.unlink()
    NO_FILES[kind](mesh)
    with pytest.raises(InputError, match=f"tetrahedron.stl is {kind}"):
        load(parts)
    shutil.copy(bases / "parts" / "meshes" / mesh.name, parts / "whole.stl")
    (parts / "parts.urdf").write_text(
        (parts / "parts.urdf").read_text(encoding="utf-8").replace("meshes/tetrahedron", "whole"),
        encoding="utf-8",
    )
    with (parts / "parts.toml").open("a") as stream:
        stream.write('[springs.table]\njoint = "h2"\nfile = "rates.csv"\n')
    NO_FILES[kind](parts / "rates.csv")
    with pytest.raises(InputError, match=f"rates.csv is {kind}"):
        load(parts)


def test_one_of_several_toml_files_is_named(copied: Path) -> None:
    text = (copied / "e62.toml").read_text(encoding="utf-8")
    (copied / "fast.toml").write_text(text.replace("450.0", "650.0"), encoding="utf-8")
    fast = load(copied / "fast.toml")
    assert (fast.name, fast.cylinder.rated_speed_rpm) == ("fast", 650.0)
    assert load(copied / "e62.toml").name == "e62"


@pytest.mark.parametrize(
    ("file", "old", "new", "message"),
    [
        ("toml", "restitution = 0.2", "restitution = 2.0", r"^e62\.toml: stops\.jaw\.restitution"),
        ("toml", 'joint = "jaw"', 'joint = "jw"', r"^e62\.toml: stops\.jaw\.joint: there is no"),
        ("toml", "format = 1", "format = ", r"^e62\.toml: TOML = "),
        ("urdf", '<mass value="', '<mass value="-', r"^e62\.urdf: link \w+ mass = -"),
        ("urdf", "<robot", "<robt", r"^e62\.urdf: "),
    ],
)
def test_messages_call_files_by_their_names(
    copied: Path, file: str, old: str, new: str, message: str
) -> None:
    path = copied / f"e62.{file}"
    path.write_text(path.read_text(encoding="utf-8").replace(old, new, 1), encoding="utf-8")
    with pytest.raises(InputError, match=message) as caught:
        load(copied)
    named = caught.value.evidence.get("file") or caught.value.evidence["where"]
    assert str(named).startswith(f"e62.{file}")


def test_what_is_no_model(tmp_path: Path) -> None:
    with pytest.raises(UnknownNameError, match="no model or model folder named"):
        load(tmp_path / "nothing")
    with pytest.raises(ModelError, match="found nothing"):
        load(tmp_path)


def test_a_urdf_alone_is_no_model(copied: Path) -> None:
    with pytest.raises(ModelError, match=r"'e62\.urdf' cannot be used: a folder .* TOML file"):
        load(copied / "e62.urdf")


def test_the_urdf_that_counts_is_renamed(copied: Path) -> None:
    """Of several beside a TOML file that was named, the one of its name is taken."""
    (copied / "e62.toml").rename(copied / "fast.toml")
    for name in ("a.urdf", "b.urdf"):
        shutil.copy(copied / "e62.urdf", copied / name)
    (copied / "e62.urdf").unlink()
    told = r"one called fast\.urdf; found several; rename the one that counts: a\.urdf, b\.urdf"
    with pytest.raises(ModelError, match=told):
        load(copied / "fast.toml")
    (copied / "b.urdf").rename(copied / "fast.urdf")
    assert load(copied / "fast.toml").name == "fast"


def test_new_folders(tmp_path: Path) -> None:
    """Whole or not at all; what is there stays, and nothing is left behind."""
    target = tmp_path / "deep" / "model"
    with new_folder(target) as partial:
        assert partial.name == "model"
        # Renaming is one step within one file system only.
        assert target.parent in partial.parents
        (partial / "file").write_text("x", encoding="utf-8")
        assert not target.exists()
    assert (target / "file").read_text(encoding="utf-8") == "x"
    assert [item.name for item in target.parent.iterdir()] == ["model"]
    with pytest.raises(InputError, match="is there already and is not empty") as caught:
        check_new_folder(target)
    assert caught.value.evidence == {"folder": str(target)}
    with pytest.raises(InputError, match="is there already"):
        check_new_folder(target / "file")
    (tmp_path / "empty").mkdir()
    assert check_new_folder(tmp_path / "empty") == (tmp_path / "empty").resolve()
    message = "stop"

    def fails() -> None:
        with new_folder(tmp_path / "other") as partial:
            (partial / "file").write_text("x", encoding="utf-8")
            raise RuntimeError(message)

    with pytest.raises(RuntimeError, match=message):
        fails()
    assert not (tmp_path / "other").exists()
    with (
        pytest.raises(InputError, match=r"cannot be made: .* is not a folder") as caught,
        new_folder(target / "file" / "below"),
    ):
        pass
    assert caught.value.evidence == {"folder": str(target / "file" / "below")}


@pytest.fixture
def shut() -> Iterator[Path]:
    """A folder in which nothing may be made, for root as well: it gives up its powers meanwhile."""
    with tempfile.TemporaryDirectory() as name:
        home = Path(name, "shut")
        (home / "closed").mkdir(parents=True)
        modes = {Path(name): 0o755, home / "closed": 0o000, home: 0o555}
        for path, mode in modes.items():
            path.chmod(mode)
        user = os.geteuid()
        if user == 0:
            os.seteuid(65534)
        yield home
        os.seteuid(user)
        for path in (home, home / "closed"):
            path.chmod(0o700)
        assert [item.name for item in home.rglob("*")] == ["closed"]


@pytest.mark.parametrize("name", ["model", "deep/model", "closed", "closed/model"])
def test_folders_that_may_not_be_written(name: str, shut: Path) -> None:
    """Refused with the folder, and nothing is left of them."""
    target = shut / name
    with pytest.raises(InputError, match="Permission denied") as caught, new_folder(target):
        pass
    assert caught.value.evidence == {"folder": str(target)}
