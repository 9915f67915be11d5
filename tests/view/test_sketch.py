"""The labelled drawing: every part by its name, where Pinocchio has it."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin
import pytest
from matplotlib.figure import Figure
from matplotlib.text import Annotation
from PIL import Image
from runs_shown import machine_called

from nipper_pin import load
from nipper_pin.cli import main
from nipper_pin.mechanism import known_models
from nipper_pin.view.figure_file import save_figure
from nipper_pin.view.sketch import sketch, write_sketch
from nipper_pin.view.sketch.draw import drawn

# A slot, a damper between two points, springs on hinges, two stops on one part.
FEW = ("jaw_crusher", "door_closer", "ratchet_feed")
MACHINES = (*sorted(known_models()), *FEW)


@pytest.mark.parametrize("name", MACHINES)
def test_parts_stand_where_pinocchio_has_them(name: str) -> None:
    """Pins at the frames of the model; links through the pins of their own; contacts of stops."""
    mechanism = machine_called(name)
    shown = sketch(mechanism)
    model = mechanism.model
    data = model.createData()
    pin.framesForwardKinematics(model, data, np.zeros(model.nq))
    nodes = {node.name: node for node in shown.nodes}
    assert set(nodes) == {
        *(joint.name for joint in mechanism.joints), *(item.name for item in mechanism.closures)
    }  # fmt: skip
    for joint in mechanism.joints:
        at = data.oMi[model.getJointId(joint.name)].translation[[0, 2]]
        node = nodes[joint.name]
        if joint.kind == "revolute":
            assert node.kind == "pin"
            np.testing.assert_allclose(node.place, at, atol=1e-14)
            assert not node.along.any()
        else:
            # Somewhere on the line of the slide, whose direction moves the child for a unit of q.
            q = np.zeros(model.nq)
            q[joint.index] = 1e-3
            pin.forwardKinematics(model, data, q)
            moved = data.oMi[model.getJointId(joint.name)].translation[[0, 2]] - at
            pin.framesForwardKinematics(model, data, np.zeros(model.nq))
            np.testing.assert_allclose(node.along, 1e3 * moved, atol=1e-9)
            off = node.place - at
            assert abs(off[0] * moved[1] - off[1] * moved[0]) < 1e-12
        drive = [item.name for item in mechanism.drives if item.index == joint.index]
        assert node.driven == "".join(drive)
    for item in mechanism.closures:
        for frame in (item.frame_a,) if item.slot_frame else (item.frame_a, item.frame_b):
            at = data.oMf[model.getFrameId(frame)].translation[[0, 2]]
            np.testing.assert_allclose(nodes[item.name].place, at, atol=1e-9)
    for stop, mark in zip(mechanism.stops, shown.stops, strict=True):
        assert mark.name == stop.name
        if stop.contact is not None:
            np.testing.assert_array_equal(mark.place, stop.contact.point[[0, 2]])
    by_name = {link.name: link for link in shown.links}
    assert set(by_name) == {joint.child for joint in mechanism.joints}
    for joint in mechanism.joints:
        at = data.oMi[model.getJointId(joint.name)].translation[[0, 2]]
        for link in (joint.parent, joint.child):
            if link in by_name:
                assert np.abs(by_name[link].points - at).max(axis=1).min() < 1e-14


@pytest.mark.sampled(3)
@pytest.mark.parametrize("name", MACHINES)
def test_every_part_has_its_name_beside_it(name: str) -> None:
    """All names are written, inside of the drawing, and none on another one."""
    mechanism = machine_called(name)
    figure = drawn(sketch(mechanism))
    (axes,) = figure.axes
    figure.canvas.draw()
    labels: list[Any] = [
        item for item in axes.texts if isinstance(item, Annotation) and item.get_text()
    ]
    said = "\n".join(item.get_text() for item in labels)
    parts = [joint.child for joint in mechanism.joints]
    parts += [item.name for item in (*mechanism.joints, *mechanism.closures)]
    parts += [f"driven: {item.name}" for item in mechanism.drives]
    parts += [f"spring: {item.name}" for item in mechanism.springs]
    parts += [f"stop: {item.name}" for item in mechanism.stops]
    parts += [item.name for item in mechanism.struts]
    for part in parts:
        wanted = part if ":" in part else part.replace("_", " ")
        assert wanted in said, part
    room, others = axes.get_window_extent(), list[Any]()
    for label in labels:
        box = label.get_bbox_patch().get_window_extent()
        assert room.x0 <= box.x0 < box.x1 <= room.x1
        assert room.y0 <= box.y0 < box.y1 <= room.y1
        assert box.count_overlaps(others) == 0, label.get_text()
        others.append(box)


def test_the_same_model_gives_the_same_bytes(tmp_path: Path) -> None:
    """Names inside an SVG are not drawn by lot, and no file says when it was drawn."""
    drawings = [
        write_sketch(load("hanging_pendulum"), tmp_path / f"{name}.svg") for name in ("one", "two")
    ]
    assert drawings[0].read_bytes() == drawings[1].read_bytes()
    for kind in ("svg", "pdf"):
        pair = [tmp_path / f"{name}_curve.{kind}" for name in ("one", "two")]
        for path in pair:
            figure = Figure()
            axes = figure.subplots()
            axes.plot([0.0, 1.0], marker="o")
            axes.set(xticks=[], yticks=[])  # without texts, whose fonts take a second
            save_figure(figure, path, kind)
        first, second = (path.read_bytes() for path in pair)
        assert first == second
        assert not re.search(rb"CreationDate|dc:date|20[0-9]{2}-[0-9]{2}-", first)


@pytest.mark.slow
def test_a_drawing_is_what_its_suffix_says(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Another suffix is refused before anything is computed."""
    for kind, head in (("svg", b"<?xml"), ("png", b"\x89PNG"), ("pdf", b"%PDF")):
        path = tmp_path / f"e62.{kind}"
        assert main(["check", "e62", "--drawing", str(path)]) == 0
        assert path.read_bytes().startswith(head)
    with Image.open(tmp_path / "e62.png") as image:
        assert len(image.convert("RGB").getcolors(1 << 24)) > 100
    capsys.readouterr()
    assert main(["check", "e62", "--drawing", str(tmp_path / "e62.gif")]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert "NAME.svg, NAME.png, NAME.pdf" in err
    assert not (tmp_path / "e62.gif").exists()
