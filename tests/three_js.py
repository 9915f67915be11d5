"""Reads the page of the viewer as three.js does: nodes, their matrices, and shapes in them.

Only the messages inside the page are used. Cylinders of three.js stand along y, meshes of a file
keep its axes, and a track of an animation replaces position, rotation or size of its node.
"""

from __future__ import annotations

import base64
import io
import json
import re
from typing import Any

import numpy as np
import trimesh
import umsgpack

Array = Any


class Scene:
    """The nodes of a page."""

    def __init__(self, page: str) -> None:
        """Decode all messages."""
        found = re.search(r'<script id="scene"[^>]*>(.*?)</script>', page, re.S)
        assert found is not None
        sent = [umsgpack.unpackb(base64.b64decode(text)) for text in json.loads(found[1])]
        self.sent: list[dict[str, Any]] = sent
        self.objects = {item["path"]: item["object"] for item in sent if "object" in item}
        self._fixed = {
            item["path"]: np.array(item["matrix"]).reshape(4, 4).T
            for item in sent
            if item["type"] == "set_transform"
        }
        (animation,) = (item for item in sent if item["type"] == "set_animation")
        self.options = animation["options"]
        self.tracks: dict[str, dict[str, tuple[Array, Array]]] = {}
        for item in animation["animations"]:
            for track in item["clip"]["tracks"]:
                t = np.frombuffer(track["times"].data, dtype="<f4").astype(float)
                values = np.frombuffer(track["values"].data, dtype="<f4").astype(float)
                of_node = self.tracks.setdefault(item["path"], {})
                of_node[track["name"]] = t, values.reshape(len(t), -1)

    def matrix(self, path: str, at: float) -> Array:
        """From a node's own axes to the world at a time of playback [s]."""
        parts = path.strip("/").split("/")
        place = np.eye(4)
        for count in range(1, len(parts) + 1):
            place = place @ self._local("/" + "/".join(parts[:count]), at)
        return place

    def _local(self, path: str, at: float) -> Array:
        own = self._fixed.get(path, np.eye(4))
        size = np.linalg.norm(own[:3, :3], axis=0)
        turn, shift = own[:3, :3] / size, own[:3, 3]
        for name, (t, values) in self.tracks.get(path, {}).items():
            value = np.array([np.interp(at, t, column) for column in values.T])
            if name == ".position":
                shift = value
            elif name == ".scale":
                size = value
            elif name == ".quaternion":
                turn = rotation(value / np.linalg.norm(value))
        place = np.eye(4)
        place[:3, :3], place[:3, 3] = turn * size, shift
        return place

    def points(self, path: str, at: float) -> Array:
        """Points of a node's shape in the world, shape (N, 3) [m]."""
        (shape,) = self.objects[path]["geometries"]
        inside = np.array(self.objects[path]["object"]["matrix"]).reshape(4, 4).T
        place = self.matrix(path, at) @ inside
        return outline(shape) @ place[:3, :3].T + place[:3, 3]

    def colour(self, path: str) -> tuple[int, ...]:
        """Red, green and blue of a node's shape, 0 to 255."""
        (material,) = self.objects[path]["materials"]
        return tuple(int(material["color"]).to_bytes(3))


def rotation(quaternion: Array) -> Array:
    """Matrix of a rotation given as x, y, z, w."""
    x, y, z, w = quaternion
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.eye(3) + 2.0 * w * cross + 2.0 * cross @ cross


def ring(radius: float) -> Array:
    """Points of a circle around z; they sag by 1e-5 of its radius, shape (720, 3)."""
    turn = np.linspace(0.0, 2.0 * np.pi, 720, endpoint=False)
    return radius * np.column_stack([np.cos(turn), np.sin(turn), np.zeros(720)])


def outline(shape: dict[str, Any]) -> Array:
    """Points whose convex hull is a shape of three.js, shape (N, 3)."""
    if shape["type"] == "BoxGeometry":
        return box(shape["width"], shape["height"], shape["depth"])
    if shape["type"] == "SphereGeometry":
        return ball(shape["radius"])
    if shape["type"] == "CylinderGeometry":
        half = np.array([0.0, 0.0, 0.5 * shape["height"]])
        ends = [ring(shape["radiusTop"]) + half, ring(shape["radiusBottom"]) - half]
        # Along y: x, y, z of a ring are z, x, y there.
        return np.concatenate(ends)[:, [1, 2, 0]]
    data = shape["data"]
    data = data.data if hasattr(data, "data") else data
    stream = io.BytesIO(data if isinstance(data, bytes) else data.encode())
    return np.asarray(trimesh.load_mesh(stream, file_type=shape["format"]).vertices)


def box(*edges: float) -> Array:
    """Corners."""
    signs = np.array(np.meshgrid(*([[-0.5, 0.5]] * 3))).reshape(3, -1).T
    return signs * edges


def ball(radius: float) -> Array:
    """Points all over a sphere; they sag by 1e-4 of its radius."""
    polar = np.linspace(0.0, np.pi, 361)[:, None]
    around = ring(1.0)[::4]
    points = np.sin(polar)[:, :, None] * around + np.cos(polar)[:, :, None] * [0.0, 0.0, 1.0]
    return radius * points.reshape(-1, 3)
