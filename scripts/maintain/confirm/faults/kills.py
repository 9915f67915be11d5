"""Kills at random moments: of the whole run, near its writes, and inside one of them."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from arena import Fault
from field import Field, Seen

_NEAR_S = 0.15  # how long after its first hidden file a process is killed, at most


def random_kills(field: Field, number: int, rng: np.random.Generator) -> Iterator[Seen]:
    """Kill a command and all its processes at random moments.

    Half of the moments are even over the run, a quarter comes soon after the first hidden file, and
    a quarter in the middle of a call that writes.

    Args:
        field: The command.
        number: Number of kills; a run that ends before its moment is none, and is repeated.
        rng: Source of the moments.
    """
    done = 0
    while done < number:
        how = done % 4
        if how < 2:
            fault = Fault(after=float(rng.uniform(0.0, field.wall_s)))
        elif how == 2:
            near = min(_NEAR_S, field.wall_s)
            fault = Fault(after=float(rng.uniform(0.0, near)), hidden=True)
        else:
            fault = Fault(at=int(rng.integers(1, field.calls + 1)), kill=True)
        seen = field.disturbed(fault)
        if seen.ended.status < 0 or seen.wrong:
            done += 1
            yield seen
