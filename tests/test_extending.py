"""The examples of docs/extending*.md, run as they stand and compared with closed forms."""

from __future__ import annotations

import importlib.metadata
import math
import re
import sys
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import numpy as np
import pytest

import nipper_pin as nip
from nipper_pin.errors import InputError, ModelError
from nipper_pin.mechanism.drawing import (
    Body,
    Drawing,
    Drive,
    Force,
    Slide,
    Start,
    Stop,
    drawn_mechanism,
    drawn_sources,
)
from nipper_pin.mechanism.drives import DRIVES
from nipper_pin.mechanism.files import register as registers
from nipper_pin.mechanism.forces import FORCES

DOCS = Path(__file__).parents[1] / "docs"
EPS = float(np.finfo(float).eps)
GRAVITY = 9.81


def ran(page: str, monkeypatch: pytest.MonkeyPatch) -> Any:
    """A module with the names of the page's program, after it has run."""
    for register in (DRIVES, FORCES):
        # What a page adds is gone after its test.
        monkeypatch.setattr(register, "_tables", register.known())
    module = ModuleType(f"page_{page}")
    monkeypatch.setitem(sys.modules, module.__name__, module)
    text = (DOCS / f"{page}.md").read_text(encoding="utf-8")
    (code,) = re.findall(r"```python\n(.*?)```", text, re.DOTALL)
    exec(compile(code, page, "exec"), module.__dict__)
    return module


def test_a_force_element(monkeypatch: pytest.MonkeyPatch) -> None:
    """m v^2 / 2 = k x^2 / 2 + h x^4 / 4; without the cubic part the rate would be 0.8."""
    page = ran("extending_force", monkeypatch)
    k, h, m, x = 800.0, 2e6, 0.5, 0.02
    struck = page.solution.collisions[0]
    assert struck.approach_rate == pytest.approx(
        -math.sqrt((k * x**2 + h * x**4 / 2.0) / m), rel=1e-12
    )
    # The rebound climbs to where the law stores what is left, a quarter of the energy.
    second = page.solution.collisions[1]
    assert second.approach_rate == pytest.approx(0.5 * struck.approach_rate, rel=1e-11)
    system = page.solution.system
    q = np.zeros((1, len(page.solution.mechanism.joints)))
    q[0, page.solution.mechanism.stop("gap").index] = x
    assert system.spring_energy(q)[0] == pytest.approx(k * x**2 / 2.0 + h * x**4 / 4.0, rel=4 * EPS)


def test_a_drive_law(monkeypatch: pytest.MonkeyPatch) -> None:
    """The gap of the flight is a cubic in each piece; its root is found by another program."""
    page = ran("extending_drive", monkeypatch)
    turn = 0.1
    roots = np.roots([2.0, -2.0, -1.0 / 3.0, 5.0 / 54.0])
    (z,) = [root.real for root in roots if abs(root.imag) < 1e-9 and 0.0 < root.real < 0.5]
    landing = page.solution.collisions[0]
    assert landing.t == pytest.approx((1.0 + z) * turn, rel=1e-13)
    rate = GRAVITY * turn * (-1.0 / 3.0 - 4.0 * z + 6.0 * z**2)
    assert landing.approach_rate == pytest.approx(rate, rel=1e-12)
    # The box leaves where the cam's acceleration is -g, after a third of each turn.
    left = [event.t for event in page.solution.events if event.kind == "release"]
    np.testing.assert_allclose(left, [turn / 3.0, 4.0 * turn / 3.0], rtol=1e-13)


def test_added_laws_are_checked_like_built_in_ones(monkeypatch: pytest.MonkeyPatch) -> None:
    """Misspelt keys, other joints and unknown laws are refused with what is known."""
    page = ran("extending_force", monkeypatch)
    urdf, data = drawn_sources(page.BUFFER)
    force = data["forces"]["gap"]
    for change, words in (
        ({"k_N_per_mm": 1.0}, r"forces.gap.k_N_per_mm.*known here: h_N_per_m3, joint, k_N_per_m"),
        ({"law": "ruber"}, r"forces.gap.law = 'ruber'.*one of orifice, rubber"),
        ({"joint": "gop"}, r"gop.*gap"),
    ):
        changed = {**data, "forces": {"gap": {**force, **change}}}
        with pytest.raises((ModelError, InputError), match=words):
            nip.mechanism.from_sources("buffer", urdf, changed, ".")


def test_an_installed_extension_is_imported_when_its_law_is_met(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Once, and only for a law that is not known; one that fails names itself."""
    page = ran("extending_force", monkeypatch)
    urdf, data = drawn_sources(page.BUFFER)
    loaded: list[str] = []

    def load() -> None:
        class LateForce(page.RubberForce, frozen=True, kw_only=True, tag="late"):  # type: ignore[misc,name-defined]
            """Registered by the extension."""

        page.register_force(LateForce)
        loaded.append("late")

    points = [SimpleNamespace(name="my_laws", value="my_laws", load=load)]
    monkeypatch.setattr(importlib.metadata, "entry_points", lambda **_: points)
    registers._import_extensions.cache_clear()
    drawn_mechanism(page.BUFFER)
    assert loaded == []
    data["forces"]["gap"]["law"] = "late"
    machine = nip.mechanism.from_sources("buffer", urdf, data, ".")
    assert (loaded, machine.forces[0].kind) == (["late"], "late")

    def broken() -> None:
        message = "no module named 'x'"
        raise ImportError(message)

    points[0].load = broken
    registers._import_extensions.cache_clear()
    data["forces"]["gap"]["law"] = "never"
    with pytest.raises(InputError, match=r"extension 'my_laws' \(my_laws\) cannot be imported"):
        nip.mechanism.from_sources("buffer", urdf, data, ".")
    registers._import_extensions.cache_clear()


def test_an_orifice_slows_a_box_down() -> None:
    """v = v0 exp(-c s / m) after the way s, whatever the time; a linear damper gives v0 - c s / m.

    Heat and kinetic energy together stay what they were.
    """
    c, m, rate, way = 30.0, 0.5, 2.0, 0.05
    drawing = Drawing(
        "dashpot", "a box slowed down by an orifice", {"O": (-100.0, 0.0), "B": (0.0, 0.0)},
        (
            Body("shaft", "O", mass_kg=1.0), Body("box", "B", mass_kg=m),
            Slide("turning", "frame", "shaft", at="O", along=(0.0, 1.0)),
            Drive("turning", "fourier", {"mean_mm": 0.0}),
            Slide("gap", "frame", "box", at="B", along=(1.0, 0.0)),
            Force("gap", "orifice", {"c_N_s2_per_m2": c}),
            Start("gap", at=1e3 * way, rate=-1e3 * rate), Stop("gap", restitution=0.0),
        ),
        touch_deg=0.0, start_deg=0.0, speed_rpm=600.0,
    )  # fmt: skip
    case = nip.Case(speed_rpm=600.0, window=nip.Window.CYCLE, cycles=2)
    solution = nip.simulate(drawn_mechanism(drawing), case)
    struck = solution.collisions[0]
    assert struck.approach_rate == pytest.approx(-rate * math.exp(-c * way / m), rel=1e-11)
    assert struck.t == pytest.approx(m / (c * rate) * (math.exp(c * way / m) - 1.0), rel=1e-11)
