"""Checks of the whole mechanism in its touch configuration, from static placements only."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from ...arrays import FloatArray
from ...errors import AssemblyError, ModelError
from ...tolerances.mechanics import ASSEMBLY_TOLERANCE_M, DEPENDENT_SHARE, RANK_TOLERANCE
from ...units import MM_PER_M
from ..drives import OscillatingGuide
from ..files.urdf_parts import Urdf, side_view_text
from ..parts import Closure, Coupling, Drive, Joint, Phase, Stop
from ..scale import reach, unit_of, units_of, written
from .closures import PLANE, frame_point
from .placements import supports
from .tree import Tree


def closure_jacobian(
    closures: Sequence[Closure],
    joints: Sequence[Joint],
    urdf: Urdf,
    model: pin.Model,
    placements: list[pin.SE3],
) -> FloatArray:
    """Jacobian of the closure gaps at q = 0.

    Args:
        joints: The tree joints in the order of their coordinates.
        urdf: The checked URDF.
        placements: World placement of every joint at q = 0.

    Returns:
        Rows x, z of each closure in turn, shape (2 closures, joints).
    """
    rows = [
        _point_jacobian(closure.frame_b, joints, urdf, model, placements)
        - _point_jacobian(closure.frame_a, joints, urdf, model, placements)
        for closure in closures
    ]
    return np.array(rows).reshape(-1, len(joints))


def _point_jacobian(
    frame: str,
    joints: Sequence[Joint],
    urdf: Urdf,
    model: pin.Model,
    placements: list[pin.SE3],
) -> FloatArray:
    """Planar Jacobian of a frame's origin at q = 0, shape (2, joints)."""
    point = frame_point(frame, model, placements)
    moving = supports(model, model.frames[model.getFrameId(frame, pin.FrameType.BODY)].parentJoint)
    jacobian = np.zeros((3, len(joints)))
    for column, joint in enumerate(joints):
        identity = model.getJointId(joint.name)
        if identity not in moving:
            continue
        axis = placements[identity].rotation @ np.array(urdf.joints[joint.name].axis)
        if joint.kind == "revolute":
            axis = np.cross(axis, point - placements[identity].translation)
        jacobian[:, column] = axis
    return jacobian[PLANE, :]


class Constraints(NamedTuple):
    """What holds the coordinates of a mechanism.

    Attributes:
        couplings: The joints that follow others.
        drives: The driven joints.
        jacobian: Of closures and couplings in the touch configuration, by coordinates in their
            units, shape (rows, nv).
    """

    closures: Sequence[Closure]
    couplings: Sequence[Coupling]
    drives: Sequence[Drive]
    stops: tuple[Stop, ...]
    jacobian: FloatArray


def held_by(
    tree: Tree,
    closures: Sequence[Closure],
    couplings: Sequence[Coupling],
    drives: Sequence[Drive],
    stops: tuple[Stop, ...],
) -> Constraints:
    """What holds the coordinates of a tree, with the Jacobian of closures and couplings."""
    joints = tree.joints
    jacobian = closure_jacobian(closures, joints, tree.urdf, tree.model, tree.placements)
    followers = _unit([item.index for item in couplings], len(joints))
    leaders = _unit([item.of for item in couplings], len(joints))
    multipliers = np.array([item.multiplier for item in couplings]).reshape(-1, 1)
    jacobian = np.vstack([jacobian, followers - multipliers * leaders])
    units = units_of(joints, unit_of(reach(tree.model, joints, stops)))
    return Constraints(closures, couplings, drives, stops, jacobian * units)


def check_assembly(
    tree: Tree, held: Constraints, phases: Sequence[Phase], degrees_of_freedom: int
) -> None:
    """Check that the mechanism, which is closed, moves as stated and can be driven.

    Args:
        phases: The working phases.
        degrees_of_freedom: Mobility stated in the TOML file.

    Raises:
        AssemblyError: Closures have redundant rows.
        ModelError: The mobility is not the stated one, a guide does not stand on its joint, or
            drives or stops contradict the closures.
    """
    joints, file = tree.joints, tree.file
    closures, couplings, drives, stops, jacobian = held
    within_m = ASSEMBLY_TOLERANCE_M * written(unit_of(reach(tree.model, joints, stops)))
    names = [f"{closure.name} {axis}" for closure in closures for axis in "xz"]
    names += [f"mimic of joint {item.name}" for item in couplings]
    redundant = dependent_rows(jacobian, names)
    if redundant:
        raise AssemblyError(
            file=file,
            key="closures",
            value=redundant,
            allowed="each closure row must restrain the mechanism in its own way at touch; these "
            f"depend on one another (a pin closed twice, or a dead centre){_seen(tree)}",
        )
    _check_mobility(joints, held, degrees_of_freedom, file)
    _check_guides(drives, tree, within_m)
    _check_drives(jacobian, names, drives, joints, file)
    _check_phases(jacobian, names, drives, stops, phases, file)


def _seen(tree: Tree) -> str:
    """How a machine was turned into the side view, which may tell why it does not fit."""
    return f"; {side_view_text(tree.urdf)}" if tree.urdf.plane.turned else ""


def dependent_rows(matrix: FloatArray, names: Sequence[str]) -> list[str]:
    """Names of the rows that take part in a linear dependence; empty if there is none.

    Args:
        matrix: Rows of any scale, shape (rows, columns).
        names: Name of each row.
    """
    if not len(matrix):
        return []
    length = np.linalg.norm(matrix, axis=1, keepdims=True)
    left, values, _ = np.linalg.svd(matrix / np.where(length > 0.0, length, 1.0))
    rank = int(np.count_nonzero(values > RANK_TOLERANCE))
    share = np.abs(left[:, rank:]).max(axis=1, initial=0.0)
    return [name for name, part in zip(names, share, strict=True) if part > DEPENDENT_SHARE]


def _check_mobility(joints: Sequence[Joint], held: Constraints, stated: int, file: str) -> None:
    """Compare the mobility with the stated one; the rows are known to be independent."""
    closures = held.closures
    found = len(joints) - 2 * len(closures) - len(held.couplings)
    if found == stated:
        return
    names = ", ".join(closure.name for closure in closures) or "none"
    slots = sum(closure.slot_frame is not None for closure in closures)
    blocks = f" ({slots} of them blocks in slots)" if slots else ""
    followers = ", ".join(item.name for item in held.couplings)
    mimics = f" and one for each joint that mimics another ({followers})" if followers else ""
    raise ModelError(
        file=file,
        key="degrees_of_freedom",
        value=stated,
        allowed=f"the model has {found}: {len(joints)} tree joints{blocks} less two rows for each "
        f"of {len(closures)} closures ({names}){mimics}; correct the number, or add or remove a "
        "closure",
    )


def _check_guides(drives: Sequence[Drive], tree: Tree, within_m: float) -> None:
    """Refuse a guide whose axis is not that of the joint it drives."""
    for drive in drives:
        if not isinstance(drive.law, OscillatingGuide):
            continue
        joint = tree.joints[drive.index]
        identity = tree.model.getJointId(joint.name)
        stands = tree.placements[identity].translation[list(PLANE)]
        apart = float(np.hypot(*(np.array(drive.law.guide_axis) - stands)))
        if apart > within_m:
            x, z = MM_PER_M * stands
            raise ModelError(
                file=tree.file,
                key=f"drives.{drive.name}.guide_axis_mm",
                value=[round(MM_PER_M * place, 9) for place in drive.law.guide_axis],
                allowed=f"the place of the joint {joint.name} that the guide turns, "
                f"[{x:.9g}, {z:.9g}], within {MM_PER_M * within_m:g} mm; it stands "
                f"{MM_PER_M * apart:.6g} mm away; points.{joint.name}.x_mm and z_mm move both",
            )


def _unit(indices: Sequence[int], size: int) -> FloatArray:
    """Rows of the unit matrix, shape (indices, size)."""
    return np.eye(size)[list(indices)].reshape(-1, size)


def _check_drives(
    jacobian: FloatArray,
    names: Sequence[str],
    drives: Sequence[Drive],
    joints: Sequence[Joint],
    file: str,
) -> None:
    """Refuse drives that depend on the closures or on one another."""
    driven = _unit([drive.index for drive in drives], len(joints))
    labels = [*names, *(f"drive {drive.name}" for drive in drives)]
    clash = dependent_rows(np.vstack([jacobian, driven]), labels)
    if clash:
        raise ModelError(
            file=file,
            key="drives",
            value=clash,
            allowed="the driven joints must be free to move independently of one another",
        )


def _check_phases(
    jacobian: FloatArray,
    names: Sequence[str],
    drives: Sequence[Drive],
    stops: Sequence[Stop],
    phases: Sequence[Phase],
    file: str,
) -> None:
    """Refuse a phase whose closed stops contradict closures and drives."""
    size = jacobian.shape[1]
    driven = _unit([drive.index for drive in drives], size)
    labels = [*names, *(f"drive {drive.name}" for drive in drives)]
    for place, phase in enumerate(phases):
        # Those that close with another hold nothing more.
        closed = [stop for stop in stops if stop.name in phase.closed and not stop.leader]
        rows = np.vstack([jacobian, driven, _unit([stop.index for stop in closed], size)])
        clash = dependent_rows(rows, [*labels, *(f"stop {stop.name}" for stop in closed)])
        if clash:
            raise ModelError(
                file=file,
                key=f"phases[{place}].closed",
                value=sorted(phase.closed),
                allowed="closed stops must leave the drives free to move; these contradict one "
                f"another: {', '.join(clash)}",
            )
