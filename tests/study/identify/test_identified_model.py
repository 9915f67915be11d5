"""What an identification writes: pictures, provenance, meshes."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from linear_problem import Linear, fitted, problem

from nipper_pin import load
from nipper_pin.study.identify import Parameter, write_model


@pytest.mark.parametrize("moves", [False, True])
def test_provenance_of_identified_numbers(moves: bool, tmp_path: Path) -> None:
    """Identified numbers first, then what the model said of others; meshes move with it.

    A mesh that is only drawn may be missing.
    """
    given = problem(np.array([1.0, 2.0]), np.array([1.0, 1.0]))
    path = "points.rod_pin.z_mm" if moves else given.parameters[0].path
    (start,) = (101.9,) if moves else (11.0,)
    free = Parameter(path=path, low=start - 3.0, high=start + 5.0, start=start, why="")
    fit = fitted(
        Linear(replace(given, parameters=(free,)), matrix=np.ones((2, 1)), offset=0.0), 0.5
    )
    found = write_model(fit, fit.goodness, tmp_path / "found")
    told = dict(found.provenance)
    assert next(iter(told)) == path
    value = f"{start + 1.0:.9g}"
    assert told.pop(path) == (
        f"identified: {value} between {start - 3.0:g} and {start + 5.0:g} (before: {start:.9g}) "
        "from 2 targets; not measured, not the maker's"
    )
    visuals = told.pop("urdf.visuals")
    old = dict(load("e62").provenance)
    assert (visuals == "illustration: the collision shapes") is moves
    assert visuals == old.pop("urdf.visuals") or moves
    assert told == {key: words for key, words in old.items() if key != path}
    meshes = sorted(item.name for item in (tmp_path / "found").rglob("*.stl"))
    drawn = ElementTree.fromstring(found.urdf).iter("mesh")
    assert meshes == sorted({Path(item.get("filename", "")).name for item in drawn})
    assert bool(meshes) is not moves
    if moves:
        # A mesh was drawn for the old places of the pins: links show their plain bodies.
        for link in ElementTree.fromstring(found.urdf).iter("link"):
            bodies, shown = (
                [ElementTree.tostring(item) for item in link.findall(f"{kind}/geometry/*")]
                for kind in ("collision", "visual")
            )
            assert shown == bodies
