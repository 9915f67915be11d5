"""Faces and edges of solids in side view, in the order of their depth (painter's algorithm).

All motion is parallel to the plane of the mechanism, so depth and shading are constant: both are
computed once, and only the corners move from picture to picture.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull

from ...arrays import FloatArray
from .film import Film
from .meshes import read_mesh
from .solids import CYLINDER, Colour, Solid, cylinder_axis

_CORNERS = 32  # of a circle
_RINGS = 9  # of a sphere, from pole to pole
_DARKEST = 0.55  # of a face that is seen from its edge, by its colour
_FLAT = 0.02  # share of its normal that a face turns to the eye; with less it is seen from its edge


@dataclass(frozen=True, eq=False)
class Flat:
    """Faces and edges of all solids, in the order in which they are drawn.

    Attributes:
        points: Corners in the frame of their body (x, z), shape (N, 2) [m]; of the cylinder and
            the frame in the world.
        body: Place of the body of each corner in ``mechanism.joints``, or one of ``FIXED`` and
            ``CYLINDER``, shape (N,).
        shrink: Corners of springs move by this (x, z) for each metre of their coordinate, (N, 2).
        spring: Place of that coordinate in q, shape (N,); 0 for corners that are of no spring.
        items: Corners of each face (three) or edge (two), far ones first.
        solid: Place of the solid of each item, shape (items,).
        light: Brightness of each item, shape (items,); 0 for edges.
    """

    points: FloatArray
    body: NDArray[np.intp]
    shrink: FloatArray
    spring: NDArray[np.intp]
    items: tuple[tuple[int, ...], ...]
    solid: NDArray[np.intp]
    light: FloatArray


def flat(shown: Film, drawn: Sequence[Solid]) -> Flat:
    """Return the visible faces and edges of solids in side view.

    Args:
        shown: The film.
        drawn: What the mechanism is drawn with.

    Raises:
        InputError: A mesh cannot be read.
    """
    system = shown.solution.system.body
    heights = [float(item.translation[1]) for item in system.placements(shown.drawn[0])]
    points, shrink, body, spring = [], [], [], []
    items: list[tuple[int, ...]] = []
    solid, light, depth = [], [], []
    first = 0
    for place, item in enumerate(drawn):
        corners, faces = mesh_of(item)
        turned = item.placement[:3, :3]
        at = (corners * item.scale) @ turned.T + item.placement[:3, 3]
        if np.prod(item.scale) < 0.0:
            faces = faces[:, ::-1]
        faces, lean = _seen(at, faces)
        far = at[:, 1] + (heights[item.body] if item.body >= 0 else 0.0)
        edges = _border(faces)
        points.append(at[:, [0, 2]])
        along = turned[[0, 2], 2] * corners[:, 2:]
        shrink.append(-along if item.spring is not None else np.zeros_like(along))
        body.append(np.full(len(at), item.body))
        spring.append(np.full(len(at), item.spring or 0))
        for group, shade in ((faces, _DARKEST + (1.0 - _DARKEST) * lean), (edges, 0.0)):
            items += (tuple(row) for row in (group + first).tolist())
            depth.append(far[group].mean(axis=1))
            light.append(np.broadcast_to(shade, len(group)))
            solid.append(np.full(len(group), place))
        first += len(at)
    # At equal depth edges follow faces: the edges of a plate's front lie in its plane.
    every, bright = np.concatenate(depth), np.concatenate(light)
    order = np.lexsort((bright == 0.0, -every.round(6)))
    return Flat(
        points=np.concatenate(points),
        body=np.concatenate(body),
        shrink=np.concatenate(shrink),
        spring=np.concatenate(spring),
        items=tuple(items[place] for place in order),
        solid=np.concatenate(solid)[order],
        light=bright[order],
    )


def moved(seen: Flat, shown: Film, frame: int) -> FloatArray:
    """Corners in one frame of a film.

    Args:
        seen: The solids.
        shown: The film.
        frame: Place of the frame.

    Returns:
        Corners in the world (x, z), shape (N, 2) [m].
    """
    local = seen.points + seen.shrink * shown.drawn[frame][seen.spring, None]
    axis = cylinder_axis(shown.solution.mechanism)
    if axis is not None:
        local = local - np.where((seen.body == CYLINDER)[:, None], axis, 0.0)
    return placed(shown, frame, seen.body, local)


def placed(shown: Film, frame: int, body: NDArray[np.intp] | int, local: FloatArray) -> FloatArray:
    """Points of bodies in one frame of a film.

    Args:
        shown: The film.
        frame: Place of the frame.
        body: Place of each point's body as in ``Flat``, shape (N,) or one for all.
        local: Points in the frame of their body (x, z), shape (N, 2) [m].

    Returns:
        Points in the world (x, z), shape (N, 2) [m].
    """
    axis = cylinder_axis(shown.solution.mechanism) or (0.0, 0.0)
    # Cylinder and frame come last, where their negative indices find them.
    angle = np.concatenate([shown.angle[frame], [shown.turned[frame], 0.0]])[body]
    origin = np.concatenate([shown.position[frame], [axis, (0.0, 0.0)]])[body]
    cos, sin = np.cos(angle), np.sin(angle)
    x, z = local.T
    return np.asarray(np.column_stack([cos * x - sin * z, sin * x + cos * z]) + origin)


def colours(seen: Flat, drawn: Sequence[Solid], opening: Sequence[int], phase: Colour) -> list[str]:
    """Colour of each item as in #RRGGBB.

    Args:
        seen: The solids.
        drawn: What the mechanism is drawn with.
        opening: Bodies that have the colour of the phase instead of their own.
        phase: That colour.
    """
    own = np.array([phase if item.body in opening else item.colour for item in drawn])
    shaded = np.rint(255.0 * np.clip(own[seen.solid] * seen.light[:, None], 0.0, 1.0))
    return [f"#{red:02x}{green:02x}{blue:02x}" for red, green, blue in shaded.astype(int).tolist()]


def _seen(at: FloatArray, faces: NDArray[np.intp]) -> tuple[NDArray[np.intp], FloatArray]:
    """Faces that are turned to the eye, which looks along y, and how far each is (0 to 1)."""
    a, b, c = (at[faces[:, place]] for place in range(3))
    normal = np.cross(b - a, c - a)
    size = np.linalg.norm(normal, axis=1)
    towards = -normal[:, 1] / np.where(size > 0.0, size, 1.0)
    front = towards > _FLAT
    return faces[front], towards[front]


def _border(faces: NDArray[np.intp]) -> NDArray[np.intp]:
    """Edges that only one of the faces has, shape (E, 2)."""
    pairs = np.sort(faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    unique, count = np.unique(pairs, axis=0, return_counts=True)
    return np.asarray(unique[count == 1])


def mesh_of(solid: Solid) -> tuple[FloatArray, NDArray[np.intp]]:
    """Corners, shape (N, 3) [m], and faces, shape (F, 3), counter-clockwise from outside.

    Args:
        solid: The solid.

    Raises:
        InputError: Its mesh cannot be read.
    """
    if solid.path is not None:
        return read_mesh(solid.path)
    corners = _surface(solid)
    hull = ConvexHull(corners)
    faces = hull.simplices.astype(np.intp)
    a, b, c = (corners[faces[:, place]] for place in range(3))
    inwards = np.einsum("ij,ij->i", np.cross(b - a, c - a), hull.equations[:, :3]) < 0.0
    faces[inwards] = faces[inwards, ::-1]
    return corners, faces


def _surface(solid: Solid) -> FloatArray:
    """Points whose convex hull is a plain shape, shape (N, 3) [m]."""
    if solid.kind == "box":
        signs = np.array(np.meshgrid([-0.5, 0.5], [-0.5, 0.5], [-0.5, 0.5])).reshape(3, -1).T
        return np.asarray(signs * solid.sizes)
    turn = np.linspace(0.0, 2.0 * np.pi, _CORNERS, endpoint=False)
    circle = np.column_stack([np.cos(turn), np.sin(turn), np.zeros(_CORNERS)])
    if solid.kind == "cylinder":
        radius, length = solid.sizes
        lift = np.array([0.0, 0.0, 0.5 * length])
        return np.concatenate([radius * circle - lift, radius * circle + lift])
    polar = np.linspace(0.0, np.pi, _RINGS + 2)[1:-1]
    rings = [np.sin(item) * circle + [0.0, 0.0, np.cos(item)] for item in polar]
    poles = np.array([[0.0, 0.0, -1.0], [0.0, 0.0, 1.0]])
    return np.asarray(solid.sizes[0] * np.concatenate([*rings, poles]))
