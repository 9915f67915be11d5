"""Output files and folders: checked before a computation, complete or absent after it."""

from .check import check_file, check_folder
from .file import complete_file, synchronise
from .folder import complete_folder
from .hidden import hidden_folder

__all__ = [
    "check_file",
    "check_folder",
    "complete_file",
    "complete_folder",
    "hidden_folder",
    "synchronise",
]
