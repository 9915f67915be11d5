"""The Pinocchio model of the tree, and where its bodies and frames stand at q = 0."""

from __future__ import annotations

from typing import NamedTuple

import coal
import numpy as np
import pinocchio as pin

from ...errors import ModelError
from ..files.urdf_parts import Urdf, UrdfJoint
from ..files.urdf_shapes import UrdfShape, check_corners, check_size
from ..parts import Joint
from .placements import own_name

_ALONG_AXES = {
    (1.0, 0.0, 0.0): pin.JointModelPX,
    (0.0, 0.0, 1.0): pin.JointModelPZ,
}


class Tree(NamedTuple):
    """The tree of a model, and where its messages come from.

    Attributes:
        joints: The tree joints in the order of their coordinates.
        placements: World placement of every joint at q = 0.
        geometry: Collision shapes named like their elements; without any if no stop has a contact.
        file: Name of the TOML file, for messages.
    """

    model: pin.Model
    joints: tuple[Joint, ...]
    placements: list[pin.SE3]
    urdf: Urdf
    geometry: pin.GeometryModel
    file: str
    urdf_file: str


def build_model(urdf: Urdf, gravity_m_s2: float, file: str) -> pin.Model:
    """Build the Pinocchio model of a URDF, with gravity along -z."""
    model = pin.Model()
    body = pin.FrameType.BODY
    places = {urdf.root: model.addFrame(pin.Frame(urdf.root, 0, 0, pin.SE3.Identity(), body))}
    # Depth first: added in another order, joints give wrong dynamics without any error.
    for joint in urdf.downwards():
        above = model.frames[places[joint.parent]]
        identity, at = above.parentJoint, above.placement * joint.placement
        if joint.kind != "fixed":
            identity = model.addJoint(identity, _joint_model(joint), at, joint.name)
            model.addJointFrame(identity)
            at = pin.SE3.Identity()
        inertia = urdf.links[joint.child].inertia
        if inertia is not None:
            model.appendBodyToJoint(identity, inertia, at)
        frame = pin.Frame(joint.child, identity, places[joint.parent], at, body)
        places[joint.child] = model.addFrame(frame, False)
    for link, axes in urdf.own_axes.items():
        frame = model.frames[places[link]]
        add_own_frame(model, link, frame.placement * pin.SE3(axes, np.zeros(3)))
    _check_bodies(model, urdf, file)
    model.gravity.linear = np.array([0.0, 0.0, -gravity_m_s2])
    model.gravity.angular = np.zeros(3)
    return model


def add_own_frame(model: pin.Model, link: str, at: pin.SE3) -> None:
    """Add the frame of a link as the file has it, for what is only drawn."""
    frame = model.frames[model.getFrameId(link, pin.FrameType.BODY)]
    own = pin.Frame(
        own_name(link), frame.parentJoint, frame.parentFrame, at, pin.FrameType.OP_FRAME
    )
    model.addFrame(own, False)


def _joint_model(joint: UrdfJoint) -> pin.JointModel:
    """Pinocchio's model of a joint that moves."""
    if joint.kind == "revolute":
        return pin.JointModelRevoluteUnaligned(np.array(joint.axis))
    along = _ALONG_AXES.get(joint.axis)
    return pin.JointModelPrismaticUnaligned(np.array(joint.axis)) if along is None else along()


def _check_bodies(model: pin.Model, urdf: Urdf, file: str) -> None:
    """Every joint moves links that resist; those fixed to one another are one body."""
    for name, inertia in zip(model.names, model.inertias, strict=True):
        if name == "universe":
            continue
        joint = urdf.joints[name]
        if inertia.mass == 0.0:
            allowed = "a moving link needs mass and inertia, its own or of links fixed to it"
            raise ModelError(
                file=file, key=f"link {joint.child} inertial", value=None, allowed=allowed
            )
        x, _, z = inertia.lever.tolist()
        about_hinge = float(inertia.inertia[1, 1]) + inertia.mass * (x * x + z * z)
        if joint.kind == "revolute" and about_hinge <= 0.0:
            allowed = f"an inertia about the axis of joint {name} above 0 kg m2"
            raise ModelError(
                file=file, key=f"link {joint.child} inertia", value=about_hinge, allowed=allowed
            )


def tree_joints(model: pin.Model, urdf: Urdf) -> tuple[Joint, ...]:
    """Tree joints in the order of their coordinates."""
    return tuple(
        Joint(
            name=source.name,
            kind="prismatic" if source.kind == "prismatic" else "revolute",
            parent=source.parent,
            child=source.child,
            index=model.joints[identity].idx_v,
            sense=-source.axis[1] or 1.0,
        )
        for identity in range(1, model.njoints)
        if (source := urdf.joints[model.names[identity]])
    )


def collision_geometry(model: pin.Model, urdf: Urdf, file: str) -> pin.GeometryModel:
    """Collision shapes of all links.

    Returns:
        Geometry model whose objects carry the names of the collision elements.
    """
    geometry = pin.GeometryModel()
    paths = [shape.path for link in urdf.links.values() for shape in link.shapes if shape.path]
    check_size(paths, "collision meshes", file)
    for name, link in urdf.links.items():
        identity = model.getFrameId(name, pin.FrameType.BODY)
        frame = model.frames[identity]
        for shape in link.shapes:
            at = frame.placement * shape.placement
            solid = _solid(shape, f"link {name} collision {shape.name}", file)
            words = () if shape.path is None else (str(shape.path), np.array(shape.sizes))
            geometry.addGeometryObject(
                pin.GeometryObject(shape.name, frame.parentJoint, identity, at, solid, *words)
            )
    return geometry


def _solid(shape: UrdfShape, key: str, file: str) -> coal.CollisionGeometry:
    """The shape itself."""
    if shape.path is None:
        kinds = {"box": coal.Box, "cylinder": coal.Cylinder, "sphere": coal.Sphere}
        return kinds[shape.kind](*shape.sizes)
    try:
        mesh = coal.MeshLoader().load(str(shape.path), np.array(shape.sizes))
    except (ValueError, RuntimeError) as error:
        reason = str(error).partition("message: ")[2] or str(error)
        allowed = "collision meshes that can be read: STL, OBJ or DAE with vertices and faces"
        value = " ".join(reason.split())
        raise ModelError(file=file, key="collision mesh", value=value, allowed=allowed) from error
    check_corners(mesh.vertices(), key, file)
    return mesh
