"""Draw every machine of the gallery as a small SVG, and write the page that shows them.

Each is drawn in its touch configuration by the symbols of a sketch, with the path of one point
over a turn, as the links move where nothing is struck.

Run: python scripts/maintain/figures/draw_gallery.py [FOLDER]
"""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

import nipper_pin as nip
from nipper_pin.arrays import FloatArray
from nipper_pin.errors import SimulationError
from nipper_pin.mechanism.gallery import GALLERY, GROUPS, drawn
from nipper_pin.units import M_PER_MM, MM_PER_M
from nipper_pin.view.figure_file import save_figure
from nipper_pin.view.scene.film import Look, film, poses, worlds
from nipper_pin.view.sketch.draw import symbols
from nipper_pin.view.sketch.places import sketch

_SIZE_IN = 3.6  # of the longer side
_ROOM = 0.05  # around the machine, by its size
_SLOW_RPM = 1.0  # so slow that springs hold everything on its stop
_STIFFER = 1e3
_PAGE = Path(__file__).with_name("gallery_page.md")


def main(folder: str = "docs") -> None:
    """Draw all machines and write the page.

    Args:
        folder: Folder of the page; pictures go to ``images/gallery`` in it.
    """
    pictures = Path(folder) / "images" / "gallery"
    pictures.mkdir(parents=True, exist_ok=True)
    for drawing in map(drawn, GALLERY):
        save_figure(picture(drawing), pictures / f"{drawing.name}.svg", "svg")
    (Path(folder) / "gallery.md").write_text(page(), encoding="utf-8")
    print(f"wrote gallery.md and {len(GALLERY)} pictures to {folder}")


def page() -> str:
    """Return the text of the page."""
    shown, contents = [], []
    for kind, group in GROUPS.items():
        contents.append(f"- **{kind}**: {', '.join(f'[{name}](#{name})' for name in group)}")
        shown += [f"## {kind}\n", *map(_shown, group)]
    front = _PAGE.read_text(encoding="utf-8")
    return "\n".join([front.format(count=len(GALLERY), contents="\n".join(contents)), *shown])


def _shown(name: str) -> str:
    """A machine on its page: heading, picture, and what is known of it."""
    drawing = drawn(name)
    words = _sentence(drawing.tables.get("known") or "all numbers are inventions")
    return (
        f"### {drawing.name}\n\n"
        f"![{drawing.name}](images/gallery/{drawing.name}.svg)\n\n"
        f"{_sentence(drawing.tables['title'])} {words}\n"
    )


def picture(drawing: nip.Drawing) -> Figure:
    """One machine in its touch configuration, and the path of its point."""
    still = sketch(drawing.mechanism())
    path = np.zeros((0, 2))
    if traced := drawing.tables.get("traced"):
        path = _path(drawing)
        name, point = traced.split()
        at = M_PER_MM * np.array([drawing.points[point]])
        reaching = [replace(link, points=np.concatenate([link.points, at]))
                    if link.name == name else link for link in still.links]  # fmt: skip
        still = replace(still, links=tuple(reaching))
    corners = [*(link.points for link in still.links), *(ends for _, ends in still.struts)]
    points = MM_PER_M * np.concatenate([*corners, path])
    low, high = points.min(axis=0), points.max(axis=0)
    size = float((high - low).max())
    low, high = low - _ROOM * size, high + _ROOM * size
    width, height = _SIZE_IN * (high - low) / (high - low).max()
    figure = Figure(figsize=(width, height))
    FigureCanvasAgg(figure)
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    axes.set_axis_off()
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]))
    symbols(axes, still, size)
    axes.plot(*MM_PER_M * path.T, color="#cc2222", lw=1.0, ls="--", zorder=8)
    return figure


def _unstopped(drawing: nip.Drawing) -> nip.Solution:
    """A slow turn in which nothing is struck and nothing gives way; a transition if that fails."""
    stops = {name: drawing.tables["stops"][name] for name in drawing.tables["closed"]}
    joints = {stop["joint"] for stop in stops.values()}
    springs = {
        name: {
            key: _STIFFER * value
            if key.startswith("preload") and spring["joint"] in joints
            else value
            for key, value in spring.items()
        }
        for name, spring in drawing.tables.get("springs", {}).items()
    }
    tables = {**drawing.tables, "springs": springs, "stops": stops, "transition_stop": ""}
    case = nip.Case(speed_rpm=_SLOW_RPM, window=nip.Window.CYCLE)
    try:
        return nip.simulate(nip.Drawing(tables, drawing.name).mechanism(), case)
    except SimulationError:
        return nip.simulate(drawing.mechanism(), nip.Case(speed_rpm=drawing.tables["speed_rpm"]))


def _path(drawing: nip.Drawing) -> FloatArray:
    """Places of a link's point over the turn, shape (frames, 2) [m]."""
    link, point = drawing.tables["traced"].split()
    shown = film(_unstopped(drawing), Look(slow=1.0))
    solution = shown.solution
    joints = solution.mechanism.joints
    body = next(i for i, joint in enumerate(joints) if joint.child == link)
    touch = worlds(*poses(solution, np.zeros_like(shown.q[:1])))
    moved = (worlds(shown.position, shown.angle) @ np.linalg.inv(touch))[:, body]
    path = moved @ [*(M_PER_MM * np.array(drawing.points[point])), 1.0]
    return np.asarray(path[:: max(1, len(path) // 90), :2])


def _sentence(words: str) -> str:
    return f"{words[0].upper()}{words[1:]}."


if __name__ == "__main__":
    main(*sys.argv[1:2])
