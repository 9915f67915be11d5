"""The setting that is shown, the one before it, and one that is pinned."""

from __future__ import annotations

from dataclasses import dataclass

from .answer import Answer, Rows

# Moves of a slider that follow each other within this time are one change [s].
ONE_CHANGE = 0.8


@dataclass(frozen=True)
class Kept:
    """An answer with the numbers of its whole turn."""

    answer: Answer
    turn: Rows


class Memory:
    """What the page compares.

    Attributes:
        present: What is shown; None before the first answer.
        before: The last setting with numbers before the present change; None without one.
        pinned: The setting that is pinned; None without one.
    """

    def __init__(self) -> None:
        """Begin with nothing."""
        self.present: Kept | None = None
        self.before: Kept | None = None
        self.pinned: Kept | None = None
        self._changed = -2.0 * ONE_CHANGE

    @property
    def other(self) -> Kept | None:
        """What numbers are compared with: the pinned setting, or the one before."""
        return self.pinned or self.before

    def take(self, now: float, answer: Answer, turn: Rows) -> None:
        """Show an answer that comes at a time [s]; the one before stays if a new change begins."""
        begins = now - self._changed > ONE_CHANGE
        if begins and self.present is not None and not self.present.answer.message:
            self.before = self.present
        self._changed = now
        self.present = Kept(answer, turn)

    def against(self) -> str:
        """What numbers are compared with, in words; empty without anything."""
        if self.other is None:
            return ""
        which = "the pinned setting" if self.pinned else "the setting before"
        return f"at right: difference to {which} ({self.unlike(self.other)})"

    def unlike(self, kept: Kept) -> str:
        """The numbers of a setting that are others now."""
        now = () if self.present is None else self.present.answer.parts
        other = [item for item in kept.answer.parts if item not in now]
        return ", ".join(other) or "the same setting"

    def turned(self, turn: Rows) -> None:
        """Note the numbers of the whole turn of the present setting, which came later."""
        if self.present is not None:
            self.present = Kept(self.present.answer, turn)

    def end_change(self) -> None:
        """Let what comes next be another change, however soon it comes."""
        self._changed = -2.0 * ONE_CHANGE

    def pin(self) -> None:
        """Pin the present setting, if it has curves; unpin if one is pinned."""
        if self.pinned is not None:
            self.pinned = None
        elif self.present is not None and not self.present.answer.message:
            self.pinned = self.present
