"""Points and shapes of the E62 in the plane of the mechanism, and solids built from outlines."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Sequence
from pathlib import Path
from xml.etree import ElementTree

import manifold3d
import numpy as np
import trimesh
from numpy.typing import NDArray
from shapely import MultiPolygon, Point, Polygon, set_precision
from shapely.geometry.base import BaseGeometry
from shapely.ops import unary_union

Pair = tuple[float, float]
Vector = NDArray[np.float64]

ROUND = 14  # most straight pieces in a quarter of a circle
SAG = 5e-5  # of a chord below its circle: half the clearance of a pin in its hole
FINE = 0.002  # a radius below this is an edge that something else touches
COIL_STEPS, WIRE_STEPS = 14, 6  # straight pieces in a turn of the spring, and around its wire
TURNS, WIRE, COIL = 7.0, 0.0013, 0.0075  # spring: turns, radius of wire and of coil


class Model:
    """Points and collision shapes of the model, in the plane of the mechanism [m]."""

    def __init__(self, folder: Path) -> None:
        """Read URDF and TOML."""
        robot = ElementTree.parse(folder / f"{folder.name}.urdf").getroot()
        self.toml = tomllib.loads((folder / f"{folder.name}.toml").read_text(encoding="utf-8"))
        self.joint = {j.get("name", ""): _plane(j) for j in robot.findall("joint")}
        self._shape = {c.get("name", ""): c for c in robot.iter("collision")}

    def at(self, name: str) -> Pair:
        """Centre of a collision shape in its link (x, z)."""
        return _plane(self._shape[name])

    def disc(self, name: str, grow: float = 0.0) -> BaseGeometry:
        """Outline of a cylinder across the plane."""
        return disc(self.at(name), self.radius(name) + grow)

    def radius(self, name: str) -> float:
        """Radius of a cylinder."""
        return float(self._size(name).get("radius", "0"))

    def outline(self, name: str) -> Polygon:
        """Outline of a box."""
        length, _, height = (float(part) for part in self._size(name).get("size", "").split())
        return Polygon(self._lines(name, np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) / 2
                                   * [length, height]))  # fmt: skip

    def axis(self, name: str, along: float, across: float) -> Pair:
        """Point of a box or cylinder in its own axes (x, z)."""
        x, z = self._lines(name, np.array([[along, across]]))[0]
        return float(x), float(z)

    def width(self, name: str) -> Pair:
        """Range of a shape along y."""
        size = self._size(name)
        across = float((size.get("size") or f"0 {size.get('length')}").split()[1])
        y = float((self._shape[name].find("origin").get("xyz") or "").split()[1])  # type: ignore[union-attr]
        return y - across / 2, y + across / 2

    def _size(self, name: str) -> dict[str, str]:
        geometry = self._shape[name].find("geometry")
        return dict(next(iter(geometry)).attrib) if geometry is not None else {}

    def _lines(self, name: str, points: Vector) -> Vector:
        origin = self._shape[name].find("origin")
        pitch = float((origin.get("rpy") or "").split()[1]) if origin is not None else 0.0
        c, s = math.cos(pitch), math.sin(pitch)
        return np.asarray(points @ np.array([[c, -s], [s, c]]) + self.at(name))


def _plane(element: ElementTree.Element) -> Pair:
    origin = element.find("origin")
    x, _, z = (float(v) for v in (origin.get("xyz") if origin is not None else "0 0 0").split())  # type: ignore[union-attr]
    return x, z


def quarter(radius: float) -> int:
    """Straight pieces in a quarter of a circle [radius in m]."""
    if radius < FINE:
        return ROUND
    return min(ROUND, math.ceil(math.pi / 4.0 / math.acos(1.0 - SAG / radius)))


def disc(centre: Pair, radius: float) -> BaseGeometry:
    """Circle."""
    return Point(centre).buffer(radius, quad_segs=quarter(radius))


def bar(*discs: BaseGeometry) -> BaseGeometry:
    """Convex outline around shapes."""
    return unary_union(discs).convex_hull


def plate(outline: BaseGeometry, *widths: Pair) -> list[trimesh.Trimesh]:
    """Outline in the plane, extruded along y over each range."""
    # Slivers below a micrometre would leave triangles without area.
    outline = set_precision(outline, 1e-6)
    polygons = list(outline.geoms) if isinstance(outline, MultiPolygon) else [outline]
    solids = []
    for polygon in polygons:
        for low, high in widths:
            solid = trimesh.creation.extrude_polygon(polygon, high - low)
            # (x, z, depth) -> (x, high - depth, z): a rotation, so that faces keep their sides.
            solid.apply_transform(
                np.array([[1, 0, 0, 0], [0, 0, -1, high], [0, 1, 0, 0], [0, 0, 0, 1.0]])
            )
            solids.append(solid)
    return solids


def tube(a: Pair, b: Pair, y: float, outer: float, inner: float = 0.0, n: int | None = None
         ) -> trimesh.Trimesh:  # fmt: skip
    """Round bar or tube between two points of the plane at one y; n corners, or as many as suit."""
    n = n or 4 * quarter(outer)
    segment = [[a[0], y, a[1]], [b[0], y, b[1]]]
    made: trimesh.Trimesh = (
        trimesh.creation.annulus(inner, outer, segment=segment, sections=n)
        if inner
        else trimesh.creation.cylinder(outer, segment=segment, sections=n)
    )
    return made


def both(width: Pair) -> tuple[Pair, Pair]:
    """A range of y and its mirror image."""
    return width, (-width[1], -width[0])


def solid(*groups: Sequence[trimesh.Trimesh]) -> trimesh.Trimesh:
    """One closed solid out of overlapping ones."""
    made: trimesh.Trimesh = trimesh.boolean.union(
        [item for group in groups for item in group], engine="manifold"
    )
    # Corners closer than files in single precision can tell apart would tear the surface there.
    body = manifold3d.Manifold(
        manifold3d.Mesh(made.vertices.astype(np.float32), made.faces.astype(np.uint32))
    )
    clean = body.simplify(2e-6).to_mesh()
    return trimesh.Trimesh(clean.vert_properties[:, :3], clean.tri_verts)


def coil(length: float) -> trimesh.Trimesh:
    """Spring along z from 0 to 1, round when it is stretched to a length; ends closed, ground."""
    share = np.linspace(0.0, 1.0, int(TURNS * COIL_STEPS) + 1)
    angle = math.tau * TURNS * share
    # The last turn at each end lies flat, as that of a spring with closed ends does.
    rise = np.interp(share * TURNS, [0.0, 0.8, TURNS - 0.8, TURNS], [0.0, 0.07, 0.93, 1.0])
    height = WIRE + rise * (length - 2.0 * WIRE)
    # From the top of the wire, so that its corners reach both ends of the spring.
    around = 0.5 * math.pi + np.linspace(0.0, math.tau, WIRE_STEPS + 1)[:-1]
    out = COIL + WIRE * np.cos(around)
    points = np.stack([
        np.outer(np.cos(angle), out),
        np.outer(np.sin(angle), out),
        np.clip(height[:, None] + WIRE * np.sin(around), 0.0, length) / length,
    ], axis=-1).reshape(-1, 3)  # fmt: skip
    size, faces = len(around), []
    for i in range(len(share) - 1):
        for j in range(size):
            a, b = size * i + j, size * i + (j + 1) % size
            faces += [[a, a + size, b], [b, a + size, b + size]]
    last = len(points) - size
    faces += [[0, j, j + 1] for j in range(1, size - 1)]
    faces += [[last, last + j + 1, last + j] for j in range(1, size - 1)]
    mesh = trimesh.Trimesh(points, faces)
    mesh.fix_normals()
    return mesh
