"""From the force elements of a model file to force laws on coordinates."""

from __future__ import annotations

from collections.abc import Mapping

from ...errors import InputError, ModelError, UnknownNameError
from ..forces import ForceTable, JointForce
from ..parts import Joint


def build_forces(
    tables: Mapping[str, ForceTable], joints: Mapping[str, Joint], file: str
) -> tuple[JointForce, ...]:
    """Build the force elements.

    Raises:
        UnknownNameError: A joint does not exist.
        ModelError: The law does not act on such a joint, or the values make no law.
    """
    found = []
    for name, table in tables.items():
        where, kind = f"forces.{name}", str(type(table).__struct_config__.tag)
        if table.joint not in joints:
            place = f"{file}: {where}.joint"
            raise UnknownNameError(kind="joint", name=table.joint, known=joints, where=place)
        joint = joints[table.joint]
        if joint.kind not in table.acts_on:
            allowed = f"{kind} acts on a joint that is {' or '.join(table.acts_on)}"
            raise ModelError(file=file, key=f"{where}.joint", value=table.joint, allowed=allowed)
        try:
            law = table.build(joint.kind)
        except InputError as error:
            key = str(error.evidence.get("key", "law"))
            raise ModelError(
                file=file,
                key=f"{where}.{key}",
                value=getattr(table, key, kind),
                allowed=error.message,
            ) from error
        found.append(JointForce(name=name, kind=kind, index=joint.index, law=law))
    return tuple(found)
