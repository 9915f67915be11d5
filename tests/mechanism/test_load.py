"""Loading by name, by folder and from plain data: files that are a model, and overrides."""

from __future__ import annotations

import shutil
import tomllib
from pathlib import Path

import numpy as np
import pytest

from nipper_pin import InputError, ModelError, UnknownNameError, load
from nipper_pin.mechanism import find_model
from nipper_pin.mechanism.files import toml
from nipper_pin.texts import no_file


def test_overrides_of_the_document() -> None:
    """Texts of a command, lists, and what numpy made; the description holds plain Python."""
    mechanism = load(
        overrides={
            "stops.jaw.restitution": np.float64(0.05),
            "springs.steeve.stiffness_N_per_m": np.int64(11000),
            "drives.pendulum.crank_axis_mm[0]": "0.5",
            "drives.pendulum.guide_axis_mm": "[-190, -20.0]",
            "title": "another",
            "initial_phase": "2",
        }
    )
    assert mechanism.stop("jaw").restitution == 0.05
    assert mechanism.springs[0].stiffness == 11000.0
    assert (mechanism.title, mechanism.initial_phase) == ("another", 2)
    drive = mechanism.description["drives"]["pendulum"]  # type: ignore[index]
    assert drive["crank_axis_mm"] == [0.5, 0.0]
    assert drive["guide_axis_mm"] == [-190, -20.0]
    assert type(mechanism.description["stops"]["jaw"]["restitution"]) is float  # type: ignore[index]
    assert load().stop("jaw").restitution == 0.2
    assert set(mechanism.shortcuts) == {"restitution", "stiffness", "preload"}
    for path in mechanism.shortcuts.values():
        load(overrides={path: "0.5"})


E62 = find_model("e62")


@pytest.fixture
def copied(tmp_path: Path) -> Path:
    """A copy of a model's folder, which has another name."""
    return Path(shutil.copytree(E62, tmp_path / "e62 (copy)"))


def test_a_copied_folder_is_a_model_of_its_own_name(copied: Path) -> None:
    """Or of that of a TOML file in it; files with the name of the folder come before others."""
    mechanism = load(copied)
    assert mechanism.name == "e62 (copy)"
    assert mechanism.urdf == load("e62").urdf
    assert mechanism.mesh_folder == str(copied)
    assert find_model(copied) == copied
    with pytest.raises(ModelError, match=r"'e62\.urdf' cannot be used: a folder .* TOML file"):
        load(copied / "e62.urdf")
    text = (copied / "e62.toml").read_text(encoding="utf-8")
    (copied / "fast.toml").write_text(text.replace("450.0", "650.0"), encoding="utf-8")
    fast = load(copied / "fast.toml")
    assert (fast.name, fast.cylinder.rated_speed_rpm) == ("fast", 650.0)
    assert load(copied / "e62.toml").name == "e62"
    for kind in ("urdf", "toml"):
        shutil.copy(copied / f"e62.{kind}", copied / f"{copied.name}.{kind}")
        (copied / f"e62.{kind}").write_text("", encoding="utf-8")
    assert load(copied).name == copied.name


@pytest.mark.parametrize(("urdf", "toml"), [("robot.urdf", "stops.toml"), ("A.URDF", "b.TOML")])
def test_any_names_of_two_files(copied: Path, urdf: str, toml: str) -> None:
    (copied / "e62.urdf").rename(copied / urdf)
    (copied / "e62.toml").rename(copied / toml)
    (copied / "._e62.toml").write_text("what another system leaves behind", encoding="utf-8")
    assert load(str(copied)).name == "e62 (copy)"


@pytest.mark.parametrize("kind", ["urdf", "toml"])
def test_one_file_of_a_kind_is_a_model(copied: Path, kind: str) -> None:
    shutil.copy(copied / f"e62.{kind}", copied / f"other.{kind}")
    with pytest.raises(ModelError, match=rf"several.*: e62\.{kind}, other\.{kind}$"):
        load(copied)
    for name in ("e62", "other"):
        (copied / f"{name}.{kind}").unlink()
    with pytest.raises(ModelError, match=f"holds one {kind.upper()} file.*found .*e62"):
        load(copied)


def test_names_that_nothing_has(tmp_path: Path) -> None:
    for name in ("a\0b", "x" * 5000, "gone.toml"):
        assert no_file(Path(name)) == ""
        with pytest.raises(UnknownNameError):
            load(name)
    with pytest.raises(UnknownNameError, match="no model or model folder named"):
        load(tmp_path / "nothing")
    with pytest.raises(ModelError, match="found nothing"):
        load(tmp_path)


@pytest.mark.parametrize(
    ("file", "old", "new"),
    [("toml", "restitution = 0.2", "restitution = 2.0"), ("toml", 'joint = "jaw"', 'joint = "jw"'),
     ("toml", "format = 1", "format = "), ("urdf", '<mass value="', '<mass value="-'),
     ("urdf", "<robot", "<robt")],
)  # fmt: skip
def test_messages_call_files_by_their_names(copied: Path, file: str, old: str, new: str) -> None:
    """Not by that of the folder."""
    path = copied / f"e62.{file}"
    path.write_text(path.read_text(encoding="utf-8").replace(old, new, 1), encoding="utf-8")
    with pytest.raises(InputError, match=rf"^e62\.{file}: ") as caught:
        load(copied)
    named = caught.value.evidence.get("file") or caught.value.evidence["where"]
    assert str(named).startswith(f"e62.{file}")


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


def test_any_plain_document_reads_back() -> None:
    """Both truth values, quotes, strokes and line breaks, odd keys, lists and tables in lists."""
    document = {
        "yes": True, "no": False, "text": 'a "b" \\ c\nd', "list": [1, 2.5, [True, "x"]],
        "a key": {"x.y": 1, "deep": {"er": [{"n": 1}, {"n": 2, "in": {"m": False}}]}}, "last": {},
    }  # fmt: skip
    assert tomllib.loads(toml(document)) == document
