"""Named tuples in memory: compiled functions hand on their place.

Those of the kernels have more than a hundred numbers, shapes and strides of their arrays, which
would be handed from call to call: a tenth of the time of a first use, and of a turn.
"""

from __future__ import annotations

from typing import Any, TypeVar

from numba.core import cgutils, types
from numba.core.imputils import lower_getattr_generic
from numba.core.typing.templates import AttributeTemplate, infer_getattr
from numba.extending import lower_builtin, models, register_model, type_callable

_Value = TypeVar("_Value")


def in_memory(value: _Value) -> _Value:
    """A named tuple as its place in the memory of the function that calls this.

    The place ends with that function, and keeps no array alive: whoever calls it has them.
    """
    return value


class _Place(types.Type):  # type: ignore[misc]
    """The type of such a place."""

    def __init__(self, value: types.NamedTuple) -> None:
        self.value = value
        super().__init__(name=f"Place({value})")


@register_model(_Place)
class _PlaceModel(models.PrimitiveModel):  # type: ignore[misc]
    """A pointer."""

    def __init__(self, manager: Any, place_type: _Place) -> None:
        kind = manager.lookup(place_type.value).get_value_type()
        super().__init__(manager, place_type, kind.as_pointer())


@type_callable(in_memory)  # type: ignore[untyped-decorator]
def _type_of_place(_context: Any) -> Any:
    return lambda value: _Place(value)


@lower_builtin(in_memory, types.NamedTuple)  # type: ignore[untyped-decorator]
def _hold(_context: Any, builder: Any, _signature: Any, values: Any) -> Any:
    return cgutils.alloca_once_value(builder, values[0])


@infer_getattr
class _Members(AttributeTemplate):  # type: ignore[misc]
    """Types of the members, by their names."""

    key = _Place

    def generic_resolve(self, place_type: _Place, name: str) -> Any:
        """As of the tuple."""
        value = place_type.value
        return value.types[value.fields.index(name)] if name in value.fields else None


@lower_getattr_generic(_Place)  # type: ignore[untyped-decorator]
def _member(_context: Any, builder: Any, place_type: _Place, place: Any, name: str) -> Any:
    number = place_type.value.fields.index(name)
    return builder.load(cgutils.gep_inbounds(builder, place, 0, number))
