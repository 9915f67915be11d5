"""Checks between two solutions of a case: repeated, with a finer tolerance, mirrored."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from nipper_pin.hybrid import Event, EventError, EventKind, Solution

from ...tolerances import AGREED, EPS, IMPULSE_ROUND_OFF, MIRRORED, PARTED
from .invariants import Violation


def same_bits(first: Solution, second: Solution) -> list[Violation]:
    """Two runs of one case have the same events to the last bit."""
    if bits(first) == bits(second):
        return []
    return [Violation("determinism", "a second run has other bits")]


def bits(solution: Solution) -> bytes:
    """Every number of every event and of the ends of all segments, to the last bit."""
    parts = [solution.outcome.name.encode(), *(s.t_end.hex().encode() for s in solution.segments)]
    for event in solution.events:
        parts.append(f"{event.kind} {event.stops} {sorted(event.closed_after)}".encode())
        numbers = [event.t, event.energy_lost, event.series_error, *event.P_N.values()]
        parts.append(np.array(numbers).tobytes())
        parts.extend(x.tobytes() for x in (event.q, event.v_before, event.v_after, event.P_g))
    return b"\n".join(parts)


def within_errors(coarse: Solution, fine: Solution) -> list[Violation]:
    """The events of two solutions of one case agree within twice their stated errors."""
    return list(_compared(coarse, fine, "tolerance", AGREED))


def mirror_images(solution: Solution, image: Solution) -> list[Violation]:
    """The events of a machine and of its mirror image agree within a part of their stated errors.

    Both runs leave the same unresolved, so that only round-off is different, if anything is.
    """
    return list(_compared(solution, image, "mirror", MIRRORED))


def _compared(coarse: Solution, fine: Solution, kind: str, share: float) -> Iterator[Violation]:
    """Differences beyond this share of the stated errors of both.

    Series that one run extrapolates earlier are compared as far as both have them, and then at
    their rest.
    """
    first, second = list(coarse.events), list(fine.events)
    clock = 16.0 * EPS * max((event.t for event in first + second), default=0.0)
    i = j = 0
    while i < len(first) and j < len(second):
        one, other = first[i], second[j]
        errors = coarse.errors[i], fine.errors[j]
        if max(error.impulse for error in errors) >= 1.0:
            # With a rate below its error it is undecided whether the stop is reached.
            return
        allowed = share * (errors[0].time + errors[1].time) + 16.0 * EPS * max(one.t, other.t)
        apart = abs(one.t - other.t)
        if _same(one, other):
            if not apart <= allowed:
                text = f"event {one.number}: times differ by {apart:.3g} s"
                yield Violation(kind, f"{text}, stated {allowed:.3g} s")
            # After a flight as short as the round-off of time the rate is round-off.
            counts = one.kind is EventKind.COLLISION and max(one.t, other.t) > clock
            texts = list(_impulses(one, other, errors, share)) if counts else []
            # Events closer than the round-off of time are simultaneous.
            if texts and not _left_over(one, first, clock):
                yield from (Violation(kind, text) for text in texts)
            i, j = i + 1, j + 1
        elif _left_out(other, one):
            j += 1
        elif _left_out(one, other):
            i += 1
        else:
            # Events that are as near to one another as their errors may come in either order.
            if not apart <= PARTED * allowed:
                text = f"event {one.number}: {one.kind.value} of {one.stops} at {one.t:.9g} s"
                there = f"{other.kind.value} of {other.stops} at {other.t:.9g} s"
                yield Violation(kind, f"{text}, and {there}")
            return


def _same(one: Event, other: Event) -> bool:
    """True if events of two runs are the same one; a rest in a series of others is not the last."""
    alike = (one.kind, one.stops) == (other.kind, other.stops)
    return alike and (one.kind is not EventKind.REST or one.closed_after == other.closed_after)


def _left_out(item: Event, other: Event) -> bool:
    """True if another run, where it has another event, may have left this one out.

    It does so at the rest that ends a series; and of a series that it goes on with to its last
    rest, one of fewer stops, this rest.
    """
    if item.kind is EventKind.REST and other.kind is EventKind.RELEASE:
        return True
    ends = other.kind is EventKind.REST and item.kind is not EventKind.RELEASE
    return ends and set(item.stops[:1]) <= {*other.stops, *other.P_N}


def _left_over(hit: Event, events: list[Event], instant: float) -> bool:
    """True if a collision strikes with the round-off of a larger one in the same instant."""
    largest = max(
        max(map(abs, event.P_N.values()), default=0.0)
        for event in events
        if abs(event.t - hit.t) <= instant
    )
    return max(map(abs, hit.P_N.values())) <= IMPULSE_ROUND_OFF * largest


def _impulses(
    one: Event, other: Event, errors: tuple[EventError, EventError], share: float
) -> Iterator[str]:
    """Compare the impulses of one collision in two solutions, with the stated error of each."""
    for name, impulse in one.P_N.items():
        against = other.P_N.get(name, 0.0)
        stated = share * sum(error.impulses.get(name, 0.0) for error in errors)
        # Numbers have digits of their own, whatever is stated of them.
        stated += 64.0 * EPS * max(abs(impulse), abs(against))
        if not abs(impulse - against) <= stated:
            text = f"event {one.number}: impulses of {name} {impulse:.6g} and {against:.6g}"
            yield f"{text} differ by {abs(impulse - against):.3g}, stated {stated:.3g}"
