"""The mechanism of a sweep, and the paths of the numbers that it changes."""

from __future__ import annotations

from collections.abc import Sequence

from ...mechanism import Mechanism, from_sources, model_folder
from ...mechanism.edit import HEADS, apply_overrides, number_at, read_dimension, read_layout
from ...mechanism.files import parse_xml
from .job import Job


def check_paths(paths: Sequence[str], mechanism: Mechanism) -> None:
    """Write a model's own numbers back: paths that lead nowhere or contradict one another fail.

    Raises:
        UnknownNameError: A path leads nowhere.
        ModelError: There is no number, or paths contradict one another.
    """
    toml, urdf = f"{mechanism.name}.toml", f"{mechanism.name}.urdf"
    layout = read_layout(parse_xml(mechanism.urdf, urdf), mechanism.description, urdf)
    own = {
        path: read_dimension(layout, path, urdf)
        if path.split(".")[0] in HEADS
        else number_at(mechanism.description, path, toml)
        for path in paths
    }
    apply_overrides(mechanism.description, mechanism.urdf, own, toml, urdf)


def machine_of(job: Job) -> Mechanism:
    """The mechanism whose numbers a job changes.

    Raises:
        InputError: There is no such machine.
    """
    return from_sources(job.name, job.urdf, job.document, model_folder(job.name, job.folder))
