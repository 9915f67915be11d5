"""Model files to one immutable, validated mechanism."""

from .cylinder import INDEX_PER_TURN, Cylinder, rad_s_from_rpm
from .drives import ConstantSpeed, DriveLaw, Fourier, Geared, OscillatingGuide, Table
from .load import find_model, from_sources, known_models, load
from .mechanism import Closure, Contact, Drive, Joint, Mechanism, Phase, Spring, Stop
from .shapes import collision_model

__all__ = [
    "INDEX_PER_TURN",
    "Closure",
    "ConstantSpeed",
    "Contact",
    "Cylinder",
    "Drive",
    "DriveLaw",
    "Fourier",
    "Geared",
    "Joint",
    "Mechanism",
    "OscillatingGuide",
    "Phase",
    "Spring",
    "Stop",
    "Table",
    "collision_model",
    "find_model",
    "from_sources",
    "known_models",
    "load",
    "rad_s_from_rpm",
]
