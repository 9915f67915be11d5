"""A model with other numbers: one mechanism for one set of dimensions."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

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


def changed(job: Job, values: Mapping[str, float]) -> Mechanism:
    """The mechanism of a job with other numbers.

    Args:
        values: Numbers by path; points move together with everything that meets in them.

    Raises:
        InputError: There is no such machine.
    """
    document, urdf = apply_overrides(
        job.document, job.urdf, values, f"{job.name}.toml", f"{job.name}.urdf"
    )
    return from_sources(job.name, urdf, document, model_folder(job.name, job.folder))
