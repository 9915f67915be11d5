"""Saved runs and cases: every bit comes back, damage is named, nothing else is read or executed."""

from __future__ import annotations

import dataclasses
import io
import json
import shutil
import tracemalloc
import zipfile
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import nipper_pin
import nipper_pin as nip
from nipper_pin.cli import main
from nipper_pin.hybrid.files import archive as packed
from nipper_pin.hybrid.files import npz as storage
from nipper_pin.mechanism import changed, find_model

RUNS = {
    "transition": nip.Case(speed_rpm=650.0),
    "inertial": nip.Case(speed_rpm=450.0, drive=nip.DriveMode.INERTIAL, rest_rate=0.02),
    "turns": nip.Case(speed_rpm=650.0, window=nip.Window.CYCLE, cycles=4, start_index=23.0),
}

Document = dict[str, Any]


@pytest.fixture(scope="module", params=RUNS)
def solution(request: pytest.FixtureRequest) -> nip.Solution:
    """Runs of every kind, with overrides that the stored model has to carry."""
    overrides = {"stops.jaw.restitution": 0.3, "links.top_nipper.mass_kg": 1.3}
    return nip.simulate(nip.load("e62", overrides), RUNS[request.param])


@pytest.fixture(scope="module")
def copy(solution: nip.Solution, tmp_path_factory: pytest.TempPathFactory) -> nip.Solution:
    """The solution after a way over the disk."""
    return nip.load_solution(nip.save(solution, tmp_path_factory.mktemp("saved") / "run.npz"))


@pytest.fixture(scope="module")
def short(e62: nip.Mechanism) -> nip.Solution:
    return nip.simulate(e62, nip.Case(speed_rpm=650.0, max_collisions=2))


@pytest.fixture
def stored(short: nip.Solution, tmp_path: Path) -> Path:
    return nip.save(short, tmp_path / "run")


@pytest.fixture
def case_file(e62: nip.Mechanism, tmp_path: Path) -> Path:
    return nip.save_case(e62, nip.Case(speed_rpm=650.0), tmp_path / "case.json")


def _bits(value: Any) -> Any:
    """A value of dataclasses, containers and arrays as types, names and bytes."""
    kind = type(value)
    if dataclasses.is_dataclass(value):
        fields = (field.name for field in dataclasses.fields(value) if field.compare)
        value = {name: getattr(value, name) for name in fields}
    elif isinstance(value, np.ndarray):
        return value.dtype, value.shape, value.tobytes()
    if isinstance(value, dict):
        return kind, [(key, _bits(item)) for key, item in value.items()]
    if isinstance(value, tuple | list):
        return kind, [_bits(item) for item in value]
    return kind, value


def _same(ours: object, theirs: object, names: str) -> None:
    """Compare attributes bit by bit."""
    for name in names.split():
        assert _bits(getattr(ours, name)) == _bits(getattr(theirs, name)), name


# A mechanism follows from its texts, so texts and contact decide.
MODEL = "name urdf description joints stops springs"


def test_all_that_a_solution_holds_comes_back_bit_by_bit(
    solution: nip.Solution, copy: nip.Solution
) -> None:
    """Field by field, in type and bits; the stored model is the changed one."""
    held = "case events segments outcome evaluations wall_s repeated_from"
    _same(copy, solution, held)
    _same(copy.shaft, solution.shaft, "speed_rad_s start_angle_rad")
    _same(copy.mechanism, solution.mechanism, MODEL)
    assert copy.mechanism.stop("jaw").restitution == 0.3
    masses = [inertia.mass for inertia in copy.mechanism.model.inertias]
    assert masses == [inertia.mass for inertia in solution.mechanism.model.inertias]
    assert 1.3 in masses


def test_dense_motion_and_forces_are_the_same_bits(
    solution: nip.Solution, copy: nip.Solution
) -> None:
    """What is computed from a loaded solution equals what is computed from the original."""
    times = np.linspace(*solution.trajectory.span, 211)
    for left in (False, True):
        theirs, ours = (item.trajectory.evaluate(times, left=left) for item in (copy, solution))
        assert _bits(theirs) == _bits(ours)
        theirs, ours = (item.trajectory.reactions(times, left=left) for item in (copy, solution))
        assert _bits(theirs) == _bits(ours)
        _same(theirs, ours, "joints closures")
    _same(copy, solution, "collisions phases transitions checks")
    for one, other in zip(copy.collisions, solution.collisions, strict=True):
        _same(one, other, "rebound_amplitude rebound_time")


def test_saving_again_gives_the_same_content(copy: nip.Solution, tmp_path: Path) -> None:
    """Also under a name without .npz, which gets it; one with dots keeps them."""
    path = nip.save(copy, tmp_path / "a.b")
    assert [path] == list(tmp_path.iterdir()) == [tmp_path / "a.b.npz"]
    _same(nip.load_solution(path), copy, "events segments")


@pytest.mark.parametrize("name", RUNS)
def test_a_case_comes_back_and_repeats_the_run(name: str, tmp_path: Path) -> None:
    """A stored case, with everything away from its defaults, repeats a run bit by bit."""
    case = replace(
        RUNS[name], resolution=nip.Resolution(tolerance=1e-9, flight_nodes=9), max_collisions=77
    )
    mechanism = nip.load("e62", {"stops.steeve.restitution": 0.1 + 0.2})
    read_mechanism, read_case = nip.load_case(
        nip.save_case(mechanism, case, tmp_path / "case.json")
    )
    assert read_case == case
    _same(read_mechanism, mechanism, MODEL)
    _same(nip.simulate(read_mechanism, read_case), nip.simulate(mechanism, case), "events")


def _edit(path: Path, change: Callable[[Document], object]) -> None:
    """Rewrite the document of a stored case, or the one inside a stored solution."""
    if path.suffix == ".json":
        document = json.loads(path.read_text(encoding="utf-8"))
        change(document)
        path.write_text(json.dumps(document), encoding="utf-8")
        return
    with np.load(path, allow_pickle=False) as archive:
        arrays = {key: archive[key] for key in archive.files}
    document = json.loads(str(arrays.pop("document")))
    change(document)
    with path.open("wb") as stream:
        np.savez_compressed(stream, document=np.array(json.dumps(document)), **arrays)


def test_a_truncated_file_is_an_input_error(stored: Path) -> None:
    """Wherever the file was cut off, the message says that it is damaged."""
    content = stored.read_bytes()
    for part in (0.0, 0.01, 0.3, 0.7, 0.99):
        stored.write_bytes(content[: int(part * len(content))])
        with pytest.raises(nip.InputError, match="damaged"):
            nip.load_solution(stored)


def test_flipped_bytes_are_input_errors_or_harmless(stored: Path) -> None:
    """A byte changed anywhere gives an input error, or leaves every number as it was.

    The archive guards contents by checksums; bytes it does not use (times of day) may differ.
    """
    content = stored.read_bytes()
    original = nip.load_solution(stored)
    errors = 0
    for place in np.random.default_rng(3).integers(0, len(content), 150):
        changed = bytearray(content)
        changed[place] ^= 0x55
        stored.write_bytes(changed)
        try:
            read = nip.load_solution(stored)
        except nip.InputError:
            errors += 1
        else:
            _same(read, original, "events segments")
    assert errors > 100


def test_every_bit_of_the_begin_of_an_array(stored: Path) -> None:
    """A flipped one is told of as damage, whatever the begin then looks like."""
    with zipfile.ZipFile(stored) as archive:
        begin = archive.read("events.npy")
    assert begin[:6] == b"\x93NUMPY"
    wrong = []
    for place in range(128):
        for bit in range(8):
            flipped = bytearray(begin)
            flipped[place] ^= 1 << bit
            packing = io.BytesIO()
            with zipfile.ZipFile(packing, "w") as archive:
                archive.writestr("events.npy", bytes(flipped))
            try:
                packed.read_archive(packing)
            except storage._DAMAGE:
                continue
            except Exception as error:
                wrong.append((place, bit, repr(error)))
    assert not wrong


@pytest.mark.parametrize("name", ["panel0", "events"])
def test_an_array_of_other_numbers_is_an_input_error(stored: Path, name: str) -> None:
    """NaN, numbers whose squares overflow, other shapes, and other kinds of numbers."""
    with np.load(stored, allow_pickle=False) as archive:
        arrays = {key: archive[key] for key in archive.files}
    rows = arrays[name]
    for wrong in (np.nan * rows, 1e200 + rows, rows.ravel(), rows[..., :-1], rows.astype("f4")):
        np.savez(stored, **{**arrays, name: wrong})
        with pytest.raises(nip.InputError, match="where numbers"):
            nip.load_solution(stored)


def test_a_case_may_be_edited(case_file: Path) -> None:
    """It is a text that is checked as models are; anything else is refused with its name."""
    _edit(case_file, lambda document: document["case"].update(speed_rpm=600.0))
    assert nip.load_case(case_file)[1] == nip.Case(speed_rpm=600.0)
    _edit(case_file, lambda document: document["case"].update(speed_rpm=-600.0))
    with pytest.raises(nip.InputError, match=r"speed_rpm = -600\.0"):
        nip.load_case(case_file)
    for text in ("", "{}", "[]", "no json", '{"format": 1}', "\x00\xff"):
        case_file.write_text(text, encoding="latin-1")
        with pytest.raises(nip.InputError, match=r"case\.json"):
            nip.load_case(case_file)


@pytest.mark.parametrize("number", [99, 2])
def test_another_format_is_refused_by_number(number: int, stored: Path, case_file: Path) -> None:
    words = f"format {number}, and this version reads format 3; simulate the case again"
    for path, read in ((stored, nip.load_solution), (case_file, nip.load_case)):
        _edit(path, lambda document: document.update(format=number))
        with pytest.raises(nip.InputError, match=words):
            read(path)


@pytest.mark.slow
def test_an_archive_that_would_grow_too_large_is_refused(tmp_path: Path) -> None:
    """A thousand times its size, by its directory; it is refused before it is decompressed."""
    path = tmp_path / "large.npz"
    with (
        zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive,
        archive.open("events.npy", "w", force_zip64=True) as member,
    ):
        np.lib.format.write_array_header_1_0(
            member, {"descr": "<f8", "fortran_order": False, "shape": (2**27 + 1,)}
        )
        for _ in range(128):
            member.write(bytes(2**23))
        member.write(bytes(8))
    assert path.stat().st_size < 2**21
    tracemalloc.start()
    try:
        with pytest.raises(nip.InputError, match=r"1\.07e\+09 bytes.* at most 4\.03e\+08"):
            nip.load_solution(path)
        assert tracemalloc.get_traced_memory()[1] < 2**24
    finally:
        tracemalloc.stop()


@pytest.mark.parametrize("length", [10**15, 10**4, 1])
def test_an_array_is_as_long_as_it_says(tmp_path: Path, length: int) -> None:
    """One that says more is given no memory that its content does not fill."""
    path = tmp_path / "lying.npz"
    with zipfile.ZipFile(path, "w") as archive, archive.open("events.npy", "w") as member:
        np.lib.format.write_array_header_1_0(
            member, {"descr": "<f8", "fortran_order": False, "shape": (length,)}
        )
        member.write(bytes(80))
    with pytest.raises(nip.InputError, match=r"events\.npy is (not what|longer than) it says"):
        nip.load_solution(path)


class _Trap:
    """What would run if a stored file were unpickled."""

    def __reduce__(self) -> tuple[object, tuple[str]]:
        return (pytest.fail, ("a stored file was executed",))


def test_nothing_in_a_file_is_executed(tmp_path: Path) -> None:
    """Pickled objects in place of arrays, or of the whole file, are refused unread."""
    trap = np.array([_Trap()], dtype=object)
    inside = tmp_path / "inside.npz"
    np.savez(inside, document=trap, events=trap, allow_pickle=True)
    whole = tmp_path / "whole.npy"
    np.save(whole, trap, allow_pickle=True)
    for path in (inside, whole):
        with pytest.raises(nip.InputError):
            nip.load_solution(path)


def test_a_solution_holds_no_pickle_and_says_which_version_wrote_it(
    stored: Path, case_file: Path
) -> None:
    """Numbers and texts alone; the version stands in runs and in cases."""
    with np.load(stored, allow_pickle=False) as archive:
        assert {archive[name].dtype.kind for name in archive.files} == {"f", "U"}
        run = json.loads(str(archive["document"]))
    case = json.loads(case_file.read_text(encoding="utf-8"))
    assert run["version"] == case["version"] == nipper_pin.__version__


@pytest.mark.parametrize("existing", [True, False])
def test_nothing_half_written_when_writing_fails(
    short: nip.Solution, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, existing: bool
) -> None:
    """A full disk leaves the old file, or none, and no temporary one."""
    target = tmp_path / "run.npz"
    if existing:
        target.write_bytes(b"the old one")

    def full(stream: io.BufferedWriter, **_: object) -> None:
        stream.write(b"half of it")
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(np, "savez_compressed", full)
    with pytest.raises(nip.InputError, match="No space left on device"):
        nip.save(short, target)
    left = {item.name: item.read_bytes() for item in tmp_path.iterdir()}
    assert left == ({"run.npz": b"the old one"} if existing else {})


@pytest.mark.parametrize("folder", ["nowhere", "a_file"])
def test_a_folder_that_cannot_be_written_is_an_input_error(
    short: nip.Solution, tmp_path: Path, folder: str
) -> None:
    """A missing folder, and a file where a folder should be, are named."""
    (tmp_path / "a_file").write_text("")
    with pytest.raises(nip.InputError, match="cannot be written"):
        nip.save(short, tmp_path / folder / "run.npz")
    with pytest.raises(nip.InputError, match="cannot be written"):
        nip.save_case(short.mechanism, short.case, tmp_path / folder / "case.json")
    assert [item.name for item in tmp_path.iterdir()] == ["a_file"]


@pytest.mark.parametrize("limit", ["MOST_BYTES", "MOST_TEXT", "MOST_ARRAYS"])
def test_what_could_not_be_read_is_not_written(
    limit: str, short: nip.Solution, stored: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """With each limit of a reader lowered below what a short run has."""
    old = stored.read_bytes()
    monkeypatch.setattr(packed, limit, 1)
    with pytest.raises(nip.InputError, match="simulate fewer turns"):
        nip.save(short, stored)
    assert stored.read_bytes() == old
    with pytest.raises(nip.InputError):
        nip.load_solution(stored)


def test_numbers_that_were_changed_are_saved(e62: nip.Mechanism, tmp_path: Path) -> None:
    other = changed(e62, {"stops.jaw.restitution": 0.05, "links.top_nipper.mass_kg": 1.3})
    read, _ = nip.load_case(nip.save_case(other, nip.Case(speed_rpm=650.0), tmp_path / "case.json"))
    assert read.stops == other.stops


SAVED = Path(__file__).parents[1] / "reference/saved"

TIMES = [float.fromhex("0x1.99aad7df37aafp-5"), float.fromhex("0x1.acdcf58a9b63bp-5")]


@pytest.fixture
def machine(tmp_path: Path) -> Path:
    """A folder of ours with a machine whose meshes are its own."""
    folder = tmp_path / "e62"
    shutil.copytree(find_model("e62"), folder)
    return folder


def test_a_mesh_of_the_reader_is_not_read(machine: Path, tmp_path: Path) -> None:
    """A file that names another folder, or another file of the same one."""
    private = tmp_path / "private"
    private.mkdir()
    shutil.copy(machine / "meshes/spring.stl", private / "secret.stl")
    case = nip.save_case(nip.load(machine), nip.Case(speed_rpm=650.0), tmp_path / "case.json")
    nip.load_case(case)

    def another(document: dict[str, Any]) -> None:
        source = document["mechanism"]
        source["folder"] = str(private)
        source["urdf"] = source["urdf"].replace("meshes/rockers.stl", "secret.stl")

    _edit(case, another)
    with pytest.raises(nip.NipperError, match=r"secret\.stl in .* is not the mesh"):
        nip.load_case(case)


def test_a_mesh_that_has_changed_is_not_shown(
    machine: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    run = nip.save(nip.simulate(nip.load(machine), nip.Case(speed_rpm=650.0)), tmp_path / "run.npz")
    assert nip.load_solution(run).mechanism.mesh_folder == str(machine)
    with (machine / "meshes/spring.stl").open("ab") as stream:
        stream.write(b"\0")
    page = tmp_path / "page.html"
    assert main(["view", "--solution", str(run), "--html", str(page)]) == 2
    assert "meshes/spring.stl" in capsys.readouterr().err
    assert not page.exists()
    # Without its files the run is what it was; only its picture is plainer.
    shutil.rmtree(machine)
    assert nip.load_solution(run).events


def test_a_table_of_the_reader_is_not_read(tmp_path: Path) -> None:
    """Its first line would be shown by the refusal."""
    (tmp_path / "secret.csv").write_text("the first line of a secret\n")
    case = nip.save_case(
        nip.load("hanging_pendulum"), nip.Case(speed_rpm=300.0), tmp_path / "case.json"
    )

    def another(document: dict[str, Any]) -> None:
        document["mechanism"]["folder"] = str(tmp_path)
        document["mechanism"]["description"]["springs"] = {
            "tab": {"joint": "lid", "file": "secret.csv"}
        }

    _edit(case, another)
    with pytest.raises(nip.NipperError, match=r"springs\.tab names a file") as refused:
        nip.load_case(case)
    assert "secret" not in refused.value.message


def test_old_files_are_read() -> None:
    """Every number as it was written."""
    run = nip.load_solution(SAVED / "format_3.npz")
    assert [event.t for event in run.events] == TIMES
    losses = [hit.energy_lost for hit in run.collisions]
    assert losses == [0.13213468424623176, 0.00529061240520938]
    mechanism, case = nip.load_case(SAVED / "format_3.json")
    assert (mechanism.name, case.speed_rpm, case.cycles) == ("hanging_pendulum", 300.0, 2)
    again = [event.t for event in nip.simulate(mechanism, case).events]
    assert again == pytest.approx(TIMES, abs=1e-13)
