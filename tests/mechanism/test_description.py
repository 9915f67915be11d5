"""Mistakes in the TOML file, and where its numbers come from."""

import math

import pytest

from nipper_pin.errors import InputError, ModelError, UnknownNameError
from nipper_pin.mechanism import load

# Old text, new text, key, value, words of what is allowed.
MISTAKES = {
    "above the range": (
        "restitution = 0.2\ncontact",
        "restitution = 1.2\ncontact",
        "stops.jaw.restitution",
        1.2,
        "at least 0 and at most 1",
    ),
    "not positive": (
        "stiffness_N_per_m = 9000.0",
        "stiffness_N_per_m = 0",
        "springs.steeve.stiffness_N_per_m",
        0,
        "a number above 0",
    ),
    "not a number": (
        "rated_speed_rpm = 450.0",
        "rated_speed_rpm = 'fast'",
        "cylinder.rated_speed_rpm",
        "fast",
        "a number above 0",
    ),
    "infinite": (
        "preload_length_mm = 11.0",
        "preload_length_mm = inf",
        "springs.steeve.preload_length_mm",
        math.inf,
        "a finite number",
    ),
    "not one of the choices": (
        'direction = "clockwise"',
        'direction = "left"',
        "cylinder.direction",
        "left",
        "one of clockwise, counter-clockwise",
    ),
    "unknown law": (
        'law = "geared"',
        'law = "chain"',
        "drives.tension.law",
        "chain",
        "one of cam, constant_speed, fourier, geared, oscillating_guide, screw, table",
    ),
    "unknown key": (
        "restitution = 0.2\ncontact",
        "restitution = 0.2\nbounce = 3\ncontact",
        "stops.jaw.bounce",
        3,
        "known here: adjusted, at_deg, at_mm, contact, joint, restitution, restitution_law, side",
    ),
    "unknown key below": (
        'lower = "bottom_lip"',
        'lowest = "x", lower = "bottom_lip"',
        "stops.jaw.contact.lowest",
        "x",
        "known here: lower, upper",
    ),
    "unknown key of a drive": (
        "ratio = 2.2 ",
        "ratio = 2.2\nteeth = 40 #",
        "drives.tension.teeth",
        40,
        "known here: joint, law, of, ratio, reflected_inertia_kg_m2",
    ),
    "unknown section": ("[stops.jaw]", "[brakes]\n[stops.jaw]", "brakes", {}, "known here: clos"),
    "missing key": (
        'frame_b = "cylinder_axis"',
        "",
        "closures.rocker_axis.frame_b",
        None,
        "key; known here: block_mass_kg, frame_a, frame_b, slot_axis",
    ),
    "short point": (
        "[-190.0, -20.0]",
        "[-190.0]",
        "drives.pendulum.guide_axis_mm",
        [-190.0],
        "two numbers",
    ),
    "whole number": ("number = 2", "number = 2.5", "phases[1].number", 2.5, "whole number"),
    "format": ("format = 1", "format = 2", "format", 2, "one of 1"),
    "crank too long": (
        "crank_radius_mm = 64.0",
        "crank_radius_mm = 200.0",
        "drives.pendulum.crank_radius_mm",
        200.0,
        "does not make the guide oscillate",
    ),
    "offset too large": (
        "guide_offset_mm = 0.0",
        "guide_offset_mm = -130.0",
        "drives.pendulum.guide_offset_mm",
        -130.0,
        "smaller than 127.05 mm",
    ),
    "geared to itself": (
        'of = "pendulum"',
        'of = "tension"',
        "drives.tension.of",
        "tension",
        "not g",
    ),
    "two references": (
        'reference_extreme = "minimum"',
        "reference_angle_deg = 3.0",
        "cylinder.reference_drive",
        "pendulum",
        "exactly one of",
    ),
    "same phase number": ("number = 2", "number = 1", "phases[1].number", 1, "number of its own"),
    "same phase": ('closed = ["jaw"]', "closed = []", "phases[2].closed", [], "different set"),
    "initial phase": ("initial_phase = 1", "initial_phase = 4", "initial_phase", 4, "1, 2, 3"),
    "driven slider": (
        'joint = "tension_shaft"',
        'joint = "steeve"',
        "drives.tension.joint",
        "steeve",
        "screw: a slide",
    ),
    "driven twice": (
        'joint = "tension_shaft"',
        'joint = "pendulum_shaft"',
        "drives.tension.joint",
        "pendulum_shaft",
        "one drive only",
    ),
    "driven stop": (
        '[stops.jaw]\njoint = "jaw"',
        '[stops.jaw]\njoint = "tension_shaft"',
        "stops.jaw.joint",
        "tension_shaft",
        "without a drive",
    ),
    "spring of the wrong kind": (
        '[springs.steeve]\njoint = "steeve"',
        '[springs.steeve]\njoint = "jaw"',
        "springs.steeve.stiffness_N_per_m",
        9000.0,
        "has the keys stiffness_N_m_per_rad and preload_deg",
    ),
    "shortcut to a text": (
        'restitution = "stops.jaw.restitution"',
        'restitution = "stops.jaw.joint"',
        "shortcuts.restitution",
        "stops.jaw.joint",
        "path of a number",
    ),
}

# Old text, new text, kind, name, one of the known names.
UNKNOWN = {
    "joint of a drive": ('joint = "tension_shaft"', 'joint = "shaft"', "joint", "shaft", "jaw"),
    "joint of a stop": ('joint = "jaw"', 'joint = "lips"', "joint", "lips", "jaw"),
    "frame": ('frame_a = "rod_head"', 'frame_a = "head"', "frame", "head", "rod_head"),
    "drive": ('of = "pendulum"', 'of = "pendel"', "drive", "pendel", "pendulum"),
    "reference": (
        'reference_drive = "pendulum"',
        'reference_drive = "crank"',
        "drive",
        "crank",
        "pendulum",
    ),
    "stop of a phase": ('closed = ["jaw"]', 'closed = ["lip"]', "stop", "lip", "jaw"),
    "transition stop": ('transition_stop = "jaw"', 'transition_stop = "x"', "stop", "x", "steeve"),
    "shortcut": ("springs.steeve.pre", "springs.sleeve.pre", "key", "sleeve", "steeve"),
}


@pytest.mark.parametrize("name", MISTAKES)
def test_mistake(spoil, name: str) -> None:  # type: ignore[no-untyped-def]
    old, new, key, value, allowed = MISTAKES[name]
    with pytest.raises(ModelError) as caught:
        load(spoil(toml=((old, new),)))
    evidence = caught.value.evidence
    assert evidence["file"] == "e62.toml"
    assert evidence["key"] == key
    assert evidence["value"] == value
    assert allowed in evidence["allowed"]
    assert str(caught.value).startswith(f"e62.toml: {key} ")


@pytest.mark.parametrize("name", UNKNOWN)
def test_unknown_name(spoil, name: str) -> None:  # type: ignore[no-untyped-def]
    old, new, kind, wrong, known = UNKNOWN[name]
    with pytest.raises(UnknownNameError) as caught:
        load(spoil(toml=((old, new),)))
    assert caught.value.evidence["kind"] == kind
    assert caught.value.evidence["name"] == wrong
    assert known in caught.value.evidence["known"]
    assert str(caught.value).startswith("e62.toml: ")


def test_not_a_number_is_refused_everywhere() -> None:
    for path in numbers(load().description):
        if "phases" in path or path in ("format", "initial_phase", "degrees_of_freedom"):
            continue
        with pytest.raises(InputError, match="a finite number"):
            load(overrides={path: math.nan})


def test_torsion_spring(spoil) -> None:  # type: ignore[no-untyped-def]
    spring = '[springs.jaw]\njoint = "jaw"\nstiffness_N_m_per_rad = 3.0\npreload_deg = 90.0\n'
    mechanism = load(spoil(toml=(("[stops.jaw]", f"{spring}\n[stops.jaw]"),)))
    assert mechanism.springs[1].stiffness == 3.0
    assert mechanism.springs[1].preload == pytest.approx(math.pi / 2.0)
    assert mechanism.springs[1].index == mechanism.stop("jaw").index


def test_broken_toml(spoil) -> None:  # type: ignore[no-untyped-def]
    with pytest.raises(ModelError, match=r"e62\.toml: TOML = .*line 5"):
        load(spoil(toml=(("title = ", "title "),)))


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
