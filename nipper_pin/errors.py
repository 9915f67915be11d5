"""Errors of the package: one root, each carrying its evidence and saying what to change."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from typing import Any, TypeVar

# Letters of the begin and of the end of a message that is longer: a file may hold any word.
_BEGIN, _END = 3000, 1000
# Longest name that is compared with others, and most of these: a file may hold any number.
_NAME, _NAMES = 60, 1000
_NUMBER = re.compile(r"-?\d+(\.\d+)?(e[+-]?\d+)?")
_T = TypeVar("_T")


def one_line(text: str) -> str:
    """A text as one line that a terminal shows as it is.

    Args:
        text: The text; what it quotes of a file may hold anything.
    """
    if len(text) > _BEGIN + _END:
        text = f"{text[:_BEGIN]} ... {text[-_END:]}"
    return printable(text)


def printable(text: str, kept: str = "") -> str:
    """A text in which codes that command a terminal are written out, and change no direction.

    Args:
        text: The text.
        kept: Letters that stay although they are not printable.
    """
    if text.isprintable():
        return text
    return "".join(
        letter if letter.isprintable() or letter in kept else repr(letter)[1:-1] for letter in text
    )


def without_numbers(message: str) -> str:
    """A message with a sign in place of each number: reasons that differ in numbers are one kind.

    Args:
        message: The message.
    """
    return _NUMBER.sub("#", message)


class NipperError(Exception):
    """Root of every error this package raises on purpose.

    Attributes:
        message: One sentence for the user: what is wrong and what to change.
        evidence: The values the sentence is based on, by name.
    """

    def __init__(self, message: str, **evidence: Any) -> None:
        """Create the error.

        Args:
            message: One sentence for the user.
            **evidence: Values that the sentence is based on.
        """
        message = one_line(message)
        super().__init__(message)
        self.message = message
        self.evidence = evidence

    def __reduce__(self) -> tuple[Any, ...]:
        """Rebuild from message and evidence, so that errors cross from worker processes."""
        return _rebuild, (type(self), self.message, self.evidence)


def _rebuild(kind: type[NipperError], message: str, evidence: dict[str, Any]) -> NipperError:
    error = kind.__new__(kind)
    NipperError.__init__(error, message, **evidence)
    return error


def with_words(error: InputError, words: Mapping[str, str]) -> InputError:
    """An error of the same kind with words in place of others, in its message and its evidence.

    Args:
        error: The error.
        words: New words by those that they replace.
    """
    message, evidence = error.message, dict(error.evidence)
    for old, new in words.items():
        message = message.replace(old, new)
        for key in ("file", "where"):
            if isinstance(evidence.get(key), str):
                evidence[key] = evidence[key].replace(old, new)
    renamed = _rebuild(type(error), message, evidence)
    return renamed if isinstance(renamed, InputError) else error


class InputError(NipperError):
    """Arguments or files that cannot be used (exit status 2)."""


class ModelError(InputError):
    """A model file holds a value that no mechanism can have, or lacks one that it needs.

    Evidence: ``file``, ``key``, ``value``, ``allowed``.
    """

    def __init__(self, *, file: str, key: str, value: Any, allowed: str) -> None:
        """Create the error.

        Args:
            file: File that holds the value.
            key: Path of the value inside the file.
            value: The value found; None if there is none.
            allowed: What may stand there.
        """
        wrong = "is missing" if value is None else f"= {value!r} cannot be used"
        super().__init__(
            f"{file}: {key} {wrong}: {allowed}",
            file=file,
            key=key,
            value=value,
            allowed=allowed,
        )


class UnknownNameError(InputError):
    """A name that does not exist, together with the names that do.

    Evidence: ``kind``, ``name``, ``known``, ``where``, ``now``.
    """

    def __init__(
        self, kind: str, name: str, known: Iterable[str], where: str = "", now: str = ""
    ) -> None:
        """Create the error.

        Args:
            kind: What the name should name, for example "joint".
            name: The unknown name.
            known: Names that exist.
            where: File and key that hold the name.
            now: What the thing that is meant is called, if that is known.
        """
        names = sorted(known)
        place = f"{where}: " if where else ""
        help_ = f"{meant(name, names)}known: {', '.join(names) or 'none'}"
        if now:
            help_ = f"it is called {now!r}"
        super().__init__(
            f"{place}there is no {kind} named {name!r}; {help_}",
            kind=kind,
            name=name,
            known=names,
            where=where,
            now=now,
        )


def looked_up(kind: str, name: str, known: Mapping[str, _T], where: str = "") -> _T:
    """The part of a name.

    Raises:
        UnknownNameError: There is none.
    """
    if name not in known:
        raise UnknownNameError(kind=kind, name=name, known=known, where=where)
    return known[name]


def meant(name: str, known: Iterable[str]) -> str:
    """A question for the nearest of the names that are known; empty if none is near.

    Args:
        name: A name that does not exist.
        known: Names that do.
    """
    # Rarely needed, and slow to import.
    from difflib import get_close_matches

    words = [item for item in known if len(item) <= _NAME]
    # The nearest place in a list is none that anybody meant.
    wanted = name if len(name) <= _NAME and not name.startswith("[") else ""
    near = get_close_matches(wanted, words[:_NAMES], 1)
    return f"did you mean {near[0]!r}? " if near else ""


class AssemblyError(ModelError):
    """The closures of a model do not meet in its touch configuration, or its rows are redundant."""


class SimulationError(NipperError):
    """The simulation could not be done (exit status 1)."""


class SingularConfigurationError(SimulationError):
    """The closures lose rank: the mechanism stands in (or too near) a dead centre.

    Evidence: ``condition``, ``cylinder_angle_rad``, ``index``, ``joints``.
    """


class ConvergenceError(SimulationError):
    """An iteration did not reach its tolerance.

    Evidence: ``residual``, ``tolerance``, ``iterations``.
    """


class SelfCheckError(SimulationError):
    """A run that was computed does not meet its own closures, or its energy balance.

    Evidence: ``check``, ``residual``, ``tolerance``.
    """


class ElementError(SimulationError):
    """A spring or damper has no force here: its table ends, or its two points coincide.

    Evidence: ``element`` and, for a table, ``joint``, ``coordinate``, ``ends``; for two points
    ``distance_m``. Both with the time ``t`` and the configuration ``q``.
    """


class ImpactError(SimulationError):
    """No set of impulses satisfies the impact law at a collision.

    Evidence: ``stops``, ``rates_before``, ``condition``.
    """


class MisfitError(NipperError):
    """Numbers were fitted to data that contradict them (exit status 1).

    Evidence: ``chi_square``, ``degrees_of_freedom``, ``probability``, ``outliers``.
    """


class InfeasibleError(SimulationError):
    """No design within its bounds meets all limits.

    Evidence: ``limits`` (each that is broken, with what was reached and by how much it is missed),
    ``numbers`` (the nearest design).
    """
