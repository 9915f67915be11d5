"""The Pinocchio model of the tree, and where its bodies and frames stand at q = 0."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple
from xml.etree import ElementTree

import coal
import numpy as np
import pinocchio as pin

from ...errors import ModelError
from ...tolerances.mechanics import URDF_TOLERANCE
from ..files.meshes import check_corners, check_size
from ..files.urdf import Urdf
from ..files.urdf_values import mesh_path
from ..mechanism import Joint


class Tree(NamedTuple):
    """The tree of a model, and where its messages come from.

    Attributes:
        model: The Pinocchio model.
        joints: The tree joints in the order of their coordinates.
        placements: World placement of every joint at q = 0.
        urdf: The checked URDF.
        geometry: Collision shapes named like their elements; without any if no stop has a contact.
        file: Name of the TOML file.
        urdf_file: Name of the URDF file.
    """

    model: pin.Model
    joints: tuple[Joint, ...]
    placements: list[pin.SE3]
    urdf: Urdf
    geometry: pin.GeometryModel
    file: str
    urdf_file: str


def build_model(text: str, gravity_m_s2: float, file: str) -> pin.Model:
    """Build the Pinocchio model of a checked URDF.

    Args:
        text: The URDF.
        gravity_m_s2: Gravity along -z [m/s2].
        file: File name, for messages.

    Raises:
        ModelError: Pinocchio refuses the URDF.
    """
    if "continuous" in text:
        # Pinocchio gives an unbounded hinge two coordinates, cosine and sine, not one angle.
        text = _bounded(text)
    try:
        model = pin.buildModelFromXML(text)
    except (ValueError, RuntimeError) as error:
        raise ModelError(
            file=file,
            key="robot",
            value=f"{len(text)} characters",
            allowed=f"Pinocchio says: {error}",
        ) from error
    model.gravity.linear = np.array([0.0, 0.0, -gravity_m_s2])
    model.gravity.angular = np.zeros(3)
    return model


def check_masses(model: pin.Model, urdf: Urdf, file: str) -> None:
    """Compare what Pinocchio has read with what was checked: the mass that each joint moves.

    Args:
        model: The Pinocchio model.
        urdf: The checked URDF.
        file: File name, for messages.

    Raises:
        ModelError: They differ; Pinocchio reads an inertial that it does not understand as none.
    """
    above = {joint.child: joint for joint in urdf.joints.values()}
    moved = dict.fromkeys(model.names, 0.0)
    for link, mass in urdf.masses.items():
        joint = above.get(link)
        while joint is not None and joint.kind == "fixed":
            joint = above.get(joint.parent)
        if joint is not None:
            moved[joint.name] += mass
    for name, inertia in zip(model.names, model.inertias, strict=True):
        if name != "universe" and abs(inertia.mass - moved[name]) > URDF_TOLERANCE * moved[name]:
            allowed = f"{moved[name]:g} kg, which the links behind joint {name} have in the file"
            key = f"mass behind joint {name} in Pinocchio"
            raise ModelError(file=file, key=key, value=inertia.mass, allowed=allowed)


def _bounded(text: str) -> str:
    """Turn continuous joints into revolute ones with limits that never act."""
    root = ElementTree.fromstring(text)
    for joint in root.findall("joint"):
        if joint.get("type") != "continuous":
            continue
        joint.set("type", "revolute")
        limit = joint.find("limit")
        if limit is None:
            limit = ElementTree.SubElement(joint, "limit", effort="1e9", velocity="1e9")
        limit.set("lower", "-1e9")
        limit.set("upper", "1e9")
    return ElementTree.tostring(root, encoding="unicode")


def tree_joints(model: pin.Model, urdf: Urdf) -> tuple[Joint, ...]:
    """Tree joints in the order of their coordinates.

    Args:
        model: The Pinocchio model; it orders joints its own way.
        urdf: The checked URDF.
    """
    joints = []
    for identity in range(1, model.njoints):
        source = urdf.joints[model.names[identity]]
        if source.kind == "fixed":
            continue
        joints.append(
            Joint(
                name=source.name,
                kind=source.kind,
                parent=source.parent,
                child=source.child,
                index=model.joints[identity].idx_v,
            )
        )
    return tuple(sorted(joints, key=lambda joint: joint.index))


def collision_geometry(
    model: pin.Model, text: str, urdf: Urdf, mesh_folder: Path, file: str
) -> pin.GeometryModel:
    """Collision shapes of all links.

    Args:
        model: The Pinocchio model.
        text: The URDF, checked.
        urdf: The checked URDF.
        mesh_folder: Folder that relative mesh paths start from.
        file: File name, for messages.

    Returns:
        Geometry model whose objects carry the names of the collision elements.
    """
    # Pinocchio does not need meshes that are only drawn; their files may be missing.
    solids = (part.partition("</collision>")[0] for part in text.split("<collision")[1:])
    if any("<mesh" in solid for solid in solids):
        text, paths = _absolute_meshes(text, mesh_folder, file)
        check_size(paths, "collision meshes", file)
    try:
        geometry = pin.buildGeomFromUrdfString(model, text, pin.GeometryType.COLLISION)
    except (ValueError, RuntimeError) as error:
        reason = str(error).partition("message: ")[2] or str(error)
        allowed = "collision meshes that can be read: STL, OBJ or DAE with vertices and faces"
        value = " ".join(reason.split())
        raise ModelError(file=file, key="collision mesh", value=value, allowed=allowed) from error
    # Pinocchio numbers the shapes of each link in the order of the file.
    for link, names in urdf.shapes.items():
        for place, name in enumerate(names):
            identity = geometry.getGeometryId(f"{link}_{place}")
            if identity >= geometry.ngeoms:
                allowed = (
                    "a link whose shapes all can be read; the URDF parser left this one out, for "
                    "a wrong attribute of a mesh or an element in the wrong place"
                )
                raise ModelError(
                    file=file, key=f"link {link} collision", value=name, allowed=allowed
                )
            found = geometry.geometryObjects[identity]
            found.name = name
            if isinstance(found.geometry, coal.BVHModelBase):
                check_corners(found.geometry.vertices(), f"link {link} collision {name}", file)
    return geometry


def _absolute_meshes(text: str, mesh_folder: Path, file: str) -> tuple[str, list[Path]]:
    """Write absolute paths of collision meshes: Pinocchio resolves no others without a package."""
    root = ElementTree.fromstring(text)
    paths = []
    for mesh in root.iterfind(".//collision//mesh"):
        paths.append(mesh_path(mesh.get("filename", ""), mesh_folder, "mesh", file))
        mesh.set("filename", str(paths[-1]))
    return ElementTree.tostring(root, encoding="unicode"), paths
