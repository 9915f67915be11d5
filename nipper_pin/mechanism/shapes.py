"""Collision shapes of a loaded mechanism."""

from __future__ import annotations

from pathlib import Path

import pinocchio as pin

from .mechanism import Mechanism


def collision_model(mechanism: Mechanism) -> tuple[pin.GeometryModel, dict[str, tuple[str, ...]]]:
    """Collision shapes of a mechanism, for checks of clearance.

    Returns:
        Geometry model without any collision pairs, its objects named like the collision elements
        of the URDF, and these names by link.
    """
    # The URDF is read again here, and a run that looks at no shape needs no parser.
    from .build.tree import collision_geometry
    from .files.urdf import check_urdf, parse_xml

    file, folder = f"{mechanism.name}.urdf", Path(mechanism.mesh_folder)
    urdf = check_urdf(parse_xml(mechanism.urdf, file), file, folder)
    geometry = collision_geometry(mechanism.model, urdf, file)
    return geometry, dict(urdf.shapes)
