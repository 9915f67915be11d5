"""The mechanism as solids of viser, and where they stand in one configuration."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Literal

import numpy as np
import pinocchio as pin
import trimesh
import viser
from numpy.typing import NDArray

from ...arrays import FloatArray
from ...dynamics import multibody
from ...mechanism import Mechanism, Stop
from ..phases import phase_colour
from ..scene import CYLINDER, FIXED, Colour, Solid, cylinder_axis, solids
from ..scene.arrows import arrow_body, arrow_place, arrow_scale, arrow_sizes, arrow_stops
from ..scene.colours import ARROW, channels
from ..scene.film import bouncing_stop
from ..scene.framing import camera
from .shapes import coarse, shape

_LINE_COLOUR = (51, 51, 51)
# Distance of the camera by the size of the mechanism: nearer, a processor draws more pixels.
_NEAR = 1.8
_MATERIAL: Literal["toon5"] = "toon5"  # two thirds of the cost of viser's own, drawn by a processor
# How far a surface may be moved to save triangles, by the reach of the mechanism: half of them go,
# and a processor that draws needs a fifth less for a picture.
_COARSE = 4e-4
_EDGE = math.radians(30.0)  # faces that meet at a larger angle have an edge between them
_VIEW = math.radians(45.0)
_SUN = (-1.0, -3.0, 4.0)


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
        # viser applies messages between pictures, so slow pictures delay the numbers. Its default
        # lights, shadows and surroundings take five times as long without a graphics card.
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
        stop = bouncing_stop(mechanism)
        opens = [place for place, joint in enumerate(mechanism.joints)
                 if stop is not None and joint.index == stop.index]  # fmt: skip
        self._opening: list[viser.MeshHandle] = []
        self._springs: list[tuple[viser.MeshHandle, Solid, int]] = []
        for solid in drawn:
            handle = self._add(server, f"/{names[solid.body]}/{solid.name}", solid)
            if solid.spring is not None:
                self._springs.append((handle, solid, solid.spring))
            if solid.body in opens:
                self._opening.append(handle)
        self._lines = None
        if mechanism.struts:
            rest = self._ends(np.zeros(self._body.nv))
            self._lines = scene.add_line_segments("/struts", rest, _LINE_COLOUR)
        self._arrows = {
            stop.name: self._arrow(server, names[arrow_body(mechanism, stop)], stop)
            for stop in arrow_stops(mechanism)
        }
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

    def phase(self, closed: frozenset[str]) -> None:
        """Colour the link that opens the transition stop by the phase."""
        colour = _bytes(channels(phase_colour(self._mechanism, closed)))
        for handle in self._opening:
            if handle.color != colour:
                handle.color = colour

    def impulses(self, shares: Mapping[str, float]) -> None:
        """Size the arrows of the impulses.

        Args:
            shares: Impulse by the largest one, by stop [-]; a stop that is not named has none.
        """
        for stop, handle in self._arrows.items():
            share = shares.get(stop, 0.0)
            handle.visible = share > 0.0
            if share > 0.0:
                x, y, z = (float(value) for value in arrow_scale(share))
                handle.scale = (x, y, z)

    def _arrow(self, server: viser.ViserServer, link: str, stop: Stop) -> viser.MeshHandle:
        shaft, thick, head, wide = arrow_sizes(self._mechanism)
        rod = trimesh.creation.cylinder(thick, shaft, sections=12)
        rod.apply_translation([0.0, 0.0, 0.5 * shaft])
        tip = trimesh.creation.cone(wide, head, sections=16)
        tip.apply_translation([0.0, 0.0, shaft])
        # Both stand along z, and an arrow along y.
        vertices = np.concatenate([rod.vertices, tip.vertices])[:, [1, 2, 0]]
        faces = np.concatenate([rod.faces, tip.faces + len(rod.vertices)])
        place = arrow_place(self._mechanism, stop)
        return server.scene.add_mesh_simple(
            f"/{link}/impulse_{stop.name}",
            np.asarray(vertices, dtype=np.float32),
            np.asarray(faces, dtype=np.uint32),
            color=_bytes(channels(ARROW)),
            material=_MATERIAL,
            cast_shadow=False,
            receive_shadow=False,
            visible=False,
            wxyz=_wxyz(place[:3, :3]),
            position=place[:3, 3],
        )

    def _add(self, server: viser.ViserServer, path: str, solid: Solid) -> viser.MeshHandle:
        # Edges stay edges, and what is round looks round.
        thin = coarse(shape(solid), _COARSE * self._mechanism.reach_m / abs(solid.scale).max())
        body = trimesh.graph.smooth_shade(thin, angle=_EDGE)
        place = solid.placement[:3, 3].copy()
        if solid.body == CYLINDER:
            place -= self._axis
        return server.scene.add_mesh_simple(
            path,
            np.asarray(body.vertices, dtype=np.float32),
            np.asarray(body.faces, dtype=np.uint32),
            color=_bytes(solid.colour),
            material=_MATERIAL,
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
        target, position = camera(self._mechanism, points[:, [0, 2]], _NEAR)
        server.initial_camera.fov = _VIEW
        server.initial_camera.look_at = target
        server.initial_camera.position = position


def _bytes(colour: Colour) -> tuple[int, int, int]:
    red, green, blue = (round(255.0 * part) for part in colour)
    return red, green, blue


def _wxyz(rotation: FloatArray) -> FloatArray:
    x, y, z, w = pin.Quaternion(rotation).coeffs()
    return np.array([w, x, y, z])
