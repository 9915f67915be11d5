"""Model files to one immutable, validated mechanism."""

from .build.placements import joint_axis, joint_placements, own_frame, supports
from .cylinder import (
    INDEX_PER_TURN,
    Cylinder,
    counted_from,
    index_difference,
    rad_s_from_rpm,
    within_turn,
)
from .elements import Characteristic, Damper, Strut, TabulatedSpring
from .laws import DriveLaw
from .load import collision_model, from_sources, load, need_as_written, need_mechanism
from .mechanism import Mechanism, Shared
from .model_files import find_model, known_models, model_folder
from .other_numbers import changed, layout_of, number_of, numbers_of, retuned
from .parts import Joint, Simultaneous, Spring, Start, Stop

__all__ = [
    "INDEX_PER_TURN",
    "Characteristic",
    "Cylinder",
    "Damper",
    "DriveLaw",
    "Joint",
    "Mechanism",
    "Shared",
    "Simultaneous",
    "Spring",
    "Start",
    "Stop",
    "Strut",
    "TabulatedSpring",
    "changed",
    "collision_model",
    "counted_from",
    "find_model",
    "from_sources",
    "index_difference",
    "joint_axis",
    "joint_placements",
    "known_models",
    "layout_of",
    "load",
    "model_folder",
    "need_as_written",
    "need_mechanism",
    "number_of",
    "numbers_of",
    "own_frame",
    "rad_s_from_rpm",
    "retuned",
    "supports",
    "within_turn",
]
