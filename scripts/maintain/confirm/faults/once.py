"""Run once before any command: pictures are drawn here, and only written by the commands.

Drawing is most of the time of `simulate --out`, and the published study takes minutes; what is
disturbed is how they are written. The study is done where ``FAULT_STUDY`` is set.
"""

from __future__ import annotations

import io
import os
from functools import cache
from pathlib import Path
from typing import Any

from nipper_pin.hybrid.case import Case
from nipper_pin.hybrid.simulate import simulate
from nipper_pin.mechanism import load
from nipper_pin.study import paper, sensitivity
from nipper_pin.study.paper.published import conditions
from nipper_pin.view.paper import files
from nipper_pin.view.run import plots

SPEEDS = (500.0, 600.0, 650.0)
"""Cylinder speeds of the runs whose pictures are wanted [r/min]."""
# Their names are replaced below, which types do not foresee.
_papers: Any = paper
_files: Any = files
_sensitivity: Any = sensitivity
_plots: Any = plots
_study, _sensitivities = paper.paper_study, sensitivity.sensitivities
_plates, _material, _html = _files.study_plates, _files.material, _files.report_html
_figures = _plots._figures


class _Drawn:
    """A figure that is drawn already."""

    def __init__(self, figure: Any) -> None:
        picture = io.BytesIO()
        figure.savefig(picture, format="png")
        self._content = picture.getvalue()

    def get_children(self) -> tuple[()]:
        """Nothing that could still be changed."""
        return ()

    def savefig(self, path: Path, **_: object) -> None:
        """Write it, in two parts as a large one is."""
        half = len(self._content) // 2
        with path.open("wb", buffering=0) as stream:
            stream.write(self._content[:half])
            stream.write(self._content[half:])


@cache
def _pictures(speed: float) -> dict[str, _Drawn]:
    solution = simulate(load("e62"), Case(speed_rpm=speed))
    return {name: _Drawn(figure) for name, figure in _figures(solution).items()}


@cache
def _results(model: str) -> tuple[Any, ...]:
    mechanism = load(model)
    speed = conditions(mechanism).common_speed_rpm
    found = _sensitivities(mechanism, speed, workers=1)
    study = _study(mechanism, lambda _: None)
    drawn = _plates(study)
    added = _files.Supplements(found, None)
    content = _material(study, added, drawn)
    return study, found, drawn, content, _html(study, added, content)


def _prepare_runs() -> None:
    for speed in SPEEDS:
        _pictures(speed)
    _plots._figures = lambda solution: _pictures(solution.case.speed_rpm)


def _prepare_study() -> None:
    done = {model: _results(model) for model in ("e62", "e62_identified")}
    of_study = {id(item[0]): item for item in done.values()}
    _papers.paper_study = lambda mechanism, _say: done[mechanism.name][0]
    _sensitivity.sensitivities = lambda mechanism, _speed, **_: done[mechanism.name][1]
    _files.study_plates = lambda study: of_study[id(study)][2]
    _files.material = lambda study, *_: of_study[id(study)][3]
    _files.report_html = lambda study, *_: of_study[id(study)][4]


_prepare_runs()
if os.environ.get("FAULT_STUDY"):
    _prepare_study()
