"""Loops of files whose numbers are rounded: closed and told, or refused by name."""

from __future__ import annotations

import json
import math
import tomllib
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest
from any_plane import rewritten
from small_machines import frame, hinge, link, machine

import nipper_pin as nip
from nipper_pin import Mechanism
from nipper_pin.cli import main
from nipper_pin.mechanism import changed, from_sources, own_frame
from nipper_pin.mechanism.gallery import drawn
from nipper_pin.reduced import reduced_model, transition

LIMIT = 1e-4
STRANGERS = Path(__file__).parent.parent / "strangers"
PLANES = {
    "x-z": np.eye(3),
    "y-z": np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]),
    "from behind": np.diag([-1.0, -1.0, 1.0]),
}


def rounded(urdf: str, form: str) -> tuple[str, float]:
    """A URDF with all places and axes rounded, and what that may move a point by.

    Half a unit of the last digit of each length; of each angle and axis that by the length of
    everything in a row, three of which a place has.
    """
    root = ElementTree.fromstring(urdf)
    lengths, angles = [0.0], [0.0]
    far = sum(
        math.hypot(*map(float, item.get("xyz", "0").split()))
        for joint in root.iter("joint")
        for item in joint.iter("origin")
    )
    for joint in root.iter("joint"):
        for item in (*joint.iter("origin"), *joint.iter("axis")):
            for key in ("xyz", "rpy"):
                words = item.get(key, "").split()
                short = [form.format(float(word)) for word in words]
                errors = [abs(float(a) - float(b)) for a, b in zip(words, short, strict=True)]
                (lengths if item.tag == "origin" and key == "xyz" else angles).extend(errors)
                if words:
                    item.set(key, " ".join(short))
    return ElementTree.tostring(root, encoding="unicode"), sum(lengths) + far * sum(angles)


def motion(mechanism: Mechanism) -> tuple[nip.Solution, float]:
    """A turn, and the time of its first event."""
    solution = nip.simulate(mechanism, window=nip.Window.CYCLE)
    return solution, min([event.t for event in solution.events] or [solution.shaft.period])


def coordinates(solution: nip.Solution, times: np.ndarray) -> np.ndarray:
    """Coordinates in the order of the names of their joints: another plane keeps those."""
    found = solution.trajectory.evaluate(times).joints
    return np.array([found[name] for name in sorted(found)])


@pytest.mark.sampled(5)
@pytest.mark.parametrize("plane", PLANES)
@pytest.mark.parametrize("form", ["{:.5g}", "{:.6g}", "{:.7g}", "{:.8g}", "{:.5f}", "{:.6f}"])
@pytest.mark.parametrize(
    "name", ["crank_rocker", "slider_crank", "scotch_yoke", "watt_1", "stephenson_3"]
)
def test_a_rounded_file_moves_as_the_whole_one(name: str, form: str, plane: str) -> None:
    """Within the errors of its numbers, by the inverse of the closures.

    Places and closing move the points of a loop by the errors at most, here and at touch.
    """
    urdf, document = drawn(name).sources()
    whole = rewritten(urdf, PLANES[plane], {}, np.random.default_rng(7))
    short, error = rounded(whole, form)
    exact = from_sources(name, whole, document, ".")
    assert exact.closing == ""
    machine = from_sources(name, short, document, ".")
    gaps = np.array([closure.gap_m for closure in machine.closures])
    assert 0.0 < np.linalg.norm(gaps, axis=1).max() <= min(error, LIMIT * machine.reach_m)
    first, first_event = motion(exact)
    second, second_event = motion(machine)
    times = np.linspace(0.0, 0.9 * min(first_event, second_event), 25)
    known = [drive.index for drive in exact.drives]
    known += [stop.index for stop in exact.stops if stop.name in exact.phase(1).closed]
    free = [index for index in range(len(exact.joints)) if index not in known]
    _, jacobian = first.system.body.closures(first.trajectory.evaluate(times).q)
    stiff = np.linalg.norm(np.linalg.pinv(jacobian[:, :, free]), 2, (1, 2)).max()
    apart = np.abs(coordinates(first, times) - coordinates(second, times)).max()
    assert apart <= 4.0 * stiff * error
    assert second.checks.closure_m < 1e-13 * machine.reach_m
    assert second.warnings[0] == machine.closing


def tied(off: tuple[float, float], slot: bool = False, scale: float = 1.0) -> Mechanism:
    """A bar on a sled of a second hinge; its tip misses that of the other by some length."""
    tip = (scale * (0.08 + off[0]), scale * (0.06 + off[1]))
    parts = [
        link("arm", 1.0, 1e-3), link("lever", 1.0, 1e-3), link("rod", 1.0, 1e-3),
        hinge("O", "frame", "arm"), hinge("P", "frame", "lever", (scale * 0.2, 0.0)),
        hinge("K", "arm", "rod", (scale * 0.02, scale * 0.05)),
        frame("rod_tip", "rod", tip), frame("lever_tip", "lever", (scale * -0.1, scale * 0.11)),
    ]  # fmt: skip
    tie: dict[str, Any] = {"frame_a": "rod_tip", "frame_b": "lever_tip"}
    if slot:
        tie |= {"slot_axis": "x", "block_mass_kg": 0.01}
    return machine(parts, 2 if slot else 1, closures={"tie": tie})


@pytest.mark.parametrize("slot", [False, True])
@pytest.mark.parametrize("scale", [1.0, 25.4e-3, 1000.0])
def test_frames_move_by_half_of_the_gap(slot: bool, scale: float) -> None:
    off = (3e-6, -4e-6)
    whole, open_ = tied((0.0, 0.0), slot, scale), tied(off, slot, scale)
    (closure,) = open_.closures
    expected = np.array([0.0 if slot else -3e-6, 4e-6]) * scale
    np.testing.assert_allclose(closure.gap_m, expected, rtol=0.0, atol=1e-16 * max(scale, 1.0))
    (gaps,), _ = nip.simulate(
        open_, nip.Case(speed_rpm=60.0, window=nip.Window.CYCLE)
    ).system.body.closures(np.zeros((1, len(open_.joints))))
    assert np.abs(gaps).max() <= 1e-16 * open_.reach_m

    def place(mechanism: Mechanism, name: str) -> np.ndarray:
        item = next(item for item in mechanism.model.frames if item.name == name)
        return np.array(item.placement.translation)[[0, 2]]

    moved = place(open_, "lever_tip") - place(whole, "lever_tip")
    np.testing.assert_allclose(moved, -0.5 * expected, rtol=0.0, atol=1e-16 * max(scale, 1.0))
    # What is drawn of the link stays.
    still = np.array(own_frame(open_.model, "lever_tip").placement.translation)[[0, 2]]
    np.testing.assert_array_equal(still, place(whole, "lever_tip"))


def test_the_frame_itself_may_be_one_side() -> None:
    """The origin of the root link moves by half of the gap, too; what stands on it stays."""
    parts = [
        link("crank"), link("coupler"), link("rocker"), hinge("O", "frame", "crank", (-0.2, 0.0)),
        hinge("A", "crank", "coupler", (0.03, 0.05)), hinge("B", "coupler", "rocker", (0.12, 0.06)),
        frame("foot", "rocker", (0.050003, -0.110002)),
    ]  # fmt: skip
    drives = {"motor": {"joint": "O", "law": "constant_speed", "ratio": 0.05}}
    ties = {"pin": {"frame_a": "foot", "frame_b": "frame"}}
    found = machine(parts, 1, closures=ties, drives=drives)
    np.testing.assert_allclose(found.closures[0].gap_m, (-3e-6, 2e-6), rtol=0.0, atol=1e-16)
    places = {item.name: np.array(item.placement.translation) for item in found.model.frames}
    np.testing.assert_allclose(places["frame"], (1.5e-6, 0.0, -1e-6), rtol=0.0, atol=1e-16)
    assert found.model.jointPlacements[1].translation.tolist() == [-0.2, 0.0, 0.0]
    assert motion(found)[0].checks.closure_m < 1e-15


def test_frames_of_several_closures_move_together() -> None:
    """Three rods in one pin: the least sum of squares closes both gaps."""
    parts = [link(name, 1.0, 1e-3) for name in ("a", "b", "c", "a_2", "c_2")]
    parts += [
        hinge("A", "frame", "a"), hinge("A_2", "a", "a_2", (0.03, 0.04)),
        hinge("B", "frame", "b", (0.1, 0.0)),
        hinge("C", "frame", "c", (0.2, 0.0)), hinge("C_2", "c", "c_2", (0.01, 0.04)),
        frame("a_tip", "a_2", (0.07 + 2e-6, 0.06)), frame("b_tip", "b", (-1e-6, 0.1)),
        frame("c_tip", "c_2", (-0.11, 0.06 + 3e-6)),
    ]  # fmt: skip
    ties = {
        "ab": {"frame_a": "a_tip", "frame_b": "b_tip"},
        "bc": {"frame_a": "b_tip", "frame_b": "c_tip"},
    }
    found = machine(parts, 1, closures=ties)
    gaps = np.array([closure.gap_m for closure in found.closures])
    np.testing.assert_allclose(gaps, [[-3e-6, 0.0], [1e-6, 3e-6]], rtol=0.0, atol=1e-16)
    places = {item.name: np.array(item.placement.translation) for item in found.model.frames}
    # All three go to the mean of their places, the point with the least sum of squares.
    mean = np.array([0.1 + (2e-6 - 1e-6) / 3.0, 0.0, 0.1 + 1e-6])
    hung = {"a_tip": (0.03, 0.04), "b_tip": (0.1, 0.0), "c_tip": (0.21, 0.04)}
    for name, (x, z) in hung.items():
        np.testing.assert_allclose(places[name] + [x, 0.0, z], mean, rtol=0.0, atol=1e-16)


def test_larger_gaps_are_refused_with_both_frames() -> None:
    reach = tied((0.0, 0.0)).reach_m
    for share in (1.01e-4, 1e-3, 0.1):
        with pytest.raises(
            nip.AssemblyError, match=r"rod_tip to lever_tip.*lever_tip by x"
        ) as told:
            tied((share * reach, 0.0))
        assert told.value.evidence["key"] == "closures.tie"
        assert f"{1e3 * share * reach:.6g} mm" in told.value.evidence["value"]
    assert tied((0.99e-4 * reach, 0.0)).closing


def test_no_change_of_numbers_is_closed() -> None:
    """Pins move together, however far; one side alone is refused, however little it opens."""
    mechanism = nip.load(STRANGERS / "sw_fourbar_5")
    before = mechanism.closures
    moved = changed(mechanism, {"points.rocker_end.x_mm": 190.0, "links.crank.mass_kg": 0.2})
    for first, second in zip(before, moved.closures, strict=True):
        np.testing.assert_allclose(second.gap_m, first.gap_m, rtol=0.0, atol=1e-16)
    both = {"points.rocker_end.x_mm": 190.0, "points.coupler_end.x_mm": 190.0}
    both |= {"points.rocker_end.z_mm": 120.0, "points.coupler_end.z_mm": 120.0}
    assert changed(mechanism, both).closing
    path = "urdf.joint.rocker_end_fix.origin.xyz.x"
    with pytest.raises(nip.AssemblyError, match=r"closures\.pin_B"):
        changed(mechanism, {path: 0.130005})
    with pytest.raises(nip.AssemblyError, match=r"closures\.pin_B"):
        nip.load(STRANGERS / "sw_fourbar_5", {path: 0.130005})
    e62 = nip.load("e62")
    with pytest.raises(nip.AssemblyError, match=r"closures\.rocker_axis"):
        changed(e62, {"urdf.joint.rocker_pin.origin.xyz.x": 0.182201})


def test_pins_off_their_slots_are_no_rounding() -> None:
    mechanism = nip.load(STRANGERS / "yoke_6dec")
    assert changed(mechanism, {"points.pin.x_mm": 26.188}).closures == mechanism.closures
    with pytest.raises(nip.AssemblyError, match=r"closures\.s"):
        changed(mechanism, {"points.pin.x_mm": 26.189})


def test_the_slot_of_a_frame_that_is_turned_says_which_line_it_is() -> None:
    """Half a turn about its x: the y axis points out of the page, and z is that of the view."""
    urdf, document = ((STRANGERS / "yoke_6dec" / f"yoke_6dec.{kind}").read_text(encoding="utf-8")
                      for kind in ("urdf", "toml"))  # fmt: skip
    turned = urdf.replace('rpy="0 0.20944 0"', 'rpy="3.141592653589793 0.20944 0"')
    told = r"along z of slot to pin' .* z of the side view, as the y axis of slot does not point"
    with pytest.raises(nip.AssemblyError, match=told):
        from_sources("yoke", turned, tomllib.loads(document), ".")


def test_both_engines_close_the_e62() -> None:
    """Rounded to eight digits: the transition of both is that of the whole file to 1e-6."""
    e62 = nip.load("e62")
    short = from_sources("e62", rounded(e62.urdf, "{:.8g}")[0], e62.description, e62.mesh_folder)
    assert short.closing
    case = nip.Case(speed_rpm=650.0)
    direct = nip.simulate(short, case)
    times = [hit.t for hit in direct.collisions]
    whole = [hit.t for hit in nip.simulate(e62, case).collisions]
    np.testing.assert_allclose(times[:4], whole[:4], rtol=1e-6)
    fast = transition(reduced_model(short), speed_rpm=650.0)
    np.testing.assert_allclose(fast.time[:4], times[:4], rtol=1e-8, atol=1e-12)


def test_check_and_documents_say_by_how_much(capsys: pytest.CaptureFixture[str]) -> None:
    model = str(STRANGERS / "sw_fourbar_5")
    mechanism = nip.load(model)
    documents = []
    for words in (["check", model], ["simulate", model, "--window", "cycle"]):
        assert main([*words, "--json", "-"]) == 0
        documents.append(json.loads(capsys.readouterr().out))
    record, run = documents
    assert record["closing"] == mechanism.closing
    assert record["closures"][0]["gap_m"] == list(mechanism.closures[0].gap_m)
    assert run["warnings"] == [mechanism.closing]
    assert main(["check", model]) == 0
    assert "0.00421 mm" in capsys.readouterr().out
