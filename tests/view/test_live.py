"""The live page without a browser: what its sliders set, what it answers, where solids stand."""

from __future__ import annotations

import dataclasses
import re
import signal
import socket
import subprocess
import sys

import numpy as np
import pinocchio as pin
import pytest

from nipper_pin import Case, InputError, load, simulate
from nipper_pin.cli import main
from nipper_pin.view.live.answer import Answer, answer
from nipper_pin.view.live.moment import closed_at, impulses_at
from nipper_pin.view.live.panel.text import as_html
from nipper_pin.view.live.settings import Knob, changed, knobs
from nipper_pin.view.phases import phase_colour

COMMAND = [sys.executable, "-c", "import sys; from nipper_pin.cli import main; sys.exit(main())"]
WHY = "viser is not installed (extra `live`): the page cannot be built"


@pytest.fixture(scope="module")
def controls(e62) -> tuple[Knob, ...]:
    return knobs(e62, 650.0)


def asked(controls, **values: float) -> dict[str, float]:
    """Where the sliders stand: at their starts, but for some."""
    known = {item.key: item.start for item in controls}
    assert set(values) <= {key.rpartition(".")[2] for key in known}
    return {key: values.get(key.rpartition(".")[2], start) for key, start in known.items()}


def numbers(found: Answer) -> dict[str, str]:
    return {item.key: item.text for item in found.rows}


def test_sliders_are_in_units_that_people_read(controls) -> None:
    found = {item.label: (item.low, item.start, item.high) for item in controls}
    assert list(found) == [
        "speed [r/min]", "restitution of the jaw", "stiffness [N/mm]", "preload [mm]"
    ]  # fmt: skip
    assert found["stiffness [N/mm]"][1] == 9.0
    assert found["preload [mm]"][1] == 11.0
    for low, start, high in found.values():
        assert low <= start <= high
    for item in controls:
        # Both ends are whole numbers of steps, so that the slider reaches round numbers.
        for end in (item.low, item.high):
            assert end / item.step == pytest.approx(round(end / item.step), abs=1e-9)


def test_a_start_outside_the_usual_range_is_inside_the_slider(e62) -> None:
    speed = knobs(e62, 1234.5)[0]
    assert speed.low < speed.start == speed.high == 1234.5
    assert knobs(e62, 20.0)[0].low == 20.0


@pytest.mark.parametrize("speed", [0.0, -1.0, float("nan"), float("inf")])
def test_an_unusable_speed_is_refused(e62, speed: float) -> None:
    with pytest.raises(InputError, match="a finite speed above 0"):
        knobs(e62, speed)


def test_sliders_at_their_starts_mean_the_model(e62, controls) -> None:
    values = {item.key: item.factor * item.start for item in controls}
    same = changed(e62, values)
    assert same.stops == e62.stops
    for one, other in zip(same.springs, e62.springs, strict=True):
        # Units are converted forth and back: two roundings.
        assert one.stiffness == pytest.approx(other.stiffness, rel=4e-16)
        assert one.preload == pytest.approx(other.preload, rel=4e-16)


def test_a_setting_without_rest_gives_its_reason_and_no_numbers(e62, controls) -> None:
    found = answer(e62, controls, asked(controls, speed=900.0, restitution=0.7))
    assert found.rows == ()
    assert found.solution is None
    assert "did not come to rest" in found.message
    # The steeve reaches its stop in this one, which the sentence tells.
    assert "the steeve struck its stop" in found.message
    page = as_html(found)
    assert "No numbers" in page
    assert "<table" not in page
    assert "speed 900 r/min" in page


def test_a_run_that_fails_gives_its_sentence_and_no_numbers(controls) -> None:
    backwards = load("e62", {"cylinder.direction": "counter-clockwise"})
    found = answer(backwards, controls, asked(controls))
    assert "not closing in the touch configuration" in found.message
    assert found.rows == ()


def test_without_restitution_there_is_a_collision_and_the_jaw_is_shut(e62, controls) -> None:
    found = answer(e62, controls, asked(controls, restitution=0.0))
    read = numbers(found)
    assert found.message == ""
    assert (read["duration"], read["amplitude"], read["collisions"]) == ("0", "0", "1")
    assert len(found.impulse) == 1
    assert not found.gap.any()
    assert found.force[-1] > 50.0


def test_what_a_model_is_called_cannot_become_part_of_the_page(e62, controls) -> None:
    knob = dataclasses.replace(controls[0], name="<script>alert(1)</script>")
    found = answer(e62, (knob, *controls[1:]), asked(controls))
    assert "<script>" not in as_html(found)


def test_solids_stand_where_pinocchio_puts_their_links(e62) -> None:
    """Positions and axes of all frames in a bent configuration, by Pinocchio's own kinematics."""
    viser = pytest.importorskip("viser", reason=WHY)
    from nipper_pin.view.live.stage import Stage
    from nipper_pin.view.scene.solids import solids

    run = simulate(e62, Case(speed_rpm=650.0))
    motion = run.trajectory.evaluate(2e-3)
    server = viser.ViserServer(host="127.0.0.1", port=0, verbose=False)
    try:
        Stage(server, e62).pose(motion.q[0], float(motion.cylinder_angle[0]))
        data = e62.model.createData()
        pin.forwardKinematics(e62.model, data, motion.q[0])
        for joint in e62.joints:
            wanted = data.oMi[e62.model.getJointId(joint.name)]
            frame = server.scene.get_handle_by_name(f"/links/{joint.child}")
            w, x, y, z = frame.wxyz
            np.testing.assert_allclose(frame.position, wanted.translation, atol=1e-12)
            turned = pin.Quaternion(w, x, y, z).toRotationMatrix()
            np.testing.assert_allclose(turned, wanted.rotation, atol=1e-12)
        springs = [item for item in solids(e62) if item.spring is not None]
        assert springs
        for item in springs:
            joint = next(joint for joint in e62.joints if e62.joints.index(joint) == item.body)
            handle = server.scene.get_handle_by_name(f"/links/{joint.child}/{item.name}")
            stroke = motion.q[0, item.spring]
            assert stroke > 1e-4
            assert handle.scale[2] == pytest.approx(item.scale[2] - stroke, rel=1e-12)
    finally:
        server.stop()


@pytest.fixture
def stage(e62):
    viser = pytest.importorskip("viser", reason=WHY)
    from nipper_pin.view.live.stage import Stage

    server = viser.ViserServer(host="127.0.0.1", port=0, verbose=False)
    yield server.scene, Stage(server, e62)
    server.stop()


def test_solids_keep_their_shape_with_fewer_triangles(e62) -> None:
    """Both surfaces pass the corners of the other by no more than twice the tolerance.

    By trimesh's own distances; manifold3d moves one edge after the other, and so a little further
    than it is told. Without a look at what is left, the lip of the cushion plate would go whole,
    which is ten tolerances. Half of the triangles go.
    """
    pytest.importorskip("manifold3d", reason=WHY)
    import trimesh

    from nipper_pin.view.live.shapes import coarse
    from nipper_pin.view.scene.solids import solids

    tolerance, before, after = 4e-4 * e62.reach_m, 0, 0
    for solid in solids(e62):
        mesh = trimesh.load_mesh(solid.path)
        thin = coarse(mesh, tolerance)
        before, after = before + len(mesh.faces), after + len(thin.faces)
        for one, other in ((mesh, thin), (thin, mesh)):
            _, distance, _ = trimesh.proximity.closest_point(one, other.vertices)
            assert distance.max() < 2.0 * tolerance, solid.name
        assert thin.is_watertight
    assert after < 0.6 * before


def test_a_surface_with_holes_is_drawn_as_it_is() -> None:
    """manifold3d has no body for it, and a plate thinner than the tolerance would vanish."""
    pytest.importorskip("manifold3d", reason=WHY)
    import trimesh

    from nipper_pin.view.live.shapes import coarse

    box = trimesh.creation.box(extents=(1.0, 2.0, 3.0))
    torn = trimesh.Trimesh(box.vertices, box.faces[:-1])
    assert coarse(torn, 1e-3) is torn
    plate = trimesh.creation.box(extents=(1.0, 1.0, 1e-4))
    assert coarse(plate, 1e-2) is plate
    assert len(coarse(trimesh.creation.icosphere(4), 0.05).faces) < 2000


def test_the_arrow_at_the_lips_points_along_the_impulse(e62, stage) -> None:
    """Its foot and its tip in the touch configuration, where the contact of the model is known."""
    scene, shown = stage
    assert not scene.get_handle_by_name("/links/bottom_nipper/impulse_jaw").visible
    shown.impulses({"jaw": 0.25})
    handle = scene.get_handle_by_name("/links/bottom_nipper/impulse_jaw")
    link = scene.get_handle_by_name("/links/bottom_nipper")
    shown.rest()
    # At q = 0 all links are parallel to the world.
    np.testing.assert_allclose(link.wxyz, [1.0, 0.0, 0.0, 0.0], atol=1e-12)
    w, x, y, z = handle.wxyz
    points = pin.Quaternion(w, x, y, z).toRotationMatrix() @ (handle.vertices * handle.scale).T
    points = points.T + handle.position + link.position
    contact = e62.stop("jaw").contact
    along = (points - contact.point) @ contact.normal
    # Stored in single precision; a quarter of the impulse is a quarter of the length.
    assert along.min() == pytest.approx(0.0, abs=1e-7)
    assert along.max() == pytest.approx(0.25 * 0.18 * e62.reach_m, rel=1e-6)
    tip = points[along.argmax()] - contact.point
    np.testing.assert_allclose(tip, along.max() * contact.normal, atol=1e-7)
    shown.impulses({})
    assert not handle.visible


def test_the_colour_of_the_opening_link_is_that_of_the_phase(e62, stage) -> None:
    """Of both its solids, and of no other link."""
    scene, shown = stage
    others = scene.get_handle_by_name("/links/bottom_nipper/bottom_nipper").color
    seen = set()
    for phase in e62.phases:
        shown.phase(phase.closed)
        own = [scene.get_handle_by_name(f"/links/top_nipper/{name}").color
               for name in ("top_nipper", "top_lip")]  # fmt: skip
        wanted = phase_colour(e62, phase.closed)
        assert own == [tuple(bytes.fromhex(wanted[1:]))] * 2
        assert scene.get_handle_by_name("/links/bottom_nipper/bottom_nipper").color == others
        seen.add(own[0])
    assert len(seen) == 3


def test_an_impulse_is_held_shrinks_and_goes(e62) -> None:
    """At 1 : 1000, a millisecond of the machine is a second of playback."""
    run = simulate(e62, Case(speed_rpm=650.0))
    first, second = run.collisions[:2]
    assert first.impulse == max(hit.impulse for hit in run.collisions)
    assert second.t - first.t > 5e-3
    for after, size in ((0.0, 1.0), (0.59e-3, 1.0), (0.8e-3, 0.5), (1.01e-3, 0.0)):
        assert impulses_at(run, first.t + after, 1e3)["jaw"] == pytest.approx(size, abs=1e-9)
    share = second.impulse / first.impulse
    assert impulses_at(run, second.t, 1e3)["jaw"] == pytest.approx(share, rel=1e-12)
    assert closed_at(run, second.t) == frozenset()


@pytest.mark.parametrize("slow", [500.0, 1000.0])
def test_the_film_stands_at_its_end_for_a_moment_and_begins_again(
    e62, controls, slow: float
) -> None:
    """0.7 s of playback, however slow: so long the page says the last time, and then the first.

    Of a run of its own; a step is two hundredths of a millisecond or more, and the page says one.
    """
    viser = pytest.importorskip("viser", reason=WHY)
    from nipper_pin.view.live.page import Page

    run, step = simulate(e62, Case(speed_rpm=650.0)), 0.02
    # One index behind the rest.
    end = run.events[-1].t + 60.0 / 650.0 / 40.0
    server = viser.ViserServer(host="127.0.0.1", port=0, verbose=False)
    try:
        page = Page(server, e62, controls)
        page._slow.value = slow
        told = []
        for _ in range(int(slow * end / step) + 60):
            page._draw(step)
            told.append(page._text.partition(" ms")[0])
    finally:
        server.stop()
    first, still = told.index(f"{1e3 * end:.2f}"), told.count(f"{1e3 * end:.2f}")
    assert first == pytest.approx(slow * end / step, abs=1)
    assert still == pytest.approx(0.7 / step, abs=1)
    assert told[first + still] == "0.00"
    assert "0.00" not in told[: first + still]


def test_plots_are_there_with_the_numbers_and_only_then(e62, controls) -> None:
    """They go where a setting has no rest, and come back with the curves of the next that has."""
    viser = pytest.importorskip("viser", reason=WHY)
    from nipper_pin.view.live.page import Page

    usual = asked(controls)
    endless = asked(controls, speed=900.0, restitution=0.7)
    server = viser.ViserServer(host="127.0.0.1", port=0, verbose=False)
    try:
        page = Page(server, e62, controls)
        for setting, there in ((usual, True), (endless, False), (usual, True)):
            for key, value in setting.items():
                page._set.sliders[key].value = value
            found = page._follow()
            assert bool(found.rows) is there
            for plot in (page._plots.gap, page._plots.force, page._plots.impulse):
                assert plot.visible is there
        now = page._plots.gap.data[3]
        np.testing.assert_array_equal(now, found.gap)
        np.testing.assert_array_equal(page._plots.impulse.data[3], found.impulse)
    finally:
        server.stop()


class Moves:
    """A clock that runs only while the page waits, and sliders that move at some of its times."""

    def __init__(self, *times: float, end: float) -> None:
        self.now, self.end, self._times = 0.0, end, list(times)

    def wait(self, timeout: float) -> bool:
        if self.now > self.end:
            raise StopIteration
        moved = bool(self._times) and self._times[0] <= self.now + timeout
        self.now = self._times.pop(0) if moved else self.now + timeout
        return moved

    def clear(self) -> None:
        """Nothing is kept: a move is told once."""

    def perf_counter(self) -> float:
        return self.now

    def sleep(self, seconds: float) -> None:
        self.now += seconds


def test_the_film_stands_while_sliders_move_and_goes_on_where_it_stood(
    e62, controls, monkeypatch: pytest.MonkeyPatch
) -> None:
    """0.8 s from the last of two moves, in which it is drawn for each setting, at the same time.

    The page's own loop, on a clock that no other work of the machine delays.
    """
    viser = pytest.importorskip("viser", reason=WHY)
    from nipper_pin.view.live import page as module

    clock = Moves(2.0, 2.3, end=4.0)
    monkeypatch.setattr(module, "time", clock)
    server = viser.ViserServer(host="127.0.0.1", port=0, verbose=False)
    try:
        page = module.Page(server, e62, controls)
        monkeypatch.setattr(page, "_wake", clock)
        monkeypatch.setattr(server, "get_clients", lambda: {0: None})
        shown: list[tuple[float, float]] = []
        draw = page._draw
        monkeypatch.setattr(
            page, "_draw", lambda passed: (draw(passed), shown.append((clock.now, page._clock)))
        )
        with pytest.raises(StopIteration):
            page.run()
    finally:
        server.stop()
    before = max(t for now, t in shown if now < 2.0)
    still = [now for now, t in shown if t == before and now >= 2.0]
    assert still == pytest.approx([2.0, 2.3, 3.1], abs=0.01)
    # From there on it runs as fast as ever.
    last, t = shown[-1]
    assert last > 3.5
    assert t - before == pytest.approx((last - still[-1]) / page._slow.value, rel=1e-9)


@pytest.mark.parametrize("name", ["viser", "manifold3d"])
def test_a_missing_library_is_one_sentence_with_the_remedy(
    name: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(sys.modules, name, None)
    assert main(["live", "--no-browser"]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.count("\n") == 1
    assert f'needs {name}, which is not installed: pip install "nipper-pin[live]"' in err


@pytest.mark.parametrize("port", ["70000", "-1"])
def test_a_port_that_there_is_not_is_one_sentence(
    port: str, capsys: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("viser", reason=WHY)
    assert main(["live", "--no-browser", "--port", port]) == 2
    out, err = capsys.readouterr()
    assert (out, err.count("\n")) == ("", 1)
    assert f"port {port} cannot be used" in err


def test_a_port_that_is_taken_is_one_sentence(capsys: pytest.CaptureFixture[str]) -> None:
    """viser itself would take the next free port, where nobody looks."""
    pytest.importorskip("viser", reason=WHY)
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        assert main(["live", "--port", str(port), "--no-browser"]) == 2
    out, err = capsys.readouterr()
    assert (out, err.count("\n")) == ("", 1)
    assert f"port {port} cannot be used" in err


def test_a_model_without_rebounds_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("viser", reason=WHY)
    model = f"{__file__.rpartition('/view/')[0]}/verification/models/four_bar"
    assert main(["live", model, "--no-browser", "--port", "0"]) == 2
    assert "no transition stop" in capsys.readouterr().err


@pytest.mark.slow
@pytest.mark.parametrize("model", ["e62", "bouncing_mass"])
def test_the_server_ends_on_interrupt_and_says_nothing_but_its_address(model: str) -> None:
    pytest.importorskip("viser", reason=WHY)
    if model != "e62":
        model = f"{__file__.rpartition('/view/')[0]}/verification/models/{model}"
    command = [*COMMAND, "live", model, "--port", "0", "--no-browser"]
    with subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as server:
        first = server.stdout.readline()
        assert re.fullmatch(r"the page is at http://127\.0\.0\.1:\d+/ ; Ctrl-C ends\n", first)
        server.send_signal(signal.SIGINT)
        assert server.wait(timeout=60) == 0
        assert server.stdout.read().strip() == ""
        assert server.stderr.read() == ""


def test_other_commands_import_nothing_of_this() -> None:
    program = (
        "import sys; from nipper_pin.cli import main; main(['simulate', '--json', '-']); "
        "sys.stderr.write(' '.join(n for n in sys.modules if n.partition('.')[0] in "
        "{'viser', 'websockets', 'trimesh', 'manifold3d'} or n.startswith('nipper_pin.view.live')))"
    )
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=True
    )
    assert done.stderr == ""


def test_a_transition_that_no_turn_has_is_not_shown_alone(controls) -> None:
    """The first row says so, and why; where turns have it there is no such row."""
    late = {"stops.steeve.restitution": 0.97}
    found = answer(load("e62", late), controls, asked(controls))
    assert found.rows[0][0] == "premise"
    assert "one turn later" in found.rows[0][2]
    assert "no turn has this transition" in as_html(found)
    assert "premise" not in numbers(answer(load("e62"), controls, asked(controls)))
