"""Public functions refuse what is no number of the kind that they ask for, and name it."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import nipper_pin as nip
from nipper_pin.given import read_number, read_whole
from nipper_pin.study.identify import identify
from nipper_pin.study.levers import levers
from nipper_pin.study.optimise import optimise
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


def but_none(values: tuple[Any, ...]) -> tuple[Any, ...]:
    return tuple(item for item in values if item is not None)


def of(call: Callable[..., object], *first: Any, **given: Any) -> Callable[..., object]:
    """A call with some of its arguments; those that are named later replace them."""
    return lambda **more: call(*first, **{**given, **more})


case, resolution, look = of(nip.Case, speed_rpm=450.0), of(nip.Resolution), of(Look)
table = of(nip.transition_table, E62, speed_rpm=450.0)
turns = of(nip.turn_table, E62, speed_rpm=450.0)
# Nothing is computed before the arguments are checked.
design, fit = of(optimise, None), of(identify, None)
limit = of(speed_limit, E62, low_rpm=440.0, high_rpm=450.0, speeds=2)
lever = of(levers, E62, speed_rpm=450.0)
CALLS: list[tuple[Callable[..., object], str, tuple[Any, ...]]] = [
    (case, "speed_rpm start_index", NOT_ONE),
    (case, "rest_rate", but_none(NOT_ONE)),
    (case, "cycles max_collisions", NOT_WHOLE),
    (case, "reuse_cycles", NO_FLAG),
    (case, "resolution", (*NOT_ONE, 2.5, {"tolerance": 1e-9})),
    (resolution, "tolerance", NOT_ONE),
    (resolution, "flight_nodes kinematic_nodes panels_per_turn", NOT_WHOLE),
    (resolution, "adaptive", NO_FLAG),
    (table, "speed_rpm", (*NO_NUMBER, None, 0.0, -1.0, [450.0, None])),
    (table, "restitution", (*NO_NUMBER[:-5], 1.5, -0.1, [0.1, None])),
    (table, "stiffness_N_per_m", (*NO_NUMBER, 1e300, -1.0)),
    (table, "preload_length_mm", (*NO_NUMBER, 1e300)),
    (table, "tolerance", NOT_ONE),
    (table, "rest_rate", (*NO_NUMBER, 0.0, 1e300)),
    (table, "max_collisions", (*NOT_WHOLE, 0)),
    (table, "engine", (None, 3, ["direct"], {}, "fast")),
    (table, "drive", (None, 3, ["held"], {}, "elastic")),
    (turns, "turns max_collisions", (*NOT_WHOLE, 0, 10**12)),
    (turns, "least_force_N", (*NOT_ONE, 1e300, -1.0)),
    (turns, "torques", NO_FLAG),
    (design, "starts seed points", NOT_WHOLE),
    (fit, "starts seed", NOT_WHOLE),
    (limit, "low_rpm high_rpm", (*NOT_ONE, 0.0, -1.0)),
    (limit, "speeds", (*NOT_WHOLE, 1)),
    (limit, "turns", (*NOT_WHOLE, 0)),
    (lever, "speed_rpm", (*but_none(NOT_ONE), 0.0)),
    (look, "slow", (*but_none(NOT_ONE), 0.5)),
    (look, "exaggerate", (*but_none(NOT_ONE), 9999.0)),
    (of(nip.read_sweep, "nowhere"), "most", (0, -1, 2.5, "3", True, [2])),
    (of(nip.check, E62), "speed_rpm start_index", but_none(NOT_ONE)),
]


@pytest.mark.parametrize(("call", "keys", "wrong"), CALLS)
def test_what_is_no_such_number_is_refused_by_name(
    call: Callable[..., object], keys: str, wrong: tuple[Any, ...]
) -> None:
    for key in keys.split():
        for value in wrong:
            with pytest.raises(nip.InputError, match=f"{key} = .* cannot be used: "):
                call(**{key: value})


@pytest.mark.parametrize("value", [450, 450.0, np.float64(450.0), np.float32(450.0), np.array(450)])
def test_numbers_of_numpy_become_those_of_python(value: Any) -> None:
    made = nip.Case(
        speed_rpm=value, cycles=np.int64(2), resolution=nip.Resolution(tolerance=value * 0 + 1e-6)
    )
    assert (made.speed_rpm, type(made.speed_rpm)) == (450.0, float)
    assert (made.cycles, type(made.cycles)) == (2, int)


@pytest.mark.parametrize("text", ["1_0", "٣", "１２", "1٫5", "", " ", "0x10", "1e", "12 3", "1,5"])  # noqa: RUF001
@pytest.mark.parametrize("read", [read_number, read_whole])
def test_texts_that_are_no_numbers(read: Callable[[str], float], text: str) -> None:
    with pytest.raises(ValueError, match=r"number|literal|convert"):
        read(text)
