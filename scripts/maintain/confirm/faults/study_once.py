"""Run once before any command: the published study is computed here, and only written by commands.

It takes minutes, of which writing its files takes one second; those are what is disturbed.
"""

from __future__ import annotations

from functools import cache
from typing import Any

from nipper_pin.mechanism import load
from nipper_pin.study import paper, sensitivity
from nipper_pin.study.paper.published import conditions
from nipper_pin.view.paper import files

# Their names are replaced below, which types do not foresee.
_papers: Any = paper
_files: Any = files
_sensitivity: Any = sensitivity
_study, _sensitivities = paper.paper_study, sensitivity.sensitivities
_plates, _material, _html = _files.study_plates, _files.material, _files.report_html


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


def _prepare() -> None:
    done = {model: _results(model) for model in ("e62", "e62_identified")}
    of_study = {id(item[0]): item for item in done.values()}
    _papers.paper_study = lambda mechanism, _say: done[mechanism.name][0]
    _sensitivity.sensitivities = lambda mechanism, _speed, **_: done[mechanism.name][1]
    _files.study_plates = lambda study: of_study[id(study)][2]
    _files.material = lambda study, *_: of_study[id(study)][3]
    _files.report_html = lambda study, *_: of_study[id(study)][4]


_prepare()
