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
from ..files.urdf_parts import side_view_text
from ..parts import Closure, Coupling, Drive, Joint, Phase, Stop
from ..scale import reach, unit_of, units_of, written
from .closures import PLANE
from .placements import supports
from .tree import Tree


class Loops:
    """Closures and couplings of a tree, by its coordinates in their units.

    Along the chains of their frames, without ``pin.Data``: that of a tree of thousands of joints
    takes gigabytes.
    """

    def __init__(
        self, tree: Tree, closures: Sequence[Closure], couplings: Sequence[Coupling], size_m: float
    ) -> None:
        """Find the frames; the size of the machine is its reach."""
        model = tree.model
        self._model, self._couplings = model, couplings
        self._pairs = [
            [model.frames[model.getFrameId(name, pin.FrameType.BODY)] for name in pair]
            for pair in ((item.frame_a, item.frame_b) for item in closures)
        ]
        self._axes = [pin.Motion.Zero()]
        self._axes += [pin.Motion(joint.createData().S) for joint in model.joints[1:]]
        self.units = units_of(tree.joints, unit_of(size_m))

    def rows(self, x: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Gaps, shape (rows,), x and z of each closure before all couplings; Jacobian, (rows, nv).

        Args:
            x: Coordinates in their units, shape (nv,); zero at touch.
        """
        q = self.units * x
        gaps, rows = list[FloatArray](), list[FloatArray]()
        for pair in self._pairs:
            (a, by_a), (b, by_b) = (self._point(frame, q) for frame in pair)
            gaps.append(b - a)
            rows.append(by_b - by_a)
        for item in self._couplings:
            row = np.zeros((1, len(q)))
            row[0, item.index], row[0, item.of] = 1.0, -item.multiplier
            gaps.append(row @ q)
            rows.append(row)
        if not rows:
            return np.empty(0), np.empty((0, len(q)))
        return np.concatenate(gaps), np.vstack(rows) * self.units

    def _point(self, frame: pin.Frame, q: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Place of a frame in the plane, shape (2,), and its Jacobian, shape (2, nv)."""
        at, moved = pin.SE3.Identity(), list[tuple[int, pin.Motion]]()
        for joint in reversed(supports(self._model, frame.parentJoint)):
            at, column = at * self._model.jointPlacements[joint], self._model.idx_vs[joint]
            moved.append((column, at.act(self._axes[joint])))
            at = at * pin.exp6(self._axes[joint] * q[column])
        x, _, z = (at * frame.placement).translation
        jacobian = np.zeros((2, len(q)))
        for column, motion in moved:
            (slide_x, _, slide_z), (_, turn, _) = motion.linear, motion.angular
            jacobian[:, column] = slide_x + turn * z, slide_z - turn * x
        return np.array([x, z]), jacobian


class Constraints(NamedTuple):
    """What holds the coordinates of a mechanism.

    Attributes:
        loops: Closures and couplings.
        jacobian: Theirs in the touch configuration, shape (rows, nv).
    """

    closures: Sequence[Closure]
    couplings: Sequence[Coupling]
    drives: Sequence[Drive]
    stops: tuple[Stop, ...]
    loops: Loops
    jacobian: FloatArray


def held_by(
    tree: Tree,
    closures: Sequence[Closure],
    couplings: Sequence[Coupling],
    drives: Sequence[Drive],
    stops: tuple[Stop, ...],
) -> Constraints:
    """What holds the coordinates of a tree, with the Jacobian of closures and couplings."""
    loops = Loops(tree, closures, couplings, reach(tree.model, tree.joints, stops))
    jacobian = loops.rows(np.zeros(len(tree.joints)))[1]
    return Constraints(closures, couplings, drives, stops, loops, jacobian)


def check_assembly(
    tree: Tree, held: Constraints, phases: Sequence[Phase], degrees_of_freedom: int
) -> None:
    """Check that the mechanism, which is closed, moves as stated and can be driven.

    Raises:
        AssemblyError: Closures have redundant rows.
        ModelError: The mobility is not the stated one, a guide does not stand on its joint, or
            drives or stops contradict the closures.
    """
    joints, file = tree.joints, tree.file
    closures, couplings, drives, stops, _, jacobian = held
    within_m = ASSEMBLY_TOLERANCE_M * written(unit_of(reach(tree.model, joints, stops)))
    names = [f"{closure.name} {axis}" for closure in closures for axis in "xz"]
    names += [f"mimic of joint {item.name}" for item in couplings]
    redundant = dependent_rows(jacobian, names)
    # How a machine was turned into the side view may tell why it does not fit.
    seen = f"; {side_view_text(tree.urdf)}" if tree.urdf.plane.turned else ""
    if redundant:
        raise AssemblyError(
            file=file,
            key="closures",
            value=redundant,
            allowed="each closure row must restrain the mechanism in its own way at touch; these "
            f"depend on one another (a pin closed twice, or a dead centre){seen}",
        )
    _check_mobility(joints, held, degrees_of_freedom, file)
    _check_guides(drives, tree, within_m)
    _check_freedom(held, names, phases, file)


def dependent_rows(matrix: FloatArray, names: Sequence[str]) -> list[str]:
    """Names of the rows that take part in a linear dependence; empty if there is none.

    Args:
        matrix: Rows of any scale, shape (rows, columns).
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


def _check_freedom(
    held: Constraints, names: Sequence[str], phases: Sequence[Phase], file: str
) -> None:
    """Refuse drives that depend on closures or on one another, and phases that leave them none."""
    size = held.jacobian.shape[1]
    driven = np.vstack([held.jacobian, _unit([drive.index for drive in held.drives], size)])
    labels = [*names, *(f"drive {drive.name}" for drive in held.drives)]
    clash = dependent_rows(driven, labels)
    if clash:
        raise ModelError(
            file=file,
            key="drives",
            value=clash,
            allowed="the driven joints must be free to move independently of one another",
        )
    for place, phase in enumerate(phases):
        # Those that close with another hold nothing more.
        closed = [stop for stop in held.stops if stop.name in phase.closed and not stop.leader]
        rows = np.vstack([driven, _unit([stop.index for stop in closed], size)])
        clash = dependent_rows(rows, [*labels, *(f"stop {stop.name}" for stop in closed)])
        if clash:
            raise ModelError(
                file=file,
                key=f"phases[{place}].closed",
                value=sorted(phase.closed),
                allowed="closed stops must leave the drives free to move; these contradict one "
                f"another: {', '.join(clash)}",
            )
