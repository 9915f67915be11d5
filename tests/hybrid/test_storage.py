"""Solutions on disk: every bit comes back, damage is named, nothing is half written or executed."""

from __future__ import annotations

import dataclasses
import io
import json
import tracemalloc
import zipfile
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import nipper_pin
from nipper_pin import (
    Case,
    DriveMode,
    InputError,
    Mechanism,
    Resolution,
    Solution,
    Window,
    load,
    load_case,
    load_solution,
    save,
    save_case,
    simulate,
)
from nipper_pin.hybrid.files import archive as packed
from nipper_pin.hybrid.files import npz as storage
from nipper_pin.mechanism import with_numbers
from nipper_pin.mechanism.drives import ConstantSpeed

RUNS = {
    "transition": Case(speed_rpm=650.0),
    "inertial": Case(speed_rpm=450.0, drive=DriveMode.INERTIAL, rest_rate=0.02),
    "turns": Case(speed_rpm=650.0, window=Window.CYCLE, cycles=4, start_index=23.0),
}


@pytest.fixture(scope="module", params=RUNS)
def solution(request: pytest.FixtureRequest) -> Solution:
    """Runs of every kind, with overrides that the stored model has to carry."""
    overrides = {"stops.jaw.restitution": 0.3, "links.top_nipper.mass_kg": 1.3}
    return simulate(load("e62", overrides), RUNS[request.param])


@pytest.fixture(scope="module")
def copy(solution: Solution, tmp_path_factory: pytest.TempPathFactory) -> Solution:
    """The solution after a way over the disk."""
    return load_solution(save(solution, tmp_path_factory.mktemp("saved") / "run.npz"))


def _same(ours: object, theirs: object, where: str = "") -> None:
    """Compare two values of dataclasses, containers and arrays bit by bit."""
    assert type(ours) is type(theirs), where
    if dataclasses.is_dataclass(ours):
        for field in (field for field in dataclasses.fields(ours) if field.compare):
            mine, other = getattr(ours, field.name), getattr(theirs, field.name)
            _same(mine, other, f"{where}.{field.name}")
    elif isinstance(ours, np.ndarray):
        assert ours.dtype == theirs.dtype, where  # type: ignore[attr-defined]
        assert ours.tobytes() == theirs.tobytes(), where  # type: ignore[attr-defined]
    elif isinstance(ours, tuple | list):
        assert len(ours) == len(theirs), where  # type: ignore[arg-type]
        for number, (mine, other) in enumerate(zip(ours, theirs, strict=True)):  # type: ignore[call-overload]
            _same(mine, other, f"{where}[{number}]")
    elif isinstance(ours, dict):
        assert list(ours) == list(theirs), where  # type: ignore[call-overload]
        for key in ours:
            _same(ours[key], theirs[key], f"{where}[{key}]")  # type: ignore[index]
    else:
        assert ours == theirs, where


def _same_model(ours: Mechanism, theirs: Mechanism) -> None:
    """A mechanism follows from its texts, so texts and contact decide."""
    assert ours.name == theirs.name
    assert ours.urdf == theirs.urdf
    assert ours.description == theirs.description
    _same(ours.joints, theirs.joints)
    _same(ours.stops, theirs.stops)
    _same(ours.springs, theirs.springs)


def test_events_segments_and_case_come_back_bit_by_bit(solution: Solution, copy: Solution) -> None:
    """All that a solution holds is equal in type and bits, field by field."""
    _same(copy.case, solution.case)
    _same(copy.events, solution.events)
    _same(copy.segments, solution.segments)
    for name in ("outcome", "evaluations", "wall_s", "repeated_from"):
        assert getattr(copy, name) == getattr(solution, name)
    assert copy.shaft.speed_rad_s == solution.shaft.speed_rad_s
    assert copy.shaft.start_angle_rad == solution.shaft.start_angle_rad


def test_the_model_comes_back_with_its_overrides(solution: Solution, copy: Solution) -> None:
    """The stored model is the changed one, not the one that ships."""
    _same_model(copy.mechanism, solution.mechanism)
    assert copy.mechanism.stop("jaw").restitution == 0.3
    masses = [inertia.mass for inertia in copy.mechanism.model.inertias]
    assert masses == [inertia.mass for inertia in solution.mechanism.model.inertias]
    assert 1.3 in masses


def test_dense_motion_and_forces_are_the_same_bits(solution: Solution, copy: Solution) -> None:
    """What is computed from a loaded solution equals what is computed from the original."""
    times = np.linspace(*solution.trajectory.span, 211)
    for left in (False, True):
        _same(
            copy.trajectory.evaluate(times, left=left),
            solution.trajectory.evaluate(times, left=left),
        )
        theirs, ours = (item.trajectory.reactions(times, left=left) for item in (copy, solution))
        _same(theirs, ours)
        _same(theirs.joints, ours.joints)
        _same(theirs.closures, ours.closures)
    _same(copy.collisions, solution.collisions)
    for one, other in zip(copy.collisions, solution.collisions, strict=True):
        assert one.rebound_amplitude == other.rebound_amplitude
        assert one.rebound_time == other.rebound_time
    _same(copy.phases, solution.phases)
    _same(copy.transitions, solution.transitions)
    _same(copy.checks, solution.checks)


def test_saving_again_gives_the_same_content(copy: Solution, tmp_path: Path) -> None:
    """A second way over the disk changes nothing."""
    again = load_solution(save(copy, tmp_path / "again"))
    _same(again.events, copy.events)
    _same(again.segments, copy.segments)


def test_the_suffix_is_added(solution: Solution, tmp_path: Path) -> None:
    """A name without .npz gets it, one with dots keeps them."""
    assert save(solution, tmp_path / "a.b") == tmp_path / "a.b.npz"
    assert [item.name for item in tmp_path.iterdir()] == ["a.b.npz"]


@pytest.fixture
def stored(tmp_path: Path) -> Path:
    """A small stored solution."""
    return save(simulate(load("e62"), Case(speed_rpm=650.0, max_collisions=2)), tmp_path / "run")


def test_a_missing_file_is_an_input_error(tmp_path: Path) -> None:
    """The message names the file."""
    for read in (load_solution, load_case):
        with pytest.raises(InputError, match="nowhere"):
            read(tmp_path / "nowhere.npz")


@pytest.mark.parametrize("part", [0.0, 0.01, 0.3, 0.7, 0.99])
def test_a_truncated_file_is_an_input_error(stored: Path, part: float) -> None:
    """Wherever the file was cut off, the message says that it is damaged."""
    content = stored.read_bytes()
    stored.write_bytes(content[: int(part * len(content))])
    with pytest.raises(InputError, match="damaged"):
        load_solution(stored)


def test_flipped_bytes_are_input_errors_or_harmless(stored: Path) -> None:
    """A byte changed anywhere gives an input error, or leaves every number as it was.

    The archive guards contents by checksums; bytes it does not use (times of day) may differ.
    """
    content = stored.read_bytes()
    original = load_solution(stored)
    errors = 0
    for place in np.random.default_rng(3).integers(0, len(content), 300):
        changed = bytearray(content)
        changed[place] ^= 0x55
        stored.write_bytes(changed)
        try:
            read = load_solution(stored)
        except InputError:
            errors += 1
        else:
            _same(read.events, original.events)
            _same(read.segments, original.segments)
    assert errors > 200


def _edit(path: Path, change: object) -> None:
    """Rewrite the document inside a stored solution."""
    with np.load(path, allow_pickle=False) as archive:
        arrays = {key: archive[key] for key in archive.files}
    document = json.loads(str(arrays.pop("document")))
    change(document)  # type: ignore[operator]
    with path.open("wb") as stream:
        np.savez_compressed(stream, document=np.array(json.dumps(document)), **arrays)


@pytest.mark.parametrize(
    "change",
    [
        lambda document: document.pop("events"),
        lambda document: document.pop("format"),
        lambda document: document.update(outcome="GOOD"),
        lambda document: document["events"].pop(),
        lambda document: document["events"][0].update(kind="bang"),
        lambda document: document["case"].update(speed_rpm=-1.0),
        lambda document: document["case"].update(colour="red"),
        lambda document: document["mechanism"].update(urdf="<robot/>"),
        lambda document: document["mechanism"].update(urdf="no xml"),
        lambda document: document["mechanism"]["description"]["stops"]["jaw"].update(
            restitution=-1
        ),
        lambda document: document["segments"][0]["panels"][0].pop(),
        lambda document: document.update(segments=None),
        lambda document: document["segments"][0].update(source=1),
        lambda document: document["events"][0].update(source=2),
    ],
)
def test_an_edited_file_is_an_input_error(stored: Path, change: object) -> None:
    """Missing keys, unknown names and impossible values are refused with the file or the key."""
    _edit(stored, change)
    with pytest.raises(InputError):
        load_solution(stored)


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
        with pytest.raises(InputError, match=r"1\.07e\+09 bytes; at most 4\.03e\+08 are read"):
            load_solution(path)
        assert tracemalloc.get_traced_memory()[1] < 2**24
    finally:
        tracemalloc.stop()


@pytest.mark.parametrize("length", [10**15, 1])
def test_an_array_is_as_long_as_it_says(tmp_path: Path, length: int) -> None:
    """One that says more would be given memory before its content is read."""
    path = tmp_path / "lying.npz"
    with zipfile.ZipFile(path, "w") as archive, archive.open("events.npy", "w") as member:
        np.lib.format.write_array_header_1_0(
            member, {"descr": "<f8", "fortran_order": False, "shape": (length,)}
        )
        member.write(bytes(80))
    with pytest.raises(InputError, match=r"events\.npy is not as long as it says"):
        load_solution(path)


@pytest.mark.parametrize(
    ("number", "other"), [(99, ""), (2, r", which nipper-pin 0\.1\.0 of 2026-11-23 reads")]
)
def test_another_format_is_refused_by_number(
    number: int, other: str, stored: Path, tmp_path: Path
) -> None:
    """The message names both formats, and the version that read the other one."""
    _edit(stored, lambda document: document.update(format=number))
    words = f"format {number}{other}, and this version reads format 3; simulate the case again"
    with pytest.raises(InputError, match=words):
        load_solution(stored)
    path = save_case(load("e62"), Case(speed_rpm=450.0), tmp_path / "case.json")
    path.write_text(
        path.read_text().replace(f'"format": {storage.FORMAT}', f'"format": {number}', 1)
    )
    with pytest.raises(InputError, match=words):
        load_case(path)


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
        with pytest.raises(InputError):
            load_solution(path)


def test_a_solution_holds_no_pickle(stored: Path) -> None:
    """Every array of the archive is plain: no object type in any header."""
    with zipfile.ZipFile(stored) as archive:
        for name in archive.namelist():
            header = archive.read(name)
            version = np.lib.format.read_magic(io.BytesIO(header))
            assert version[0] in (1, 2)
            assert np.load(io.BytesIO(header), allow_pickle=False).dtype.kind in "fU"


@pytest.mark.parametrize("existing", [True, False])
def test_nothing_half_written_when_writing_fails(
    solution: Solution, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, existing: bool
) -> None:
    """A full disk leaves the old file, or none, and no temporary one."""
    target = tmp_path / "run.npz"
    if existing:
        target.write_bytes(b"the old one")

    def full(stream: io.BufferedWriter, **_: object) -> None:
        stream.write(b"half of it")
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(storage.np, "savez_compressed", full)
    with pytest.raises(InputError, match="No space left on device"):
        save(solution, target)
    assert [item.name for item in tmp_path.iterdir()] == (["run.npz"] if existing else [])
    if existing:
        assert target.read_bytes() == b"the old one"


@pytest.mark.parametrize("folder", ["nowhere", "a_file"])
def test_a_folder_that_cannot_be_written_is_an_input_error(
    solution: Solution, tmp_path: Path, folder: str
) -> None:
    """A missing folder, and a file where a folder should be, are named."""
    (tmp_path / "a_file").write_text("")
    with pytest.raises(InputError, match="cannot be written"):
        save(solution, tmp_path / folder / "run.npz")
    with pytest.raises(InputError, match="cannot be written"):
        save_case(solution.mechanism, solution.case, tmp_path / folder / "case.json")
    assert [item.name for item in tmp_path.iterdir()] == ["a_file"]


@pytest.mark.parametrize("name", RUNS)
def test_a_case_comes_back_and_repeats_the_run(name: str, tmp_path: Path) -> None:
    """A stored case, with everything away from its defaults, repeats a run bit by bit."""
    case = dataclasses.replace(
        RUNS[name], resolution=Resolution(tolerance=1e-9, flight_nodes=9), max_collisions=77
    )
    mechanism = load("e62", {"stops.steeve.restitution": 0.1 + 0.2})
    path = save_case(mechanism, case, tmp_path / "case.json")
    read_mechanism, read_case = load_case(path)
    assert read_case == case
    _same_model(read_mechanism, mechanism)
    _same(simulate(read_mechanism, read_case).events, simulate(mechanism, case).events)


def test_a_case_may_be_edited(tmp_path: Path) -> None:
    """It is a text that is checked as models are."""
    mechanism, case = load("e62"), Case(speed_rpm=650.0)
    path = save_case(mechanism, case, tmp_path / "case.json")
    for speed in (600.0, -600.0):
        document = json.loads(path.read_text(encoding="utf-8"))
        document["case"]["speed_rpm"] = speed
        path.write_text(json.dumps(document), encoding="utf-8")
        if speed > 0.0:
            assert load_case(path)[1] == dataclasses.replace(case, speed_rpm=speed)
            continue
        with pytest.raises(InputError, match=r"speed_rpm = -600\.0"):
            load_case(path)


@pytest.mark.parametrize("text", ["", "{}", "[]", "no json", '{"format": 1}', "\x00\xff"])
def test_a_file_that_is_no_case_is_an_input_error(tmp_path: Path, text: str) -> None:
    """Anything else than a case is refused with the name of the file."""
    path = tmp_path / "case.json"
    path.write_text(text, encoding="latin-1")
    with pytest.raises(InputError, match=r"case\.json"):
        load_case(path)


def test_files_say_which_version_wrote_them(tmp_path: Path) -> None:
    mechanism, case = load("e62"), Case(speed_rpm=650.0)
    path = save_case(mechanism, case, tmp_path / "case.json")
    document = json.loads(path.read_text(encoding="utf-8"))
    assert document["version"] == nipper_pin.__version__
    run = save(simulate(mechanism, case), tmp_path / "run.npz")
    with np.load(run) as stored:
        document = json.loads(str(stored["document"]))
    assert document["version"] == nipper_pin.__version__


@pytest.mark.parametrize("limit", ["MOST_BYTES", "MOST_TEXT", "MOST_ARRAYS"])
def test_what_could_not_be_read_is_not_written(
    limit: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """With each limit of a reader lowered below what a short run has."""
    run = simulate(load("e62"), Case(speed_rpm=650.0))
    old = save(run, tmp_path / "run.npz").read_bytes()
    monkeypatch.setattr(packed, limit, 3)
    with pytest.raises(InputError, match="simulate fewer turns"):
        save(run, tmp_path / "run.npz")
    assert (tmp_path / "run.npz").read_bytes() == old
    with pytest.raises(InputError):
        load_solution(tmp_path / "run.npz")


def test_every_bit_of_the_begin_of_an_array(tmp_path: Path) -> None:
    """A flipped one is told of as damage, whatever the begin then looks like."""
    file = save(simulate(load("e62"), RUNS["transition"]), tmp_path / "run.npz")
    with zipfile.ZipFile(file) as archive:
        stored = {item: archive.read(item) for item in archive.namelist()}
    begin = stored["events.npy"]
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
    assert begin[:6] == b"\x93NUMPY"
    assert not wrong


REPLACED = {
    "springs": lambda e62: replace(
        e62, springs=(replace(e62.springs[0], stiffness=1.0), *e62.springs[1:])
    ),
    "stops": lambda e62: replace(
        e62, stops=tuple(replace(stop, restitution=0.05) for stop in e62.stops)
    ),
    "gravity_m_s2": lambda e62: replace(e62, gravity_m_s2=0.0),
    "drives": lambda e62: replace(
        e62, drives=tuple(replace(drive, law=ConstantSpeed(ratio=1.0)) for drive in e62.drives)
    ),
}


@pytest.mark.parametrize("part", REPLACED)
def test_replaced_parts_are_not_saved_as_what_they_were(
    part: str, e62: Mechanism, tmp_path: Path
) -> None:
    """A run is saved with the texts of its machine, which a replaced number is not in."""
    solution = simulate(e62, Case(speed_rpm=600.0, max_collisions=1))
    mechanism = REPLACED[part](e62)
    for write in (
        lambda: save(replace(solution, mechanism=mechanism), tmp_path / "run.npz"),
        lambda: save_case(mechanism, solution.case, tmp_path / "case.json"),
    ):
        with pytest.raises(InputError, match=f"^{part} of this mechanism is not"):
            write()
    assert list(tmp_path.iterdir()) == []
    changed = with_numbers(e62, {"stops.jaw.restitution": 0.05, "links.top_nipper.mass_kg": 1.3})
    save_case(changed, solution.case, tmp_path / "case.json")
    assert load_case(tmp_path / "case.json")[0].stops == changed.stops
