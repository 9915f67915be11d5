"""Where the numbers of a TOML file come from; none of them may be none."""

import math

import pytest

from nipper_pin.errors import InputError
from nipper_pin.mechanism import load


def test_not_a_number_is_refused_everywhere() -> None:
    for path in numbers(load().description):
        if "phases" in path or path in ("format", "initial_phase", "degrees_of_freedom"):
            continue
        with pytest.raises(InputError, match="a finite number"):
            load(overrides={path: math.nan})


def numbers(value: object, path: str = "") -> list[str]:
    """Paths of all numbers of the document."""
    if isinstance(value, dict):
        return [
            item
            for key, inner in value.items()
            for item in numbers(inner, f"{path}.{key}".lstrip("."))
        ]
    if isinstance(value, list):
        return [
            item for place, inner in enumerate(value) for item in numbers(inner, f"{path}[{place}]")
        ]
    return [path] if isinstance(value, int | float) and not isinstance(value, bool) else []


def test_provenance_covers_every_number() -> None:
    mechanism = load()
    found = numbers(mechanism.description)
    assert len(found) > 20
    for path in found:
        assert any(path.startswith(prefix) for prefix in mechanism.provenance), path
    groups = {prefix for prefix in mechanism.provenance if prefix.startswith("urdf.")}
    assert groups == {f"urdf.{group}" for group in (
        "points", "links", "limits", "collision_shapes", "visuals"
    )}  # fmt: skip
    for prefix in mechanism.provenance:
        assert prefix.startswith("urdf.") or any(path.startswith(prefix) for path in found), prefix
    assert "estimate" in mechanism.title
    assert "not the maker's data" in mechanism.title
