"""What a command says on stderr while one waits, apart from all else."""

from __future__ import annotations

import re

_WAITING = re.compile(r"nipper-pin: .+: [\d,]+ (?:done|of [\d,]+) after \d+ s.*\n")


def notes(said: str) -> str:
    """All but lines of progress, which a slow machine writes and a fast one does not."""
    return _WAITING.sub("", said)
