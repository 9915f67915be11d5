"""Every number of every model that comes along has a path, and a path leads to one number alone."""

from __future__ import annotations

import math
import re
import tomllib
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import msgspec
import numpy as np
import pytest

from nipper_pin import (
    Case,
    InputError,
    Mechanism,
    ModelError,
    Window,
    changed,
    load,
    simulate,
)
from nipper_pin.mechanism import known_models, need_as_written, number_of, numbers_of
from nipper_pin.mechanism.drives import Table
from nipper_pin.mechanism.edit import (
    apply_overrides,
    number_at,
    read_dimension,
    read_layout,
    with_tables,
)
from nipper_pin.mechanism.edit.paths import number_from
from nipper_pin.mechanism.files import parse_xml
from nipper_pin.mechanism.files.describe import describe
from nipper_pin.written_units import unit_of_key
from tests.refusals.bases import model, right

MODELS = {
    **known_models(),
    **{
        folder.name: folder
        for folder in sorted((Path(__file__).parents[2] / "models" / "benchmarks").iterdir())
    },
}

# Known as texts alone: their joints move in no plane.
SPATIAL = {"bricard"}

PLACES = ("xyz", "rpy")

LID = 'springs.lid = { joint = "pivot", file = "lid.csv" }'

TURNS = b"coordinate_deg,torque_N_m\n-10,4.0\n0,4.7\n20,7.0\n60,11.0\n"


def with_csv_tables(folder: Path) -> Path:
    """A model folder whose drive and both kinds of springs come from CSV files."""
    home = model("small with rows", [LID], folder)
    (home / "lid.csv").write_bytes(TURNS)
    return home


@pytest.fixture(params=[*MODELS, "small"])
def texts(request: pytest.FixtureRequest, tmp_path: Path) -> tuple[dict[str, Any], str]:
    """The two texts of a model as they stand in its files, tables written out."""
    name: str = request.param
    folder = with_csv_tables(tmp_path) if name == "small" else MODELS[name]
    data = tomllib.loads((folder / f"{name}.toml").read_text(encoding="utf-8"))
    document, left = with_tables(data, {}, folder, "model.toml")
    assert left == {}
    return document, (folder / f"{name}.urdf").read_text(encoding="utf-8")


def document_numbers(value: object, path: str = "") -> Iterator[tuple[str, float]]:
    """Numbers of a TOML document, found without the paths' own code."""
    if isinstance(value, dict):
        for key, item in value.items():
            yield from document_numbers(item, f"{path}.{key}".lstrip("."))
    elif isinstance(value, list | tuple):
        for place, item in enumerate(value):
            yield from document_numbers(item, f"{path}[{place}]")
    elif isinstance(value, int | float) and not isinstance(value, bool):
        yield path, value


def urdf_numbers(element: ElementTree.Element, path: str = "urdf") -> Iterator[tuple[str, float]]:
    """Numbers of a URDF, found without the paths' own code."""
    for key, text in element.attrib.items():
        parts = text.split()
        try:
            values = [float(part) for part in parts]
        except ValueError:
            continue
        for place, value in enumerate(values):
            end = f".{key[place]}" if key in PLACES else f"[{place}]"
            yield f"{path}.{key}{end if len(values) > 1 else ''}", value
    kinds = [item.tag for item in element]
    for place, item in enumerate(element):
        name = item.get("name")
        same = kinds[:place].count(item.tag)
        step = f".{name}" if name is not None else f"[{same}]"
        several = name is not None or kinds.count(item.tag) > 1
        yield from urdf_numbers(item, f"{path}.{item.tag}{step if several else ''}")


def unwritten_numbers(document: dict[str, Any]) -> set[str]:
    """Numbers of drives and stops that the description has and the file leaves out."""
    typed = describe(document, "model.toml")
    found = set()
    for section in ("drives", "stops"):
        for name, entry in getattr(typed, section).items():
            for field in msgspec.structs.fields(entry):
                number = "float" in str(field.type) and "tuple" not in str(field.type)
                if number and field.name not in document[section][name]:
                    found.add(f"{section}.{name}.{field.name}")
    return found


def own_values(numbers: Mapping[str, float]) -> dict[str, float]:
    return {path: value + 0.25 + place for place, (path, value) in enumerate(numbers.items())}


def test_every_number_of_document_and_urdf(texts: tuple[dict[str, Any], str]) -> None:
    """Each gets a value of its own, all at once: no path leads nowhere, and none to another's.

    Two paths that led to one number, or one that led to its neighbour, would leave a value in the
    wrong place; the walk that finds the numbers again shares no code with the paths.
    """
    document, urdf = texts
    found, drawn = (
        dict(document_numbers(document)),
        dict(urdf_numbers(ElementTree.fromstring(urdf))),
    )
    assert len(drawn) > 10
    assert all(number_at(document, path, "model.toml") == found[path] for path in found)
    wanted, moved = own_values(found), own_values(drawn)
    new, same = apply_overrides(document, urdf, wanted, "model")
    assert (dict(document_numbers(new)), same) == (wanted, urdf)
    assert dict(document_numbers(document)) == found
    new, written = apply_overrides(document, urdf, moved, "model")
    assert dict(urdf_numbers(ElementTree.fromstring(written))) == moved
    assert new == document


def test_every_number_with_the_unit_of_its_key(texts: tuple[dict[str, Any], str]) -> None:
    """Written with the unit that its key names it is the same number; most have one."""
    document, _ = texts
    found = dict(document_numbers(document))
    units = {path: unit_of_key(path.partition("[")[0].rpartition(".")[2]) for path in found}
    assert any(units.values())
    for path, value in found.items():
        assert number_from(f"{value!r} {units[path]}", path, "model.toml") == value, path


def test_every_number_that_need_not_be_written(texts: tuple[dict[str, Any], str]) -> None:
    """Offsets, means and places of stops that a file leaves out are zero until a path says more."""
    document, urdf = texts
    paths = unwritten_numbers(document)
    assert all(number_at(document, path, "model.toml") == 0.0 for path in paths)
    wanted = {path: 0.5 + place for place, path in enumerate(sorted(paths))}
    written, _ = apply_overrides(document, urdf, wanted, "model")
    before = dict(document_numbers(document))
    assert dict(document_numbers(written)) == {**before, **wanted}
    # They are what the description reads, not keys that it would refuse.
    describe(written, "model.toml")


def test_placements_that_need_not_be_written(texts: tuple[dict[str, Any], str]) -> None:
    """What has no origin stands at zero, and can be moved from there."""
    document, urdf = texts
    root = ElementTree.fromstring(urdf)
    for parent in list(root.iter()):
        for origin in parent.findall("origin"):
            parent.remove(origin)
    bare = ElementTree.tostring(root, encoding="unicode")
    joint = root.findall("joint")[0].get("name")
    for key, axis in (("xyz", "z"), ("rpy", "p")):
        path = f"urdf.joint.{joint}.origin.{key}.{axis}"
        layout = read_layout(parse_xml(bare, "model.urdf"), document, "model.urdf")
        assert read_dimension(layout, path) == 0.0
        _, written = apply_overrides(document, bare, {path: 0.3}, "model")
        added = set(urdf_numbers(ElementTree.fromstring(written))) - set(urdf_numbers(root))
        assert (path, 0.3) in added
        assert all(value == 0.0 for other, value in added if other != path)


def test_an_inertia_that_need_not_be_written(texts: tuple[dict[str, Any], str]) -> None:
    """Parts of a tensor that a URDF leaves out are zero, and can be changed from there."""
    document, urdf = texts
    root = ElementTree.fromstring(urdf)
    (name, *_) = (item.get("name") for item in root.findall("link[inertial]"))
    for tensor in root.iter("inertia"):
        tensor.attrib.clear()
    bare, path = ElementTree.tostring(root, encoding="unicode"), f"links.{name}.inertia_kg_m2"
    _, written = apply_overrides(document, bare, {path: 0.3}, "model")
    for text, value in ((bare, 0.0), (written, 0.3)):
        layout = read_layout(parse_xml(text, "model.urdf"), document, "model.urdf")
        assert read_dimension(layout, path) == value


def test_every_mass_and_dimension(texts: tuple[dict[str, Any], str]) -> None:
    """Masses, inertias, centres and pins: what is written is read back, and the rest stays.

    The values are those of the machine a little written, so every one of them is possible.
    """
    document, urdf = texts
    layout = read_layout(parse_xml(urdf, "model.urdf"), document, "model.urdf")
    links = [item.get("name") for item in layout.root.findall("link[inertial]")]
    paths = [
        f"links.{name}.{key}"
        for name in links
        for key in ("mass_kg", "inertia_kg_m2", "com_x_mm", "com_z_mm")
    ]
    pins = {frozenset(meeting): min(meeting) for meeting in layout.meeting.values()}
    paths += [f"points.{name}.{key}" for name in pins.values() for key in ("x_mm", "z_mm")]
    assert paths
    # Pins carry centres of mass along, so links are written by themselves.
    for head in ("links", "points"):
        chosen = [path for path in paths if path.startswith(head)]
        own = {path: read_dimension(layout, path) for path in chosen}
        wanted = {
            path: 1.01 * value + 1e-3 * (1.0 + i) for i, (path, value) in enumerate(own.items())
        }
        new, written = apply_overrides(document, urdf, wanted, "model")
        after = read_layout(parse_xml(written, "model.urdf"), new, "model.urdf")
        for path, value in wanted.items():
            assert read_dimension(after, path) == pytest.approx(value, rel=1e-12)


# A mass on a frame that is fixed beside its link.
WELDED = Path(__file__).parents[1] / "strangers" / "tiny_frame_mass"


@pytest.mark.parametrize(
    "place",
    [*(MODELS[name] for name in sorted({*MODELS} - SPATIAL)), WELDED],
    ids=lambda place: Path(place).name,
)
def test_numbers_of_forces_impacts_and_masses(place: str | Path) -> None:
    """Each by itself, all at once, and one after another: machines as their texts make them."""
    own = load(place)
    assert "<robot" in own.urdf
    found = dict(document_numbers(own.description))
    wanted = {
        path: 0.5 * value
        for path, value in found.items()
        if path.split(".")[0] in ("springs", "dampers") or path.endswith(".restitution")
    }
    masses = {f"links.{link}.mass_kg": 1.1 * one.mass for link, one in own.inertias.items()}
    wanted |= masses
    rows = [path for path in wanted if "[" in path]
    for values in [{path: value} for path, value in wanted.items() if path not in rows] + [wanted]:
        other = changed(own, values)
        need_as_written(other)
        assert numbers_of(other, values) == tuple(values.values())
        if not {*values} & {*rows, *masses} and not any(stop.leader for stop in own.stops):
            assert other.model is own.model
    for path, value in masses.items():
        other = changed(other, {path: 1.2 * value})
    need_as_written(other)
    need_as_written(own)
    assert dict(document_numbers(own.description)) == found


@pytest.mark.parametrize(
    "path",
    ["springs.steeve.stiffness_N_per_m", "stops.jaw.restitution", "links.top_nipper.mass_kg"],
)
@pytest.mark.parametrize("value", [-1.0, math.inf, 1e16, "x", True, [1.0], None])
def test_changed_numbers_are_refused_as_those_of_a_file(
    e62: Mechanism, path: str, value: Any
) -> None:
    with pytest.raises(ModelError) as of_a_file:
        load("e62", {path: value})
    with pytest.raises(ModelError) as of_a_machine:
        changed(e62, {path: value})
    assert of_a_machine.value.message == of_a_file.value.message


def test_runs_of_a_changed_machine(e62: Mechanism) -> None:
    """On the tree of one that has run already: bit for bit those of a machine loaded so."""
    simulate(e62, Case(speed_rpm=650.0))
    values = {
        "stiffness": 11000.0,
        "preload": 9.0,
        "restitution": 0.1,
        "links.top_nipper.mass_kg": 1.3,
    }
    one, other = changed(e62, values), load("e62", values)
    for case in (Case(speed_rpm=650.0), Case(speed_rpm=500.0, window=Window.CYCLE)):
        events, expected = (simulate(machine, case).events for machine in (one, other))
        assert len(events) == len(expected) > 5
        for found, wanted in zip(events, expected, strict=True):
            assert found.t == wanted.t
            np.testing.assert_array_equal(found.q, wanted.q)
            np.testing.assert_array_equal(found.v_after, wanted.v_after)


def test_no_number_may_be_none(e62: Mechanism) -> None:
    for path, _ in document_numbers(e62.description):
        if "phases" in path or path in ("format", "initial_phase", "degrees_of_freedom"):
            continue
        with pytest.raises(InputError, match="a finite number"):
            load("e62", {path: math.nan})


@pytest.mark.parametrize("name", known_models())
def test_provenance_covers_every_number(name: str) -> None:
    """And nothing else; all of them are estimates, as the title says."""
    mechanism = load(name)
    told = mechanism.provenance
    found = dict(document_numbers(mechanism.description))
    assert len(found) > 15
    for path in found:
        assert any(path == key or path.startswith((f"{key}.", f"{key}[")) for key in told), path
    groups = {key for key in told if key.startswith("urdf.")}
    written = {f"urdf.{group}" for group in ("points", "links", "limits", "collision_shapes")}
    assert groups - {"urdf.visuals"} == written
    for key in told.keys() - groups:
        if not any(path.startswith(key) for path in found):
            assert math.isfinite(number_of(mechanism, key)), key
    assert "estimate" in mechanism.title
    assert re.search(r"not the maker's|no maker's|not a maker's", mechanism.title)
    assert re.search("estimate|identified", " ".join(told.values()))


def drive_table(mechanism: Mechanism) -> tuple[list[float], list[float]]:
    law = mechanism.drives[0].law
    assert isinstance(law, Table)
    return list(law.cylinder_angle_rad), list(law.coordinate)


def test_rows_of_csv_tables_reach_the_machine(tmp_path: Path) -> None:
    """A row that a CSV file holds changes the law and the force at that row, and nothing else."""
    folder = with_csv_tables(tmp_path)
    own = load(folder)
    new = load(
        folder,
        {
            "drives.x.coordinate_rad[3]": "0.25",
            "drives.x.cylinder_angle_deg[4]": 181.0,
            "springs.lid.torque_N_m[2]": np.float64(8.0),
            "springs.coil.force_N[0]": 1,
            "springs.coil.coordinate_mm[2]": 41.0,
        },
    )
    angles, values = drive_table(own)
    angles[4], values[3] = math.radians(181.0), 0.25
    assert drive_table(new) == (angles, values)
    psi = np.array([math.radians(135.0)])
    # The spline passes through its rows, to the round-off of its solution.
    assert new.drives[0].law.evaluate(psi)[0][0] == pytest.approx(0.25, abs=1e-14)
    before, after = ({item.name: item.characteristic for item in machine.tabulated_springs}
                     for machine in (own, new))  # fmt: skip
    assert after["lid"].force == (4.0, 4.7, 8.0, 11.0)
    assert after["lid"].coordinate == before["lid"].coordinate
    assert after["coil"].force == (1.0, 100.0, 130.0)
    assert after["coil"].coordinate == pytest.approx((0.0, 2e-3, 41e-3))


@pytest.mark.parametrize("place", [0, 7])
def test_a_drive_table_stays_a_turn(tmp_path: Path, place: int) -> None:
    """Its first and last row are one: whichever is changed, the other one follows.

    Left behind, it would make a table that the loader refuses, so no end could be varied alone.
    """
    angle = 2.0 + 360.0 * (place > 0)
    changes = {f"drives.x.coordinate_rad[{place}]": 0.05,
               f"drives.x.cylinder_angle_deg[{place}]": angle}  # fmt: skip
    angles, values = drive_table(load(with_csv_tables(tmp_path), changes))
    assert (values[0], values[-1]) == (0.05, 0.05)
    assert np.degrees([angles[0], angles[-1]]) == pytest.approx([2.0, 362.0], abs=1e-12)


def test_another_csv_file_counts_before_its_rows(tmp_path: Path) -> None:
    folder = with_csv_tables(tmp_path)
    (folder / "stiff.csv").write_text(right("coil.csv").replace("130.0", "160.0"))
    changes = {"springs.coil.force_N[1]": 3.0, "springs.coil.file": "stiff.csv"}
    found = {item.name: item for item in load(folder, changes).tabulated_springs}
    assert found["coil"].characteristic.force == (90.0, 3.0, 160.0)
