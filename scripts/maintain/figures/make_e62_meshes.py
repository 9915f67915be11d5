"""Make the solids that combers of the E62's layout are drawn with, from the model's dimensions.

The shapes are illustrations around estimated points and collision shapes, not the maker's parts.
The engine never sees them. The script writes one binary STL a solid into ``meshes`` of the model's
folder and the ``<visual>`` elements of the URDF, whose materials it expects there; it changes
nothing else.

Run: python scripts/maintain/figures/make_e62_meshes.py [MODEL FOLDER ...]
     without folders: those of the models e62 and e62_offset_guide
"""

from __future__ import annotations

import re
import sys
from collections.abc import Sequence
from pathlib import Path

from e62_frame import frame
from e62_links import bottom_nipper, pendulum_arm, rocker, top_nipper
from e62_part import Part
from e62_shapes import Model
from e62_steeve import eccentric, steeve

OWN = ("e62", "e62_offset_guide")


def visual(part: Part) -> str:
    """The element of the URDF that draws a part."""
    scaled = f' scale="{part.scale}"' if part.scale else ""
    origin = part.origin or 'xyz="0 0 0" rpy="0 0 0"'
    mesh = f'<mesh filename="meshes/{part.file or part.name}.stl"{scaled}/>'
    return (
        f'    <visual name="{part.name}">\n'
        f"      <origin {origin}/>\n"
        f"      <geometry>{mesh}</geometry>\n"
        f'      <material name="{part.material}"/>\n'
        "    </visual>\n"
    )


def write_visuals(urdf: Path, parts: Sequence[Part]) -> None:
    """Replace the visual elements of a URDF; every other character stays."""
    text = re.sub(r" *<visual\b.*?</visual>\n", "", urdf.read_text(encoding="utf-8"), flags=re.S)
    for link in dict.fromkeys(part.link for part in parts):
        block = "".join(visual(part) for part in parts if part.link == link)
        # A link's visuals stand after its inertia, or first in a link without one.
        place = re.compile(rf'(<link name="{link}">\n(?: *<inertial>.*?</inertial>\n)?)', re.S)
        found = place.search(text)
        if found is None:
            sys.exit(f"{urdf}: there is no link {link}")
        text = text[: found.end()] + block + text[found.end() :]
    urdf.write_text(text, encoding="utf-8")


def make(home: Path) -> None:
    """Write meshes and visual elements of one model and say how large the meshes are."""
    model = Model(home)
    makers = (frame, pendulum_arm, bottom_nipper, rocker, top_nipper, steeve, eccentric)
    parts = [part for maker in makers for part in maker(model)]
    target = home / "meshes"
    target.mkdir(exist_ok=True)
    for old in target.glob("*.stl"):
        old.unlink()
    total = 0
    for part in parts:
        if part.mesh is None:
            continue
        if not part.mesh.is_watertight:
            sys.exit(f"{part.name}: the solid is not closed")
        data = part.mesh.export(file_type="stl")
        if not isinstance(data, bytes):
            sys.exit(f"{part.name}: trimesh wrote text where binary STL was asked for")
        total += (target / f"{part.file or part.name}.stl").write_bytes(data)
        print(f"{part.link:14} {part.name:24} {len(part.mesh.faces):6} triangles")
    write_visuals(home / f"{home.name}.urdf", parts)
    print(f"wrote {total / 1e3:.0f} kB into {target}")


def main(*folders: str) -> None:
    """Make the solids of the models named, or of all that come with the package."""
    models = Path(__file__).resolve().parents[3] / "models"
    for home in map(Path, folders) if folders else (models / name for name in OWN):
        make(home)


if __name__ == "__main__":
    main(*sys.argv[1:])
