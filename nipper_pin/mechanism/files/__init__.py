"""The files of a model: URDF, TOML and CSV, read, checked and written."""

from .describe import Refusal, first_refusal, member_of
from .description import Positive, Restitution
from .toml_text import need_plain_text, read_toml, toml
from .urdf_shapes import check_corners, check_size, mesh_path, path_inside, shape_sizes
from .urdf_values import origin, rotation_from_rpy
from .xml_text import parse_xml

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
    "origin",
    "parse_xml",
    "path_inside",
    "read_toml",
    "rotation_from_rpy",
    "shape_sizes",
    "toml",
]
