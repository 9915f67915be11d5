"""A campaign on disk: its settings, and each verdict as soon as it is computed."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import msgspec

import nipper_pin
from nipper_pin.errors import InputError
from nipper_pin.study.folders import claim
from nipper_pin.study.sweep.job import versions

from .files import save_trial
from .judging import WRONG, Verdict
from .space import trial

_FORMAT = 1
_CAMPAIGN, _VERDICTS = "campaign.json", "verdicts.jsonl"


@dataclass(frozen=True)
class _Line:
    """The stored part of a verdict.

    Attributes:
        verdict: The verdict.
        elapsed_s: Wall time of the campaign up to here [s].
    """

    verdict: Verdict
    elapsed_s: float


class Store:
    """The folder of one campaign; without one nothing is kept.

    Args:
        folder: The folder, made if it does not exist; or None.
        seed: Seed of the campaign.
        time_limit_s: Time of the processor after which a trial is a hang [s].
        families: Families of the campaign; all if empty.

    Attributes:
        verdicts: What is kept so far.
        elapsed_s: Wall time of the campaign so far [s].

    Raises:
        InputError: It cannot be written, or holds another campaign.
    """

    def __init__(
        self,
        folder: str | Path | None,
        seed: int,
        time_limit_s: float,
        families: Sequence[str] = (),
    ) -> None:
        """Open the folder, and take up what is there if it is of the same campaign."""
        self.verdicts: tuple[Verdict, ...] = ()
        self.elapsed_s = 0.0
        self._folder, self._seed, self._families = folder, seed, tuple(families)
        if folder is None:
            return
        here = {"format": _FORMAT, "seed": seed, "time_limit_s": time_limit_s,
                "versions": versions(), "code": _code(), "families": list(families)}  # fmt: skip
        claim(Path(folder), _CAMPAIGN, here, "campaign", {"time_limit_s": "time limit"})
        lines = self._lines()
        self.verdicts = tuple(line.verdict for line in lines.values())
        self.elapsed_s = max((line.elapsed_s for line in lines.values()), default=0.0)

    def look(self) -> tuple[Verdict, ...]:
        """The verdicts stored so far."""
        return tuple(line.verdict for line in self._lines().values())

    def _lines(self) -> dict[int, _Line]:
        """Read complete lines; a line cut by an interrupt is left out."""
        if self._folder is None:
            return {}
        lines: dict[int, _Line] = {}
        file = Path(self._folder) / _VERDICTS
        text = file.read_bytes() if file.exists() else b""
        for line in text.splitlines():
            try:
                found = msgspec.json.decode(line, type=_Line)
            except msgspec.MsgspecError:
                continue
            lines[found.verdict.number] = found
        if text and not text.endswith(b"\n"):
            self._append(b"\n")
        return lines

    def put(self, verdict: Verdict, elapsed_s: float) -> None:
        """Keep a verdict, and the case file of a wrong one.

        Args:
            verdict: The verdict.
            elapsed_s: Wall time of the campaign so far [s].

        Raises:
            InputError: It cannot be written.
        """
        if self._folder is None:
            return
        if verdict.word == WRONG:
            save_trial(trial(self._seed, verdict.number, self._families), verdict, self._folder)
        self._append(msgspec.json.encode(_Line(verdict, elapsed_s)) + b"\n")

    def _append(self, line: bytes) -> None:
        file = Path(self._folder or "") / _VERDICTS
        try:
            with file.open("ab") as stream:
                stream.write(line)
        except OSError as error:
            message = f"{file}: cannot be written ({error.strerror or error})"
            raise InputError(message, file=str(file)) from error


def _code() -> str:
    """Hash of the package and its judge: what another state has judged is another campaign."""
    digest = hashlib.sha256()
    for folder in (Path(nipper_pin.__file__).parent, Path(__file__).parents[1]):
        for path in sorted(folder.rglob("*.py")):
            digest.update(path.relative_to(folder.parent).as_posix().encode())
            digest.update(path.read_bytes())
    return digest.hexdigest()
