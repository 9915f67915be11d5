"""Meshes of other people: corners that are no points, files that are too large, and addresses."""

from __future__ import annotations

import base64
import math
import re
import shutil
import struct
from pathlib import Path

import numpy as np
import pytest

from nipper_pin import Case, InputError, Mechanism, ModelError, load, simulate, view
from nipper_pin.cli import main
from nipper_pin.mechanism import find_model
from nipper_pin.view.scene import solids
from nipper_pin.view.scene.meshes import as_stl, read_mesh

PARTS = Path(__file__).parent / "bases" / "parts"
ADDRESS = "http://tracker.example:81/skin.png"
DAE = (PARTS.parent / "tetrahedron.dae").read_text(encoding="utf-8")
CORNERS = "0 0 0 1 0 0 0 1 0 0 0 1"
OBJ = "mtllib http://tracker.example:81/skin.mtl\nv 0 0 0\nv X 0 0\nv 0 1 0\nv 0 0 1\n"
OBJ += "f 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"


def stl(value: float) -> bytes:
    """A tetrahedron with one number of a corner."""
    corners = np.array([[0, 0, 0], [value, 0, 0], [0, 1, 0], [0, 0, 1]], dtype="<f4")
    rows = b"".join(
        struct.pack("<3f", 0, 0, 0) + corners[list(face)].tobytes() + b"\0\0"
        for face in ((0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3))
    )
    return bytes(80) + struct.pack("<I", 4) + rows


def dae(value: str) -> bytes:
    return (
        DAE.replace("ADDRESS", ADDRESS).replace("CORNERS", CORNERS.replace("1", value, 1)).encode()
    )


BAD = {
    "nan.stl": stl(float("nan")), "inf.stl": stl(float("inf")), "far.stl": stl(1e30),
    "nan.obj": OBJ.replace("X", "nan").encode(), "far.obj": OBJ.replace("X", "1e39").encode(),
    "nan.dae": dae("nan"), "far.dae": dae("1e12"),
    # Whose reader makes one corner of all that are no numbers.
    "all.stl": bytes(80) + struct.pack("<I12fH", 1, *[math.nan] * 12, 0),
    "text.stl": b"solid x\nfacet normal nan nan nan\nouter loop\n"
                + 3 * b"vertex nan nan nan\n" + b"endloop\nendfacet\nendsolid x\n",
}  # fmt: skip


def model(folder: Path, geometry: str, tag: str, base: Path = PARTS, link: str = "ls3") -> Path:
    """A model with one more shape on a link."""
    home = folder / base.name
    shutil.copytree(base, home)
    file = home / f"{base.name}.urdf"
    text = file.read_text(encoding="utf-8")
    place = text.index("</link>", text.index(f'<link name="{link}">'))
    shape = f"<{tag}><geometry>{geometry}</geometry></{tag}>"
    file.write_text(text[:place] + shape + text[place:], encoding="utf-8")
    return home


@pytest.mark.parametrize("name", BAD)
def test_corners_that_are_no_points_are_named(
    name: str, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    """In a shape that touches, and in one that is only drawn."""
    home = model(tmp_path, f'<mesh filename="{name}"/>', "collision")
    (home / name).write_bytes(BAD[name])
    with pytest.raises(ModelError, match=r"link ls3 collision .*corner \d at .*finite"):
        load(home)
    assert main(["check", str(home)]) == 2
    assert main(["view", str(home), "--html", str(tmp_path / "page.html")]) == 2
    assert capfd.readouterr().out == ""
    with pytest.raises(ModelError, match=rf"{re.escape(name)}: mesh = 'corner \d at"):
        read_mesh(home / name)


def test_right_meshes_are_read_alike(tmp_path: Path) -> None:
    found = []
    for name, content in (("a.stl", stl(1.0)), ("a.obj", OBJ.replace("X", "1").encode()),
                          ("a.dae", dae("1"))):  # fmt: skip
        (tmp_path / name).write_bytes(content)
        found.append(read_mesh(tmp_path / name))
    for corners, faces in found:
        np.testing.assert_array_equal(corners, found[0][0])
        volume = np.linalg.det(corners[faces]).sum() / 6.0
        assert volume == pytest.approx(1.0 / 6.0)
        (tmp_path / "b.stl").write_bytes(as_stl(corners, faces))
        np.testing.assert_array_equal(read_mesh(tmp_path / "b.stl")[0], corners)


def sent(page: str) -> bytes:
    """The page, and all that stands in it in base64."""
    found = re.findall(r'"([A-Za-z0-9+/=]{40,})"', page)
    assert found
    return page.encode() + b"".join(base64.b64decode(item) for item in found)


def skinned(folder: Path, name: str, content: bytes) -> Mechanism:
    """The E62 with a mesh and a material that name an address."""
    home = model(folder, f'<mesh filename="{name}"/>', "visual", find_model("e62"), "top_nipper")
    (home / name).write_bytes(content)
    file = home / "e62.urdf"
    skin = f'<material name="skin"><texture filename="{ADDRESS}"/></material></robot>'
    text = file.read_text(encoding="utf-8").replace("</robot>", skin)
    file.write_text(text, encoding="utf-8")
    return load(home)


@pytest.mark.parametrize("name", ["a.dae", "a.obj"])
def test_no_address_of_a_file_is_sent_to_a_browser(name: str, tmp_path: Path) -> None:
    """Textures may stand at any address, and whoever looks at a model must not be told there."""
    content = dae("1") if name == "a.dae" else OBJ.replace("X", "1").encode()
    assert b"tracker.example" in content
    mechanism = skinned(tmp_path, name, content)
    assert name in {item.path.name for item in solids(mechanism) if item.path is not None}
    run = simulate(mechanism, Case(speed_rpm=650.0))
    page = tmp_path / "page.html"
    view(run, str(page))
    everything = sent(page.read_text(encoding="utf-8"))
    assert everything.count(b"_meshfile_geometry") >= 2
    assert b"tracker.example" not in everything
    scene = everything[page.stat().st_size :]
    assert b"http" not in scene


PLY = b"ply\nformat ascii 1.0\nelement vertex 999999999\nproperty float x\nend_header\n0\n"
OWN_NODES = "".join(
    f'<node id="n{k}">' + f'<instance_node url="#n{k - 1}"/>' * 10 + "</node>" for k in range(1, 9)
)
COSTLY = {
    "announced.ply": PLY, "announced.stl": PLY, "announced.obj": PLY,
    "announced.dae": dae("1").replace(b'count="12"', b'count="999999999"'),
    # A face of 600,000 corners; a mesh drawn 100,000,000 times; deeper than a stack.
    "face.obj": b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf " + b"1 2 3 " * 200_000,
    "repeated.dae": dae("1").replace(
        b"<library_visual_scenes>",
        b'<library_nodes><node id="n0"><instance_geometry url="#g"/></node>'
        + OWN_NODES.encode() + b"</library_nodes><library_visual_scenes>",
    ).replace(b'<node id="n">', b'<node id="n"><instance_node url="#n8"/>'),
    "deep.dae": dae("1").replace(b'<node id="n">', b"<node>" * 50_000 + b'<node id="n">').replace(
        b"</visual_scene>", b"</node>" * 50_000 + b"</visual_scene>"
    ),
    "long.obj": b"v 0 0 0\nv 1 0 0\nv 0 1 0\n" + b"f 1 2 3\n" * 2_000_000,
}  # fmt: skip


# Their trial ends where a process may take no more.
LONGEST = ("face.obj", "repeated.dae", "long.obj")


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=[pytest.mark.slow] * (name in LONGEST)) for name in COSTLY]
)
def test_meshes_that_cost_too_much_are_refused(name: str, tmp_path: Path) -> None:
    """Whatever they announce or repeat: as one that touches and as one that is drawn."""
    home = model(tmp_path, f'<mesh filename="{name}"/>', "collision")
    (home / name).write_bytes(COSTLY[name])
    with pytest.raises(ModelError, match="mesh"):
        load(home)
    with pytest.raises(InputError, match="mesh"):
        read_mesh(home / name)
