"""Changes of an input that keep it of its kind, so that they get behind the first check.

Each takes the bytes, a source of chance and a mutator of plain bytes, and gives other bytes.
"""

from __future__ import annotations

import random
from collections.abc import Callable

from .archive import change_archive
from .chunk import change_chunk
from .lines import change_lines
from .tree import change_json, change_packed
from .xml import change_xml

Mutator = Callable[[bytes, random.Random], bytes]
MUTATORS: dict[str, Mutator] = {
    "urdf": change_xml,
    "toml": change_lines,
    "csv": change_lines,
    "measured": change_lines,
    "case": change_json,
    "npz": change_archive,
    "parquet": change_chunk,
    "plan": change_json,
    "study": change_lines,
    "live": change_packed,
}
"""By target."""
