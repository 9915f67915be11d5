"""Numbers with a unit of their own, as people type them: 9N/mm, 650rpm, 9.25 mm, 50 N mm/deg."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable
from typing import NamedTuple

from .given import read_number


class Unit(NamedTuple):
    """A unit by SI units.

    Attributes:
        factor: What one of it is in them.
        kind: Exponents of m, kg, s and rad.
    """

    factor: float
    kind: tuple[int, int, int, int]


_LENGTH, _MASS, _TIME, _ANGLE = (1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (0, 0, 0, 1)
_FORCE, _TORQUE = (1, 1, -2, 0), (2, 1, -2, 0)
_UNITS = {
    "m": Unit(1.0, _LENGTH), "mm": Unit(1e-3, _LENGTH), "cm": Unit(1e-2, _LENGTH),
    "um": Unit(1e-6, _LENGTH), "in": Unit(0.0254, _LENGTH),
    "kg": Unit(1.0, _MASS), "g": Unit(1e-3, _MASS), "t": Unit(1e3, _MASS),
    "s": Unit(1.0, _TIME), "ms": Unit(1e-3, _TIME), "min": Unit(60.0, _TIME),
    "rad": Unit(1.0, _ANGLE), "deg": Unit(math.pi / 180.0, _ANGLE),
    "mdeg": Unit(math.pi / 180e3, _ANGLE), "mrad": Unit(1e-3, _ANGLE),
    "r": Unit(math.tau, _ANGLE), "turn": Unit(math.tau, _ANGLE),
    "rpm": Unit(math.tau / 60.0, (0, 0, -1, 1)), "Hz": Unit(1.0, (0, 0, -1, 0)),
    "N": Unit(1.0, _FORCE), "kN": Unit(1e3, _FORCE), "mN": Unit(1e-3, _FORCE),
    "Nm": Unit(1.0, _TORQUE), "Nmm": Unit(1e-3, _TORQUE), "J": Unit(1.0, _TORQUE),
}  # fmt: skip
_TYPED = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*([A-Za-z][\w /*.^]*)")
_COMMA = re.compile(r"\s*([-+]?[0-9]+),([0-9]+)")
_WORD = re.compile(r"([A-Za-z]+)\^?(\d?)")
# Keys whose last words are no product of units.
_OF_KEYS = {"m_s2": "m/s2", "kg_m": "kg/m", "kg_m3": "kg/m3"}


def number_in(text: str, unit: str) -> float:
    """The number that a text is in a unit, whether it has a unit of its own or none.

    Args:
        unit: A unit such as "N/m"; empty for a number without one.

    Raises:
        ValueError: It is none, or its unit is unknown or of another kind; says which.
    """
    try:
        return read_number(text)
    except ValueError:
        found = _TYPED.fullmatch(text)
    if found is None:
        comma = _COMMA.match(text)
        message = f"a number, with a decimal point: {comma[1]}.{comma[2]}" if comma else "a number"
        raise ValueError(message) from None
    number, written = read_number(found[1]), found[2].strip()
    if not unit:
        message = f"a number without a unit, not {written!r}"
        raise ValueError(message)
    typed, wanted = _unit(written), _unit(unit)
    if typed is None:
        known = ", ".join(_UNITS)
        message = f"a number in {unit}, or with a unit made of {known}"
        raise ValueError(message)
    if wanted is None or typed.kind != wanted.kind:
        message = f"a number in {unit}, or with a unit of that kind, which {written} is not"
        raise ValueError(message)
    # Of one unit the number stays to the last bit.
    return number if typed == wanted else number * (typed.factor / wanted.factor)


def unit_of_key(key: str) -> str:
    """The unit that a key of a model's file ends with: "N/m" of ``stiffness_N_per_m``."""
    joined = key[len(_stem(key)) + 1 :]
    if joined in _OF_KEYS:
        return _OF_KEYS[joined]
    return joined.replace("_per_", "/").replace("_", " ").replace("hz", "Hz")


def known_key(key: str, known: Iterable[str]) -> tuple[str, float] | None:
    """The known key that means the same in another unit: of ``at_cm`` it is ``at_mm``.

    Returns:
        The key, and what one of the written unit is in its unit; None if there is none.
    """
    written = _unit(unit_of_key(key))
    if written is None:
        return None
    for other in known:
        unit = _unit(unit_of_key(other)) if _stem(other) == _stem(key) else None
        if unit is not None and unit.kind == written.kind:
            factor = written.factor / unit.factor
            # 1e-3 / 1e-2^3 is a thousand.
            short = float(f"{factor:.12g}")
            return other, short if math.isclose(short, factor, rel_tol=1e-15) else factor
    return None


def pattern_of_key(key: str) -> str:
    """A regular expression of the keys that mean the same in any unit; empty without a unit."""
    stem, unit = _stem(key), key[len(_stem(key)) + 1 :]
    words = [_alternatives(word) for word in unit.split("_")]
    return f"^{stem}_{'_'.join(words)}$" if any("|" in word for word in words) else ""


def _alternatives(word: str) -> str:
    """Units of the kind of one, of the same power, as a regular expression."""
    found = _WORD.fullmatch(word)
    if found is None or found[1] not in _UNITS:
        return word
    kind = _UNITS[found[1]].kind
    return f"({'|'.join(name for name, unit in _UNITS.items() if unit.kind == kind)}){found[2]}"


def _stem(key: str) -> str:
    """A key without its unit."""
    words = key.split("_")
    at = next((at for at in range(1, len(words)) if _is_unit(words[at:])), len(words))
    return "_".join(words[:at])


def _is_unit(words: list[str]) -> bool:
    return words[0] != "per" and all(
        word in ("per", "hz") or ((part := _WORD.fullmatch(word)) and part[1] in _UNITS)
        for word in words
    )


def _unit(text: str) -> Unit | None:
    """A product of units, those behind a stroke being divided by; None if it is none."""
    factor, kind = 1.0, [0, 0, 0, 0]
    for place, part in enumerate(text.split("/")):
        sign = -1 if place else 1
        for word in re.split(r"[ *.]+", part.strip()):
            found = _WORD.fullmatch(word)
            if found is None or found[1] not in _UNITS:
                return None
            power = sign * int(found[2] or 1)
            one = _UNITS[found[1]]
            factor *= one.factor**power
            kind = [own + power * other for own, other in zip(kind, one.kind, strict=True)]
    return Unit(factor, (kind[0], kind[1], kind[2], kind[3]))
