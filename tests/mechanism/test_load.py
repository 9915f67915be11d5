"""Loading by name, by folder and from plain data: files that are a model, and overrides."""

from __future__ import annotations

import math
import shutil
import tomllib
from pathlib import Path

import numpy as np
import pytest

from nipper_pin import InputError, ModelError, UnknownNameError, load
from nipper_pin.mechanism import find_model
from nipper_pin.mechanism.files import toml
from nipper_pin.mechanism.model_files import check_new_folder, new_folder
from nipper_pin.texts import no_file


def test_index_scale() -> None:
    mechanism = load()
    cylinder = mechanism.cylinder
    assert cylinder.sense == -1
    assert cylinder.index_from_angle(cylinder.angle_at_touch_rad) == pytest.approx(34.05, abs=0.01)
    assert cylinder.index_from_angle(cylinder.reference_angle_rad) == pytest.approx(24.0)
    # Foremost at 24: there the pendulum shaft is furthest clockwise.
    angles = np.linspace(0.0, math.tau, 4001)
    lowest = angles[np.argmin(mechanism.drives[0].law.evaluate(angles)[0])]
    assert cylinder.index_from_angle(float(lowest)) == pytest.approx(24.0, abs=0.01)
    touch = np.array([cylinder.angle_at_touch_rad])
    for drive in mechanism.drives:
        assert drive.law.evaluate(touch)[0][0] - drive.law_at_touch == 0.0


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
    for occupied in (target, target / "file"):
        with pytest.raises(InputError, match="is there already and is not empty") as caught:
            check_new_folder(occupied)
        assert caught.value.evidence == {"folder": str(occupied)}
    (tmp_path / "empty").mkdir()
    assert check_new_folder(tmp_path / "empty") == (tmp_path / "empty").resolve()

    def fails(error: Exception) -> None:
        with new_folder(tmp_path / "other") as partial:
            (partial / "file").write_text("x", encoding="utf-8")
            raise error

    with pytest.raises(ZeroDivisionError):
        fails(ZeroDivisionError())
    with pytest.raises(InputError, match="No space left on device"):
        fails(OSError(28, "No space left on device"))
    assert sorted(item.name for item in tmp_path.iterdir()) == ["deep", "empty"]


@pytest.mark.parametrize(
    "name", ["file/below", "file/deep/below", "/proc/model", "/proc/deep/model", "x" * 300]
)
def test_folders_that_cannot_be_made(name: str, tmp_path: Path) -> None:
    """Nor by root; refused with the folder, and nothing is left of them."""
    (tmp_path / "file").write_text("x", encoding="utf-8")
    target = tmp_path / name
    with pytest.raises(InputError, match="cannot be") as caught, new_folder(target):
        pass
    assert caught.value.evidence == {"folder": str(target)}
    assert [item.name for item in tmp_path.iterdir()] == ["file"]


def test_any_plain_document_reads_back() -> None:
    """Both truth values, quotes, strokes and line breaks, odd keys, lists and tables in lists."""
    document = {
        "yes": True, "no": False, "text": 'a "b" \\ c\nd', "list": [1, 2.5, [True, "x"]],
        "a key": {"x.y": 1, "deep": {"er": [{"n": 1}, {"n": 2, "in": {"m": False}}]}}, "last": {},
    }  # fmt: skip
    assert tomllib.loads(toml(document)) == document
