"""Names in files as people read them."""

from __future__ import annotations

from .parameters import parameter_shown
from .shown import Shown
from .table import TERMS, term_of

_ORDINALS = ("first", "second", "third")


def named(name: str, unit: str = "rad") -> Shown:
    """How people read a quantity or a parameter.

    Args:
        name: Its name in files: of a quantity, such as ``duration_s``, ``rebound_amplitude_1`` or
            ``collisions_jaw``; or the path of a parameter.
        unit: Its unit in files, which tells angles from lengths where the name does not; that of
            the stop's coordinate does as well.
    """
    gap = "m" if unit in ("m", "m/s") else "rad"
    try:
        term, number = term_of(name)
    except KeyError:
        return _of_part(name, gap) or parameter_shown(name)
    found = term.shown(gap)
    return _numbered(found, term.name, number) if number else found


def _of_part(name: str, gap: str) -> Shown | None:
    """A quantity of one stop or drive in a turn: the longest term that the name begins with."""
    begins = [key for key in TERMS if name.startswith(f"{key}_")]
    if not begins:
        return None
    longest = max(begins, key=len)
    return TERMS[longest].shown(gap).of(f"of the {name.removeprefix(longest)[1:]}")


def _numbered(found: Shown, name: str, number: int) -> Shown:
    """A quantity of one collision: rebounds are counted in words as long as these are short."""
    if name.startswith("rebound") and number <= len(_ORDINALS):
        return found.called(f"{_ORDINALS[number - 1]} {found.words}")
    return found.of(f"of collision {number}")
