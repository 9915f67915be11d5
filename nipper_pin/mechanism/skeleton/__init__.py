"""A commented drawing to start from: the least machine that does what a comber's nipper does."""

from __future__ import annotations

from pathlib import Path

from ..model_files import new_model


def write_skeleton(target: str | Path) -> Path:
    """Write a model that can be checked and simulated, with a comment for every decision in it.

    Target, what is returned, and errors as of :func:`new_model`.
    """
    return new_model(target, Path(__file__).with_name("press.toml").read_text(encoding="utf-8"))
