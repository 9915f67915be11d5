"""Types of the values of a model's TOML file, with their limits."""

from __future__ import annotations

from typing import Annotated

import msgspec
from msgspec import Meta

from ...given import LARGEST as LARGEST

Positive = Annotated[float, Meta(gt=0.0)]
NotNegative = Annotated[float, Meta(ge=0.0)]
# "instead" ends the refusal of another number.
_FALLING = {"instead": "a force that does not rise is given by the rows of a table on a joint"}
Stiffness = Annotated[float, Meta(gt=0.0, le=LARGEST, extra=_FALLING)]
Damping = Annotated[float, Meta(ge=0.0, le=LARGEST)]
Length = Annotated[float, Meta(ge=0.0, le=LARGEST)]
Restitution = Annotated[float, Meta(ge=0.0, le=1.0)]
# Round-off of an angle grows with it: after ten turns it is still below 1e-14 of a turn.
ShaftAngle = Annotated[float, Meta(ge=-3600.0, le=3600.0)]
Index = Annotated[float, Meta(ge=0.0, lt=40.0)]
Name = Annotated[str, Meta(min_length=1)]
PlanePoint = tuple[float, float]


class TomlTable(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A TOML table whose keys are all known."""
