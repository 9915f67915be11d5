"""Which files of a folder are a model, and how messages call them."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from nipper_pin import InputError, ModelError, UnknownNameError, load
from nipper_pin.mechanism import find_model

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
