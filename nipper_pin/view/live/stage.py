"""The mechanism as solids of viser, and where they stand in one configuration."""

from __future__ import annotations

import math

import numpy as np
import pinocchio as pin
import trimesh
import viser
from numpy.typing import NDArray

from ...arrays import FloatArray
from ...dynamics.multibody import multibody
from ...errors import InputError
from ...mechanism import Mechanism
from ..scene.solids import CYLINDER, FIXED, Solid, cylinder_axis, solids

_CYLINDER_SECTIONS = 48
_LINE_COLOUR = (51, 51, 51)
_NEAR = 1.9  # distance of the camera by the size of the mechanism
_VIEW = math.radians(45.0)
_SUN = (-1.0, -3.0, 4.0)
_DIRECTION = (0.38, -1.0, 0.34)


class Stage:
    """Solids of a mechanism in the scene of a server.

    Args:
        server: The server.
        mechanism: The mechanism; springs and stops of others may differ, not the tree.

    Raises:
        InputError: A mesh cannot be read.
    """

    def __init__(self, server: viser.ViserServer, mechanism: Mechanism) -> None:
        """Put the solids in their places."""
        self._mechanism, self._body = mechanism, multibody(mechanism)
        axis = cylinder_axis(mechanism)
        self._axis = np.array([axis[0], 0.0, axis[1]]) if axis else np.zeros(3)
        scene = server.scene
        scene.set_up_direction("+z")
        # viser applies messages as it draws, so a picture that is dear to draw delays the numbers.
        # Its own lights, shadows and surroundings cost five times as much as these where a
        # processor draws.
        scene.configure_environment_map(hdri=None)
        scene.configure_default_lights(enabled=False)
        scene.add_light_ambient("/lights/ambient", intensity=1.6)
        scene.add_light_directional("/lights/sun", intensity=2.2, position=_SUN)
        names = {body: f"links/{joint.child}" for body, joint in enumerate(mechanism.joints)}
        names |= {FIXED: "frame", CYLINDER: "cylinder"}
        drawn = solids(mechanism)
        self._frames = {
            body: scene.add_frame(f"/{name}", show_axes=False) for body, name in names.items()
        }
        self._springs: list[tuple[viser.MeshHandle, Solid, int]] = []
        for solid in drawn:
            handle = self._add(server, f"/{names[solid.body]}/{solid.name}", solid)
            if solid.spring is not None:
                self._springs.append((handle, solid, solid.spring))
        self._lines = None
        if mechanism.struts:
            rest = self._ends(np.zeros(self._body.nv))
            self._lines = scene.add_line_segments("/struts", rest, _LINE_COLOUR)
        self._frames[CYLINDER].position = self._axis
        self._look(server)

    def pose(self, q: FloatArray, cylinder_angle: float) -> None:
        """Move everything to a configuration.

        Args:
            q: Configuration, shape (nv,) [rad or m].
            cylinder_angle: psi [rad].
        """
        for body, placement in enumerate(self._body.placements(q)):
            frame = self._frames[body]
            frame.position, frame.wxyz = placement.translation, _wxyz(placement.rotation)
        turned = 0.5 * (cylinder_angle - self._mechanism.cylinder.angle_at_touch_rad)
        # About -y, which is counter-clockwise in the side view.
        self._frames[CYLINDER].wxyz = (math.cos(turned), 0.0, -math.sin(turned), 0.0)
        for handle, solid, place in self._springs:
            x, y, z = (float(value) for value in solid.scale)
            handle.scale = (x, y, z - float(q[place]))
        if self._lines is not None:
            self._lines.points = self._ends(q)

    def rest(self) -> None:
        """Move everything to the touch configuration."""
        self.pose(np.zeros(self._body.nv), self._mechanism.cylinder.angle_at_touch_rad)

    def _ends(self, q: FloatArray) -> NDArray[np.float32]:
        """Both points of every strut, shape (struts, 2, 3) [m]."""
        places, _ = self._body.points(q[None])
        ends = np.zeros((len(self._mechanism.struts), 2, 3), dtype=np.float32)
        ends[:, :, [0, 2]] = places[0]
        return ends

    def _add(self, server: viser.ViserServer, path: str, solid: Solid) -> viser.MeshHandle:
        shape = _shape(solid)
        place = solid.placement[:3, 3].copy()
        if solid.body == CYLINDER:
            place -= self._axis
        red, green, blue = (round(255.0 * part) for part in solid.colour)
        return server.scene.add_mesh_simple(
            path,
            np.asarray(shape.vertices, dtype=np.float32),
            np.asarray(shape.faces, dtype=np.uint32),
            color=(red, green, blue),
            flat_shading=True,
            # A mirrored mesh shows the inside of its faces.
            side="double" if np.prod(solid.scale) < 0.0 else "front",
            cast_shadow=False,
            receive_shadow=False,
            scale=(float(solid.scale[0]), float(solid.scale[1]), float(solid.scale[2])),
            wxyz=_wxyz(solid.placement[:3, :3]),
            position=place,
        )

    def _look(self, server: viser.ViserServer) -> None:
        """Let new browsers look at all joints from front and above."""
        placements = self._body.placements(np.zeros(self._body.nv))
        points = np.array([*(item.translation for item in placements), self._axis])
        low, high = points.min(axis=0), points.max(axis=0)
        middle = 0.5 * (low + high)
        size = max(float(np.linalg.norm(high - low)), 0.5 * self._mechanism.reach_m)
        direction = np.array(_DIRECTION) / np.linalg.norm(_DIRECTION)
        server.initial_camera.fov = _VIEW
        server.initial_camera.look_at = middle
        server.initial_camera.position = middle + _NEAR * size * direction


def _shape(solid: Solid) -> trimesh.Trimesh:
    mesh: trimesh.Trimesh
    if solid.path is not None:
        try:
            mesh = trimesh.load_mesh(solid.path)
        except (OSError, ValueError, ImportError, NotImplementedError) as error:
            message = f"{solid.path.name}: the mesh cannot be read ({error}); use STL or OBJ"
            raise InputError(message, file=str(solid.path)) from error
    elif solid.kind == "box":
        mesh = trimesh.creation.box(extents=solid.sizes)
    elif solid.kind == "sphere":
        mesh = trimesh.creation.icosphere(radius=solid.sizes[0])
    else:
        radius, length = solid.sizes
        mesh = trimesh.creation.cylinder(radius=radius, height=length, sections=_CYLINDER_SECTIONS)
    return mesh


def _wxyz(rotation: FloatArray) -> FloatArray:
    x, y, z, w = pin.Quaternion(rotation).coeffs()
    return np.array([w, x, y, z])
