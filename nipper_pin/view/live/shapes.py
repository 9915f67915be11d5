"""Meshes of solids, with no more triangles than a picture needs."""

from __future__ import annotations

import manifold3d
import numpy as np
import trimesh

from ..scene import Solid
from ..scene.meshes import read_mesh

_CYLINDER_SECTIONS = 48


def shape(solid: Solid) -> trimesh.Trimesh:
    """The mesh of a drawn solid, in its own frame and before it is scaled.

    Raises:
        InputError: The mesh cannot be read.
    """
    mesh: trimesh.Trimesh
    if solid.path is not None:
        mesh = trimesh.Trimesh(*read_mesh(solid.path))
    elif solid.kind == "box":
        mesh = trimesh.creation.box(extents=solid.sizes)
    elif solid.kind == "sphere":
        mesh = trimesh.creation.icosphere(radius=solid.sizes[0])
    else:
        radius, length = solid.sizes
        mesh = trimesh.creation.cylinder(radius=radius, height=length, sections=_CYLINDER_SECTIONS)
    return mesh


def coarse(mesh: trimesh.Trimesh, tolerance: float) -> trimesh.Trimesh:
    """A solid with fewer triangles, or the mesh itself where that is not possible.

    Args:
        tolerance: How far its surface may be moved, more or less, in the units of the mesh.
    """
    body = manifold3d.Manifold(
        manifold3d.Mesh(mesh.vertices.astype(np.float32), mesh.faces.astype(np.uint32))
    )
    made = body.simplify(tolerance).to_mesh()
    # A surface with holes is none to manifold3d.
    if body.status() != manifold3d.Error.NoError or not len(made.tri_verts):
        return mesh
    thin = trimesh.Trimesh(made.vert_properties[:, :3], made.tri_verts)
    # A lip that is thinner than the tolerance is cut off whole, however far it reaches.
    return mesh if np.abs(thin.bounds - mesh.bounds).max() > tolerance else thin
