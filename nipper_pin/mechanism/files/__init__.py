"""The files of a model: URDF, TOML and CSV, read, checked and written."""

from .describe import Refusal, first_refusal, member_of
from .description import Positive, Restitution
from .toml_text import need_plain_text, read_toml, toml
from .urdf import parse_xml
from .urdf_shapes import check_corners, check_size, mesh_path, path_inside
from .urdf_values import numbers, origin, rotation_from_rpy

__all__ = [
    "Positive",
    "Refusal",
    "Restitution",
    "check_corners",
    "check_size",
    "first_refusal",
    "member_of",
    "mesh_path",
    "need_plain_text",
    "numbers",
    "origin",
    "parse_xml",
    "path_inside",
    "read_toml",
    "rotation_from_rpy",
    "toml",
]
