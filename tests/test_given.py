"""Public functions refuse what is no number of the kind that they ask for, and name it."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import nipper_pin as nip
from nipper_pin.cli import main
from nipper_pin.given import read_number, read_whole
from nipper_pin.reduced import reduced_model, transition, transitions
from nipper_pin.study.sensitivity import sensitivities
from nipper_pin.study.speed_limit import speed_limit
from nipper_pin.view.scene import Look

E62 = nip.load("e62")
# Words are those of a form or a file, arrays those of a column in place of one of its numbers.
NO_NUMBER: tuple[Any, ...] = (
    "650", "1_0", b"3", True, np.True_, math.nan, math.inf, -math.inf, 10**400, 3 + 4j, [1.0, "2"],
    {}, object(), float, np.datetime64("2026-01-01"), np.ma.masked,
)  # fmt: skip
NOT_ONE: tuple[Any, ...] = (*NO_NUMBER, None, [2.0], np.array([2.0]))
NOT_WHOLE: tuple[Any, ...] = (*NOT_ONE, 2.5, 1.0, np.float64(3.0), -1)
NO_FLAG: tuple[Any, ...] = ("no", 0, 1, None, 2.5, math.nan, [True], np.array([True, False]))


def case(key: str) -> Callable[[Any], object]:
    """A case with a value of one of its fields."""
    return lambda value: nip.Case(**{"speed_rpm": 450.0, key: value})


def resolution(key: str) -> Callable[[Any], object]:
    """A resolution with a value of one of its fields."""
    return lambda value: nip.Resolution(**{key: value})


def table(key: str) -> Callable[[Any], object]:
    """A table of transitions with a value of one of its arguments."""
    return lambda value: nip.transition_table(E62, **{"speed_rpm": 450.0, key: value})


def turns(key: str) -> Callable[[Any], object]:
    """A table of turns with a value of one of its arguments."""
    return lambda value: nip.turn_table(E62, **{"speed_rpm": 450.0, key: value})


def design(key: str) -> Callable[[Any], object]:
    """A search for a design; nothing is computed before its arguments are checked."""
    from nipper_pin.study.optimise import optimise

    return lambda value: optimise(None, **{key: value})  # type: ignore[arg-type]


def fit(key: str) -> Callable[[Any], object]:
    """A fit, likewise."""
    from nipper_pin.study.identify import identify

    return lambda value: identify(None, **{key: value})  # type: ignore[arg-type]


CALLS: dict[str, tuple[Callable[[Any], object], tuple[Any, ...]]] = {
    **{f"case {key}": (case(key), NOT_ONE) for key in ("speed_rpm", "start_index")},
    "case rest_rate": (case("rest_rate"), tuple(item for item in NOT_ONE if item is not None)),
    **{f"case {key}": (case(key), NOT_WHOLE) for key in ("cycles", "max_collisions")},
    "case reuse_cycles": (case("reuse_cycles"), NO_FLAG),
    "case resolution": (case("resolution"), (*NOT_ONE, 2.5, {"tolerance": 1e-9})),
    "resolution tolerance": (resolution("tolerance"), NOT_ONE),
    **{
        f"resolution {key}": (resolution(key), NOT_WHOLE)
        for key in ("flight_nodes", "kinematic_nodes", "panels_per_turn")
    },
    "resolution adaptive": (resolution("adaptive"), NO_FLAG),
    "table speed_rpm": (table("speed_rpm"), (*NO_NUMBER, None, 0.0, -1.0, [450.0, None])),
    "table restitution": (table("restitution"), (*NO_NUMBER[:-5], 1.5, -0.1, [0.1, None])),
    "table stiffness_N_per_m": (table("stiffness_N_per_m"), (*NO_NUMBER, 1e300, -1.0)),
    "table preload_length_mm": (table("preload_length_mm"), (*NO_NUMBER, 1e300)),
    "table tolerance": (table("tolerance"), NOT_ONE),
    "table rest_rate": (table("rest_rate"), (*NO_NUMBER, 0.0, 1e300)),
    "table max_collisions": (table("max_collisions"), (*NOT_WHOLE, 0)),
    "table engine": (table("engine"), (None, 3, ["direct"], {}, "fast")),
    "table drive": (table("drive"), (None, 3, ["held"], {}, "elastic")),
    "turns turns": (turns("turns"), (*NOT_WHOLE, 0)),
    "turns least_force_N": (turns("least_force_N"), (*NOT_ONE, 1e300, -1.0)),
    "turns torques": (turns("torques"), NO_FLAG),
    **{f"design {key}": (design(key), NOT_WHOLE) for key in ("starts", "seed", "points")},
    **{f"fit {key}": (fit(key), NOT_WHOLE) for key in ("starts", "seed")},
    **{
        f"limit {key}": (
            lambda value, key=key: speed_limit(
                E62, **{"low_rpm": 440.0, "high_rpm": 450.0, "speeds": 2, key: value}
            ),
            wrong,
        )
        for key, wrong in (
            ("low_rpm", (*NOT_ONE, 0.0, -1.0)),
            ("high_rpm", (*NOT_ONE, 0.0, -1.0)),
            ("speeds", (*NOT_WHOLE, 1)),
            ("turns", (*NOT_WHOLE, 0)),
        )
    },
    "sensitivities speed_rpm": (lambda value: sensitivities(E62, value), (*NOT_ONE, 0.0)),
    "sensitivities workers": (
        lambda value: sensitivities(E62, 450.0, workers=value),
        (*NOT_WHOLE, 0),
    ),
    "look slow": (
        lambda value: Look(slow=value),
        (*(item for item in NOT_ONE if item is not None), 0.5),
    ),
    "look exaggerate": (lambda value: Look(exaggerate=value), (*NOT_ONE, 99.0)),
    "rows most": (lambda value: nip.read_sweep("nowhere", value), (0, -1, 2.5, "3", True, [2])),
    "check speed_rpm": (
        lambda value: nip.check(E62, speed_rpm=value),
        tuple(item for item in NOT_ONE if item is not None),
    ),
    "check start_index": (
        lambda value: nip.check(E62, start_index=value),
        tuple(item for item in NOT_ONE if item is not None),
    ),
}


@pytest.mark.parametrize("name", CALLS)
def test_what_is_no_such_number_is_refused_by_name(name: str) -> None:
    call, wrong = CALLS[name]
    key = name.split()[-1]
    for value in wrong:
        with pytest.raises(nip.InputError, match=f"{key} = .* cannot be used: "):
            call(value)


@pytest.mark.parametrize("value", [450, 450.0, np.float64(450.0), np.float32(450.0), np.array(450)])
def test_numbers_of_numpy_become_those_of_python(value: Any) -> None:
    made = nip.Case(
        speed_rpm=value, cycles=np.int64(2), resolution=nip.Resolution(tolerance=value * 0 + 1e-6)
    )
    assert (made.speed_rpm, type(made.speed_rpm)) == (450.0, float)
    assert (made.cycles, type(made.cycles)) == (2, int)


@pytest.mark.parametrize("key", ["stiffness", "preload"])
@pytest.mark.parametrize("value", [-math.inf, math.inf, math.nan, 1e300, -1e300, "3", True])
def test_springs_of_the_reduced_engine(key: str, value: Any) -> None:
    model = reduced_model(E62)
    arguments: Any = {"speed_rpm": 450.0, key: value}
    for call in (transition, transitions):
        with pytest.raises(nip.InputError, match=f"^{key} = .* cannot be used"):
            call(model, **arguments)


@pytest.mark.parametrize("text", ["1_0", "٣", "１２", "1٫5", "", " ", "0x10", "1e", "12 3", "1,5"])  # noqa: RUF001
@pytest.mark.parametrize("read", [read_number, read_whole])
def test_texts_that_are_no_numbers(read: Callable[[str], float], text: str) -> None:
    with pytest.raises(ValueError, match=r"number|literal|convert"):
        read(text)


@pytest.mark.parametrize("text", ["1_0", "٣"])
@pytest.mark.parametrize(
    "path",
    ["stops.jaw.restitution", "links.top_nipper.mass_kg", "points.rod_pin.x_mm", "restitution",
     "urdf.joint.jaw.origin.xyz.x", "degrees_of_freedom"],
)  # fmt: skip
def test_changes_of_a_model(path: str, text: str) -> None:
    with pytest.raises(nip.ModelError, match="a number"):
        nip.load("e62", {path: text})


@pytest.mark.parametrize("number", ["1_0", "٣", "１"])  # noqa: RUF001
def test_numbers_in_tables(tmp_path: Path, number: str) -> None:
    folder = tmp_path / "mine"
    folder.mkdir()
    source = Path(E62.mesh_folder)
    (folder / "mine.urdf").write_text(E62.urdf, encoding="utf-8")
    toml = (source / "e62.toml").read_text(encoding="utf-8")
    table = '[springs.steeve]\njoint = "steeve"\nfile = "s.csv"\n'
    begin, end = toml.index("[springs.steeve]"), toml.index("# A stop keeps")
    toml = (toml[:begin] + table + toml[end:]).partition("# Short names")[0]
    (folder / "mine.toml").write_text(toml, encoding="utf-8")
    (folder / "s.csv").write_text(f"coordinate_mm,force_N\n-1,90\n0,{number}\n30,400\n", "utf-8")
    with pytest.raises(nip.ModelError, match=f"s.csv: line 3 force_N = '{number}'"):
        nip.load(folder)


@pytest.mark.parametrize("words", [["--speed", "1_0"], ["--speed", "٣"], ["--restitution", "1_"]])
def test_numbers_of_the_command_line(words: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as caught:
        main(["simulate", *words])
    assert caught.value.code == 2
    assert f"invalid float value: '{words[1]}'" in capsys.readouterr().err
