"""The tool that makes random errors: what it changes, what it leaves alone, and its arithmetic."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT / "scripts/maintain/mutation"))

import mutate  # noqa: E402
from engine_errors import MUTATIONS  # noqa: E402
from random_errors.choice import ROOMS, Choice, Recorded, drawn  # noqa: E402
from random_errors.processes import collected, run_tests  # noqa: E402
from random_errors.recording import instrument  # noqa: E402
from random_errors.sites import compiles, mutations_of  # noqa: E402

SOURCE = '''"""Text 7."""
from math import degrees

UNITS = ("time_s", "angle_rad")


def shown(angle: float, low: float = 2.5) -> str:
    """Text 8."""
    if angle < low:
        message = "angle 9"
        raise ValueError(message)
    wide = -angle + low
    return row(degrees(angle), f"{1e3 * wide:.3g} mm", style="bold 4")
'''


def changes() -> set[tuple[str, str]]:
    found = mutations_of("view/shown.py", SOURCE)
    return {(item.before, item.after) for item in found if compiles(item, SOURCE.encode())}


def test_what_people_read_is_changed() -> None:
    assert {
        ("angle < low", "(angle > low)"),
        ("angle < low", "(not (angle < low))"),
        ("angle < low", "False"),
        ("-angle + low", "(-angle - low)"),
        ("-angle", "(angle)"),
        ("degrees(angle)", "(angle)"),
        ("2.5", "5.0"),
        ('"time_s"', "'time_s_'"),
        ('("time_s", "angle_rad")', "(('angle_rad', 'time_s'))"),
        ('f"{1e3 * wide:.3g} mm"', "f'{1.0 * wide:.3g} mm'"),
        ('f"{1e3 * wide:.3g} mm"', "f'{1000.0 * wide:.3g} m'"),
    } <= changes()


@pytest.mark.parametrize("word", ["Text", "9", "bold", "message", "import", "float"])
def test_texts_types_and_looks_are_left_alone(word: str) -> None:
    assert not any(word in before and "row(" not in before for before, _ in changes())


@pytest.mark.slow
def test_a_sample_grows_with_its_count_and_changes_with_its_seed() -> None:
    """The first mutations of a seed stay the first; most of all rooms are among them."""
    package = ROOT / "nipper_pin"
    first, again, other = (
        [item.identity for item in drawn(package, ["cli", "reduced"], seed)[:40]]
        for seed in (1, 1, 2)
    )
    assert first == again
    assert len(set(first) & set(other)) < 10
    assert set(ROOMS) == {"view", "study", "mechanism", "cli", "reduced"}


def test_statements_that_run_are_recorded(tmp_path: Path) -> None:
    """Of an instrumented copy the branch that is taken is noted, and the other one is not."""
    package = tmp_path / "small"
    package.mkdir()
    (package / "__init__.py").write_text(
        "def sign(x):\n    if x > 0:\n        return 1\n    return -1\n", encoding="utf-8"
    )
    keys = instrument(package)
    space: dict[str, object] = {}
    text = (package / "__init__.py").read_text(encoding="utf-8")
    none = f"_ran_ = [0] * {len(keys)}"
    exec(text.replace("from statements_that_ran import ran as _ran_", none), space)
    assert space["sign"](5.0) == 1  # type: ignore[operator]
    ran = {keys[place] for place, flag in enumerate(space["_ran_"]) if flag}  # type: ignore[arg-type, var-annotated]
    assert ran == {"__init__.py::.sign::if x > 0:", "__init__.py::.sign::return 1"}


def test_tests_that_execute_a_statement_are_chosen_the_nearest_first(tmp_path: Path) -> None:
    package = tmp_path / "small"
    (package / "view").mkdir(parents=True)
    (package / "view" / "shown.py").write_text(SOURCE, encoding="utf-8")
    key = "view/shown.py::.shown::wide = -angle + low"
    tests = {
        name: Recorded(name, seconds, frozenset({key, *more}))
        for name, seconds, more in (
            ("tests/study/test_long.py::a", 50.0, {"x::y::z"}),
            ("tests/study/test_other.py::b", 0.1, {"x::y::z"}),
            ("tests/view/test_shown.py::c", 0.1, set()),
            ("tests/view/test_shown.py::gone", 0.1, set()),
        )
    }
    choice = Choice(package, tests, set(list(tests)[:3]))
    found = {item.after: item for item in mutations_of("view/shown.py", SOURCE)}
    nearest = ["tests/view/test_shown.py::c", "tests/study/test_other.py::b"], 1
    assert choice.tests(found["(-angle - low)"], 10.0) == nearest
    newer = [item for item in found.values() if item.scope == ".shown" and item.key != key]
    assert newer
    assert choice.tests(newer[0], 10.0) == nearest


@pytest.mark.slow
def test_an_error_that_stops_all_tests_is_noticed(tmp_path: Path) -> None:
    """What every test imports fails: no test starts, and the first one counts as failed."""
    (tmp_path / "tests").mkdir()
    test = tmp_path / "tests" / "test_sum.py"
    test.write_text("def test_it():\n    assert 1 + 1 == 2\n", encoding="utf-8")
    assert collected(tmp_path) == {"tests/test_sum.py::test_it"}
    names = ["tests/test_sum.py::test_it"]
    assert run_tests(tmp_path, names, {}).failed == ""
    (tmp_path / "tests" / "conftest.py").write_text("raise ValueError\n", encoding="utf-8")
    broken = run_tests(tmp_path, names, {})
    assert (broken.failed, broken.why) == (names[0], "fails")


def test_the_interval_is_that_of_wilson() -> None:
    """Values from the formula's own closed form for one half, and its limits without misses."""
    low, high = mutate.interval(150, 300)
    assert (low, high) == pytest.approx((0.443777, 0.556223), abs=1e-5)
    low, high = mutate.interval(20, 20)
    assert low == pytest.approx(20.0 / (20.0 + 1.959964**2), rel=1e-6)
    assert high == pytest.approx(1.0)


def test_survivors_without_a_reason_are_a_failure(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    row = {"file": "view/shown.py", "line": 7, "kind": "unit", "before": "a", "after": "b",
           "caught": False, "by": "", "why": "all its tests pass"}  # fmt: skip
    reasons = tmp_path / "reasons.toml"
    monkeypatch.setattr(mutate, "REASONS", reasons)
    assert mutate.report([row]) == 1
    assert "SURVIVED view/shown.py:7" in capsys.readouterr().out
    reasons.write_text(
        '[[survivor]]\nfile = "view/shown.py"\nbefore = "a"\nafter = "b"\nreason = "the same"\n',
        encoding="utf-8",
    )
    assert mutate.report([row]) == 0
    assert "the same" in capsys.readouterr().out
    assert mutate.report([{**row, "caught": True}]) == 0


def test_the_engine_still_has_what_planted_errors_change() -> None:
    """Each text stands once in its file: an error that cannot be planted tells nothing."""
    package = ROOT / "nipper_pin"
    found = {
        item.name: (package / item.file).read_text(encoding="utf-8").count(item.right)
        for item in MUTATIONS
    }
    assert len(found) == len(MUTATIONS) > 25
    assert {name: count for name, count in found.items() if count != 1} == {}
