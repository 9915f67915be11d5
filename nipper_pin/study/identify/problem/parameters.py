"""Numbers of a model by path: what may be free in an identification or a sensitivity.

The paths are those of ``--set`` (:mod:`nipper_pin.mechanism.edit.dimensions`).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from ....errors import SimulationError
from ....mechanism.edit import HEADS, Layout, apply_overrides, number_at, read_dimension
from .geometry import Sources, layout


def read_values(sources: Sources, paths: Sequence[str]) -> tuple[float, ...]:
    """Values that a model has at some paths.

    Raises:
        UnknownNameError: A path leads nowhere.
        ModelError: There is no number.
    """
    found = layout(sources)
    return tuple(_read(sources, found, path) for path in paths)


def with_values(sources: Sources, values: Mapping[str, float]) -> Sources:
    """Change numbers of a model; it stays assembled.

    Raises:
        UnknownNameError: A path leads nowhere.
        ModelError: A value cannot be used.
    """
    document, urdf = apply_overrides(
        sources.document, sources.urdf, values, f"{sources.name}.toml", f"{sources.name}.urdf"
    )
    return Sources(name=sources.name, urdf=urdf, document=document, folder=sources.folder)


def no_machine(tried: str, own: str) -> SimulationError:
    """The error of numbers none of which makes a machine that can be simulated.

    Args:
        tried: What was tried, in words.
        own: Why the model's own numbers make none, wherever its bounds are; empty if they do.
    """
    found = f"none of {tried} is a machine that can be simulated"
    if own:
        message = f"{found}, nor is the model as it is: {own}; change that first"
        return SimulationError(message, why=own)
    return SimulationError(f"{found}; the model as it is can: put its numbers within the bounds")


def _read(sources: Sources, found: Layout, path: str) -> float:
    steps = path.split(".")
    if steps[0] in HEADS:
        return read_dimension(found, path, f"{sources.name}.urdf")
    return number_at(sources.document, path, f"{sources.name}.toml")
