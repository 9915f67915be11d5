"""Every call that writes, failing for want of space or with an error of the disk, or killed."""

from __future__ import annotations

import errno
from collections.abc import Iterator
from dataclasses import replace

from arena import Fault
from field import Field, Seen

KINDS = {
    "ENOSPC": Fault(code=errno.ENOSPC, lasting=True),
    "EIO": Fault(code=errno.EIO),
    "kill": Fault(kill=True),
}


def every_write(field: Field, kind: str, step: int = 1) -> Iterator[Seen]:
    """Disturb the first call, the second, and so on, until a run is not disturbed.

    Args:
        field: The command.
        kind: What happens.
        step: Only every so many calls.
    """
    number = 1
    while True:
        seen = field.disturbed(replace(KINDS[kind], at=number))
        if not seen.ended.disturbed:
            return
        yield seen
        number += step
