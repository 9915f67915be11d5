"""The gallery: every machine is read, is complete and runs."""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree

import pytest

from nipper_pin import Case, Outcome, Window, check, export, load, simulate
from nipper_pin.cli import main
from nipper_pin.mechanism import number_of
from nipper_pin.mechanism.gallery import GALLERY, drawn
from nipper_pin.study.next_steps import next_steps

# Stops that throw back what strikes them, and never hold it.
RATTLING = ("sieve", "bell", "piano_key")


def test_there_are_forty_and_all_have_their_names() -> None:
    assert len(GALLERY) >= 40
    assert all(drawn(name).name == name for name in GALLERY)
    assert len({drawn(name).tables["title"] for name in GALLERY}) == len(GALLERY)


@pytest.mark.parametrize("name", GALLERY)
def test_a_machine_is_complete_and_runs_a_turn(name: str) -> None:
    """Nothing is missing, a stop is struck and left again in the turn, and the run ends well."""
    mechanism = drawn(name).mechanism()
    report = check(mechanism)
    steps = next_steps(report, name)
    missing = [step for step in steps.missing if step.startswith("Missing")]
    if name in RATTLING:
        missing = [step for step in missing if "does not open again" not in step]
    assert not missing
    assert report.outcome in (Outcome.COMPLETED.value, Outcome.STILL_BOUNCING.value)


def test_the_pages_show_every_machine() -> None:
    docs = Path(__file__).parents[2] / "docs"
    text = (docs / "gallery.md").read_text(encoding="utf-8")
    for front in (text, (docs / "models.md").read_text(encoding="utf-8")):
        assert f"{len(GALLERY)} textbook linkages" in front
    for name in GALLERY:
        assert text.count(f"[{name}](#{name})") == 1
        shown = f"### {name}\n\n![{name}](images/gallery/{name}.svg)\n\n"
        title = drawn(name).tables["title"]
        assert f"{shown}{title[0].upper()}{title[1:]}." in text
        picture = ElementTree.parse(docs / "images" / "gallery" / f"{name}.svg")
        assert len(picture.findall(".//{*}path")) > 8
    assert len(list((docs / "images" / "gallery").iterdir())) == len(GALLERY)


def test_the_drawing_of_the_page_runs(tmp_path: Path) -> None:
    page = (Path(__file__).parents[2] / "docs" / "models.md").read_text(encoding="utf-8")
    file = tmp_path / "press.toml"
    file.write_text(page.partition("```toml\n")[2].partition("```")[0], encoding="utf-8")
    solution = simulate(load(file), Case(speed_rpm=120.0, window=Window.CYCLE))
    assert {stop for event in solution.events for stop in event.stops} == {"height", "rod"}


@pytest.mark.usefixtures("here")
def test_commands_write_a_machine(capsys: pytest.CaptureFixture[str]) -> None:
    """As the drawing, and as URDF and TOML, with another number if one is asked for."""
    assert main(["new", "--from", "watt_1", "mine"]) == 0
    assert main(["export", "mine", "whole"]) == 0
    machine = drawn("watt_1").mechanism()
    for folder, files in (
        ("mine", {"mine.toml", "drawing.schema.json"}),
        ("whole", {"whole.toml", "whole.urdf", "model.schema.json"}),
    ):
        assert {item.name for item in Path(folder).iterdir()} == files
        assert load(folder).description == machine.description
        assert load(folder).model.inertias.tolist() == machine.model.inertias.tolist()
    assert main(["export", "mine", "heavier", "--set", "links.coupler.mass_kg=0.4"]) == 0
    assert number_of(load("heavier"), "links.coupler.mass_kg") == 0.4
    assert main(["new", "--from", "wat_1", "other"]) == 2
    assert "no machine of the gallery named 'wat_1'" in capsys.readouterr().err
    assert not Path("other").exists()


@pytest.mark.usefixtures("here")
def test_meshes_go_with_an_exported_model() -> None:
    """All of them, for a run of the copy; what the comments told of other numbers does not."""
    assert main(["export", "e62", "mine", "--set", "preload=9.5"]) == 0
    meshes = {path.name for path in Path("mine", "meshes").iterdir()}
    assert meshes == {path.name for path in Path(load("e62").mesh_folder, "meshes").iterdir()}
    assert load("mine").springs[0].preload == 0.0095
    assert "<!--" not in Path("mine", "mine.urdf").read_text(encoding="utf-8")


@pytest.mark.campaign
@pytest.mark.parametrize("drive", ["held", "inertial"])
@pytest.mark.parametrize("share", [0.5, 1.0, 2.0])
@pytest.mark.parametrize("name", GALLERY)
def test_a_machine_runs_at_three_speeds(
    name: str, share: float, drive: str, tmp_path: Path
) -> None:
    mechanism = load(export(drawn(name).mechanism(), tmp_path / name))
    speed = share * mechanism.cylinder.rated_speed_rpm
    solution = simulate(
        mechanism, Case(speed_rpm=speed, window=Window.CYCLE, cycles=2, drive=drive)
    )
    assert solution.outcome in (Outcome.COMPLETED, Outcome.STILL_BOUNCING)
