"""Springs and dampers of every kind on the terminal, in the scene and on the live page."""

from __future__ import annotations

import math
import shutil
from io import StringIO
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from rich.console import Console

from nipper_pin import Case, Mechanism, Solution, load, simulate
from nipper_pin.cli import main
from nipper_pin.mechanism import find_model
from nipper_pin.terms import shown
from nipper_pin.view.live.moment import moment_text
from nipper_pin.view.reading import damper_text, spring_text, stop_place
from nipper_pin.view.run.table import print_solution
from nipper_pin.view.run.timelines import motion_figure
from nipper_pin.view.scene import Film, Look, film
from nipper_pin.view.scene.page import scene_page
from nipper_pin.view.scene.tracks import animation

ELEMENTS = """
[springs.band]
frame_a = "steeve_lower"
frame_b = "frame"
stiffness_N_per_m = 120.0
free_length_mm = 90.0

[springs.lid]
joint = "jaw"
coordinate_deg = [-90.0, 0.0, 180.0]
torque_N_m = [1.0, 2.0, 4.5]

[dampers.oil]
joint = "steeve"
damping_N_s_per_m = 12.0

[dampers.stay]
frame_a = "frame"
frame_b = "rod_head"
damping_N_s_per_m = 5.0

[stops.jaw]"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The E62 with one of each."""
    home = tmp_path_factory.mktemp("elements") / "e62"
    shutil.copytree(find_model("e62"), home)
    path = home / "e62.toml"
    text = path.read_text(encoding="utf-8")
    path.write_text(text.replace("[stops.jaw]", ELEMENTS, 1), encoding="utf-8")
    return home


@pytest.fixture(scope="module")
def mechanism(folder: Path) -> Mechanism:
    return load(folder)


@pytest.fixture(scope="module")
def solution(mechanism: Mechanism) -> Solution:
    return simulate(mechanism, Case(speed_rpm=650.0))


def test_texts_name_every_element_in_the_units_of_people(mechanism: Mechanism, e62) -> None:  # type: ignore[no-untyped-def]
    assert spring_text(mechanism) == (
        f"{spring_text(e62)}; lid table from -90 to 180 deg, 1 to 4.5 N m; "
        "band 0.12 N/mm from steeve_lower to frame, free length 90 mm"
    )
    assert damper_text(mechanism) == "oil 12 N s/m; stay 5 N s/m from frame to rod_head"
    assert damper_text(e62) == ""


def test_units_of_texts_and_plots_are_those_of_one_table(
    mechanism: Mechanism, solution: Solution, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Other units there are read everywhere: no text or axis has units of its own."""
    monkeypatch.setitem(shown._UNITS, "m", ("inch", 1.0 / 0.0254))
    monkeypatch.setitem(shown._UNITS, "rad", ("turn", 0.5 / math.pi))
    monkeypatch.setitem(shown._UNITS, "N/m", ("kN/m", 1e-3))
    monkeypatch.setitem(shown._SMALL, "rad", ("urad", 1e6))
    text = spring_text(mechanism)
    assert text.startswith("steeve 9 kN/m, preload 0.433071 inch (99.00 N); ")
    assert "lid table from -0.25 to 0.5 turn, 1 to 4.5 N m" in text
    assert "band 0.12 kN/m from steeve_lower to frame, free length 3.54331 inch" in text
    assert stop_place(mechanism, mechanism.stop("jaw")).endswith(" at 0 turn")
    q = np.zeros(len(mechanism.joints))
    q[mechanism.stop("jaw").index], q[mechanism.stop("steeve").index] = 2e-6, 0.0127
    moment = moment_text(solution, 0.5 * solution.segments[-1].t_end, q)
    assert ", jaw 2.000 urad, " in moment
    assert moment.endswith(", steeve 0.5000 inch")
    jaw, steeve = motion_figure(solution).axes[:2]
    assert (jaw.get_ylabel(), steeve.get_ylabel()) == ("jaw angle [urad]", "steeve stroke [inch]")
    end = solution.segments[-1].t_end
    stroke = solution.trajectory.evaluate(end, left=True).q[0, mechanism.stop("steeve").index]
    assert steeve.lines[0].get_ydata()[-1] == pytest.approx(stroke / 0.0254, rel=1e-9)


def test_check_and_tables_list_them(folder: Path, solution: Solution, e62, capsys) -> None:  # type: ignore[no-untyped-def]
    """Both say what a machine has; one without dampers has no line about them."""
    assert main(["check", str(folder)]) == 0
    found = " ".join(capsys.readouterr().out.split())
    stream = StringIO()
    print_solution(solution, Console(file=stream, width=100))
    for text in (found, " ".join(stream.getvalue().split())):
        assert "lid table from -90 to 180 deg" in text
        assert "dampers: oil 12 N s/m; stay 5 N s/m from frame to rod_head" in text
    stream = StringIO()
    print_solution(simulate(e62, Case(speed_rpm=650.0)), Console(file=stream, width=100))
    assert "dampers" not in stream.getvalue()


def track(shown: Film, end: str, kind: str) -> np.ndarray:
    """Values of one track of a node."""
    for item in animation(shown, ())["animations"]:  # type: ignore[attr-defined]
        for found in item["clip"]["tracks"]:
            if item["path"].endswith(end) and found["name"] == f".{kind}":
                values = np.frombuffer(found["values"].data, dtype="<f4")
                return values.reshape(len(shown.q), -1).astype(float)
    raise AssertionError(end)


@pytest.mark.parametrize(
    ("node", "first", "second"),
    [("spring_band", "steeve_lower", "frame"), ("damper_stay", "frame", "rod_head")],
)
def test_lines_go_from_point_to_point(
    solution: Solution, node: str, first: str, second: str
) -> None:
    """Middle, direction and length of a unit cylinder along y, in every frame of the film.

    Points by Pinocchio's own frame kinematics, rotations by its quaternions. The message is in
    single precision: 1e-7 of 0.3 m.
    """
    shown = film(solution, Look())
    model = solution.mechanism.model
    data = model.createData()
    position, turn, scale = (
        track(shown, node, kind) for kind in ("position", "quaternion", "scale")
    )
    for q, place, (x, y, z, w), size in zip(shown.drawn, position, turn, scale, strict=True):
        pin.framesForwardKinematics(model, data, q)
        ends = [
            data.oMf[model.getFrameId(name)].translation * (1, 0, 1) for name in (first, second)
        ]
        half = 0.5 * size[1] * pin.Quaternion(w, x, y, z).toRotationMatrix()[:, 1]
        np.testing.assert_allclose(place - half, ends[0], atol=1e-6)
        np.testing.assert_allclose(place + half, ends[1], atol=1e-6)
        assert size[0] == size[2] == 1.0
    assert np.ptp(scale[:, 1]) > 1e-4
    assert "nipper" in scene_page(shown)


def test_live_page_draws_the_lines(mechanism: Mechanism) -> None:
    """Ends of the segments at a bent configuration, by Pinocchio's own frame kinematics."""
    viser = pytest.importorskip("viser", reason="viser is not installed (extra `live`)")
    from nipper_pin.view.live.stage import Stage

    q = simulate(mechanism, Case(speed_rpm=650.0)).trajectory.evaluate(2e-3).q[0]
    server = viser.ViserServer(host="127.0.0.1", port=0, verbose=False)
    try:
        Stage(server, mechanism).pose(q, math.pi)
        drawn = server.scene.get_handle_by_name("/struts").points
    finally:
        server.stop()
    data = mechanism.model.createData()
    pin.framesForwardKinematics(mechanism.model, data, q)
    for strut, ends in zip(mechanism.struts, drawn, strict=True):
        for name, end in zip((strut.frame_a, strut.frame_b), ends, strict=True):
            place = data.oMf[mechanism.model.getFrameId(name)].translation
            np.testing.assert_allclose(end[[0, 2]], place[[0, 2]], atol=1e-7)
