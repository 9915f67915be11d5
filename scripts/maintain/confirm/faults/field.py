"""Undisturbed results of one command, and what a disturbed run of it has left."""

from __future__ import annotations

import shutil
import tempfile
from dataclasses import dataclass, replace
from pathlib import Path

from arena import Arena, Ended, Fault
from commands import Command
from verdicts import NEW, NONE, SAME, WRONG, Content, content, leftovers, state


@dataclass(frozen=True, kw_only=True)
class Seen:
    """What one disturbed run has left.

    Attributes:
        fault: What happened to it.
        ended: How it ended.
        states: State of each target.
        left: Hidden files and folders that it left.
        wrong: What is wrong; empty if nothing.
    """

    fault: Fault
    ended: Ended
    states: tuple[str, ...]
    left: int = 0
    wrong: str = ""


class Field:
    """A command with its results before and after.

    Args:
        command: The command.
        inputs: Folder of the inputs.
        home: Folder to work in.
        arena: What runs the commands.

    Attributes:
        calls: Calls that write, of an undisturbed run.
        wall_s: Its run time [s].
    """

    def __init__(self, command: Command, inputs: Path, home: Path, arena: Arena) -> None:
        """Make the results."""
        self.command, self.arena = command, arena
        self._inputs, self.home = inputs, home
        self._before = home / "before"
        self._before.mkdir(parents=True)
        for words in command.before:
            self.done(words, self._before)
        self.old = self._contents(self._before)
        ended, self.new = self._reference(command.words)
        self.calls, self.wall_s = ended.calls, ended.wall_s

    def words(self, words: list[str]) -> list[str]:
        """Arguments with the folder of the inputs."""
        return [word.replace("{in}", str(self._inputs)) for word in words]

    def done(self, words: list[str], place: Path) -> Ended:
        """Run a command that has to succeed.

        Raises:
            RuntimeError: It does not.
        """
        ended = self.arena.run(self.words(words), place)
        if ended.status != 0:
            message = f"{self.command.name}: undisturbed it ends with {ended.status}: {ended.said}"
            raise RuntimeError(message)
        return ended

    def fresh(self) -> Path:
        """A new folder with what was there before."""
        place = Path(tempfile.mkdtemp(dir=self.home)) / "work"
        shutil.copytree(self._before, place)
        return place

    def other(self, words: list[str]) -> list[Content]:
        """Undisturbed results of other arguments."""
        return self._reference(words)[1]

    def disturbed(self, fault: Fault) -> Seen:
        """Run the command with a fault, judge what is there, and run it again."""
        place = self.fresh()
        seen = self.judged(
            fault, self.arena.run(self.words(self.command.words), place, fault), place
        )
        if not seen.wrong:
            seen = replace(seen, wrong=self._again(place, seen))
        if not seen.wrong:
            shutil.rmtree(place.parent)
        return seen

    def judged(self, fault: Fault, ended: Ended, place: Path) -> Seen:
        """Judge what a disturbed run has left."""
        found = self.states(place)
        left = leftovers(place)
        seen = Seen(fault=fault, ended=ended, states=found, left=len(left))
        lived = ended.status >= 0
        sentence = ended.said.startswith("nipper-pin: ") and ended.said.count("\n") == 1
        freeing = ended.disturbed in ("unlink", "unlinkat", "rmdir")
        for bad, why in (
            (WRONG in found, "neither old nor new"),
            (lived and ended.status == 0 and not set(found) <= {NEW, SAME}, "status 0, not new"),
            (lived and ended.status == 0 and ended.said, f"status 0, and said: {ended.said}"),
            (lived and ended.status != 0 and not sentence, f"no sentence: {ended.said}"),
            (lived and left and not freeing, f"left {left}"),
        ):
            if bad:
                return replace(seen, wrong=f"{why} ({place})")
        return seen

    def states(self, place: Path) -> tuple[str, ...]:
        """State of each target."""
        try:
            found = self._contents(place)
        except ValueError as error:
            return (f"{WRONG} ({error})", WRONG)
        return tuple(
            state(*item, self.command.parts) for item in zip(found, self.old, self.new, strict=True)
        )

    def _again(self, place: Path, seen: Seen) -> str:
        """Run the command again, undisturbed; what is wrong then."""
        ended = self.arena.run(self.words(self.command.words), place)
        whole = set(seen.states) <= {NEW, SAME}
        refused = whole and ended.status == 2 and "is there already" in ended.said
        if ended.status != 0 and not refused:
            return f"run again: {ended.said} ({place})"
        if not set(self.states(place)) <= {NEW, SAME}:
            return f"run again: {self.states(place)} ({place})"
        left = leftovers(place)
        if refused and len(left) == 1:
            # Whoever names a folder that is there does not get as far as removing anything.
            return ""
        return f"run again, and {left} is left ({place})" if left else ""

    def _reference(self, words: list[str]) -> tuple[Ended, list[Content]]:
        place = self.fresh()
        ended = self.done(words, place)
        found = self._contents(place)
        shutil.rmtree(place.parent)
        return ended, found

    def _contents(self, place: Path) -> list[Content]:
        return [content(place / name) for name in self.command.targets]


def shown(states: tuple[str, ...]) -> str:
    """States of all targets in one word: the same, or which."""
    return states[0] if len(set(states)) == 1 else "+".join(states or (NONE,))
