"""`<dynamics>` of URDF joints: damping is a damper of the joint, friction is refused."""

from __future__ import annotations

import numpy as np
import pytest

from nipper_pin import Case, simulate
from nipper_pin.mechanism import from_sources, with_numbers
from tests.small_machines import hinge, link, machine, slide, sources

INERTIA, DAMPING, TURN = 0.3, 0.7, 0.2


def _joint(text: str, dynamics: str) -> str:
    return text.replace("</joint>", f"<dynamics {dynamics}/></joint>")


def _wheel(dynamics: str) -> list[str]:
    return [
        link("shaft"),
        hinge("shaft", "frame", "shaft"),
        link("wheel", inertia=INERTIA),
        _joint(hinge("wheel", "shaft", "wheel"), dynamics),
    ]


DRIVES = {"shaft": {"joint": "shaft", "law": "fourier", "sine_rad": [TURN]}}


def test_damping_of_a_joint_slows_it_as_the_closed_form_says() -> None:
    """A wheel on a shaft that swings by A sin w t: I (u'' + s'') = -c u', u the angle between."""
    mechanism = machine(_wheel(f'damping="{DAMPING}" friction="0"'), 2, drives=DRIVES)
    solution = simulate(mechanism, Case(speed_rpm=60.0, window="cycle", start_index=0.0))
    t = np.linspace(0.0, 1.0, 21)
    v = solution.trajectory.evaluate(t).v
    w, k = 2.0 * np.pi, DAMPING / INERTIA
    # p = u' obeys p' + k p = A w^2 sin w t, whose steady part is below.
    shaft, wheel = (
        next(j.index for j in mechanism.joints if j.name == n) for n in ("shaft", "wheel")
    )
    steady = TURN * w**2 * (k * np.sin(w * t) - w * np.cos(w * t)) / (k**2 + w**2)
    expected = steady + (v[0, wheel] - steady[0]) * np.exp(-k * t)
    assert v[:, shaft] == pytest.approx(TURN * w * np.cos(w * t), abs=1e-12)
    assert v[:, wheel] == pytest.approx(expected, abs=1e-11)


def test_it_adds_to_the_dampers_of_the_file_and_has_a_path() -> None:
    dampers = {"oil": {"joint": "wheel", "damping_N_m_s_per_rad": 0.5}}
    urdf, description = sources(_wheel('damping="0.7"'), 2, drives=DRIVES, dampers=dampers)
    mechanism = from_sources("small", urdf, description, ".")
    assert sorted(item.damping for item in mechanism.dampers) == [0.5, 0.7]
    changed = with_numbers(mechanism, {"urdf.joint.wheel.dynamics.damping": 0.9})
    assert sorted(item.damping for item in changed.dampers) == [0.5, 0.9]


def test_a_slide_has_it_too() -> None:
    parts = [link("ram"), _joint(slide("ram", "frame", "ram"), 'damping="3.0"')]
    assert [item.damping for item in machine(parts, 1).dampers] == [3.0]
