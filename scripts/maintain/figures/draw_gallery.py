"""Draw every machine of the gallery as a small SVG, and write the pages that show them.

Each is drawn in its touch configuration from what the viewer draws, with the path of one point
over a turn, as the links move where nothing is struck.

Run: python scripts/maintain/figures/draw_gallery.py [FOLDER]
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np

import nipper_pin as nip
from nipper_pin.arrays import FloatArray
from nipper_pin.errors import SimulationError
from nipper_pin.mechanism.drawing import Drawing, Slot, Spring, Stop, drawn_mechanism
from nipper_pin.mechanism.gallery import GALLERY, GROUPS
from nipper_pin.view.scene import Look, film
from nipper_pin.view.scene.flat import Flat, colours, flat, moved
from nipper_pin.view.scene.solids import Solid, solids

_SIZE = 240.0  # of the longer side [px]
_SLOW_RPM = 1.0  # so slow that springs hold everything on its stop
_STIFFER = 1e3
_PAGE = """# Gallery

{count} textbook linkages, each with one or two stops somewhere along its motion. A machine whose
motion the drive determines completely cannot bounce; each of these therefore has a part with a
freedom of its own: a rod of two halves on a preloaded spring, a spring-held lever, a loose box.
Start from one, change its numbers, replace its parts:

    nipper-pin new --list
    nipper-pin new --from toggle_press my_press
    nipper-pin check my_press
    nipper-pin simulate my_press --window cycle

{contents}

They run whole turns at half, once and twice their rated speed, with held and inertial drives. The
pictures show them in the touch configuration, in which all coordinates are zero; the red line is
the path of one point over a turn without impacts. Dimensions that are known from a source are
named below each picture. All other numbers, masses, springs and stops above all, are inventions.

## Draw your own

In Python a machine is a drawing: points in mm, bodies through them, pins, slides and slots, a
drive, springs and stops. Joints are listed from the frame outwards: the first one that leads to a
body carries it, any other pin closes a loop.

```python
from nipper_pin.mechanism.drawing import (
    Body, Drawing, Drive, Pin, Slide, Stop, telescope, write_drawing,
)

press = Drawing(
    "press", "slider-crank on an anvil",
    {{"O": (0.0, 0.0), "A": (-15.0, -20.0), "B": (0.0, -132.0)}},
    (
        Body("crank", "O A"),
        Body("ram", "B", mass_kg=1.5),
        Pin("O", "frame", "crank"),
        Pin("A", "crank", "rod_1"),
        *telescope("rod", "A B", stiffness=20000.0, preload_mm=10.0),
        Slide("height", "frame", "ram", at="B", along=(0.0, 1.0)),
        Pin("B", "rod_2", "ram"),
        Drive("O"),
        Stop("height"),
    ),
    touch_deg=-126.8699, start_deg=-270.0, speed_rpm=120.0, closed=("rod",), struck="height",
)
write_drawing(press, "press")
```

The drawings of the gallery are in `nipper_pin/mechanism/gallery/`; `make pictures` writes these
pages.
"""
# Pages of the machines: their title, and the first kind on each.
_PARTS = {
    "gallery_linkages": ("Gallery: four-bars to six-bars", "Four-bars"),
    "gallery_machines": ("Gallery: straight lines, legs, machines, devices", "Straight lines"),
}


def main(folder: str = "docs") -> None:
    """Draw all machines and write the pages.

    Args:
        folder: Folder of the pages; pictures go to ``images/gallery`` in it.
    """
    pictures = Path(folder) / "images" / "gallery"
    pictures.mkdir(parents=True, exist_ok=True)
    for draw in GALLERY.values():
        drawing = draw()
        (pictures / f"{drawing.name}.svg").write_text(picture(drawing), encoding="utf-8")
    texts = pages()
    for name, text in texts.items():
        (Path(folder) / f"{name}.md").write_text(text, encoding="utf-8")
    print(f"wrote {len(texts)} pages and {len(GALLERY)} pictures to {folder}")


def pages() -> dict[str, str]:
    """Return the text of each page, by its name."""
    parts = {name: [f"# {title}\n"] for name, (title, _) in _PARTS.items()}
    contents = []
    name = ""
    for kind, group in GROUPS.items():
        name = next((page for page, (_, first) in _PARTS.items() if first == kind), name)
        machines = [draw().name for draw in group]
        links = ", ".join(f"[{each}]({name}.md#{each})" for each in machines)
        contents.append(f"- **{kind}**: {links}")
        parts[name] += [f"## {kind}\n", *map(_shown, group)]
    front = _PAGE.format(count=len(GALLERY), contents="\n".join(contents))
    return {"gallery": front, **{name: "\n".join(lines) for name, lines in parts.items()}}


def _shown(draw: Callable[[], Drawing]) -> str:
    """A machine on its page: heading, picture, and what is known of it."""
    drawing = draw()
    first = (draw.__doc__ or "").splitlines()[0]
    words = _sentence(drawing.known or "all numbers are inventions")
    return (
        f"### {drawing.name}\n\n"
        f"![{drawing.title}](images/gallery/{drawing.name}.svg)\n\n"
        f"{first} {_sentence(drawing.title)} {words}\n"
    )


def picture(drawing: Drawing) -> str:
    """One machine as the text of an SVG."""
    shown = film(_unstopped(drawing), Look(slow=1.0))
    solution = shown.solution
    drawn = solids(solution.mechanism)
    seen = flat(shown, drawn)
    # The frame that is nearest to the drawing: all coordinates zero.
    touch = int(np.argmin(np.abs(shown.drawn).max(axis=1)))
    corners = moved(seen, shown, touch)
    path = np.zeros((0, 2))
    if drawing.traced:
        link, point = drawing.traced.split()
        path = _path(drawing, shown.position, shown.angle, solution.mechanism, link, point)
    low = np.vstack([corners, path]).min(axis=0)
    high = np.vstack([corners, path]).max(axis=0)
    scale = _SIZE / float((high - low).max())

    def at(places: FloatArray) -> str:
        x = (places[:, 0] - low[0]) * scale + 4.0
        z = (high[1] - places[:, 1]) * scale + 4.0
        return " ".join(f"{a:.1f},{b:.1f}" for a, b in zip(x, z, strict=True))

    width, height = (high - low) * scale + 8.0
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width:.0f} {height:.0f}" '
        f'width="{width:.0f}" height="{height:.0f}">',
        f"<title>{drawing.title}</title>",
    ]
    # The block in a slot has no shape.
    blocks = {
        i for i, joint in enumerate(solution.mechanism.joints) if joint.child in _blocks(drawing)
    }
    fills = {n: fill for n, fill in _fills(seen, drawn).items() if drawn[n].body not in blocks}
    for place in sorted(fills, key=lambda item: drawn[item].placement[1, 3], reverse=True):
        lines.append(
            f'<polygon points="{at(corners[_outline(seen, place)])}" fill="{fills[place]}" '
            'stroke="#222" stroke-width="0.7"/>'
        )
    if len(path):
        lines.append(
            f'<polyline points="{at(path)}" fill="none" stroke="#c22" stroke-width="1" '
            'stroke-dasharray="3 2"/>'
        )
    return "\n".join([*lines, "</svg>", ""])


def _unstopped(drawing: Drawing) -> nip.Solution:
    """A slow turn in which nothing is struck and nothing gives way; a transition if that fails."""
    closed = [
        part
        for part in drawing.parts
        if isinstance(part, Stop) and (part.name or part.joint) in drawing.closed
    ]
    joints = {part.joint for part in closed}
    parts = tuple(
        replace(part, preload=_STIFFER * part.preload)
        if isinstance(part, Spring) and part.joint in joints
        else part
        for part in drawing.parts
        if not isinstance(part, Stop) or part in closed
    )
    case = nip.Case(speed_rpm=_SLOW_RPM, window=nip.Window.CYCLE)
    try:
        return nip.simulate(drawn_mechanism(replace(drawing, parts=parts, struck="")), case)
    except SimulationError:
        return nip.simulate(drawn_mechanism(drawing), nip.Case(speed_rpm=drawing.speed_rpm))


def _path(
    drawing: Drawing,
    position: FloatArray,
    angle: FloatArray,
    mechanism: nip.Mechanism,
    link: str,
    point: str,
) -> FloatArray:
    """Places of a link's point over the turn, shape (frames, 2) [m]."""
    body = next(i for i, joint in enumerate(mechanism.joints) if joint.child == link)
    joint = mechanism.joints[body]
    origin = np.array(mechanism.model.jointPlacements[mechanism.model.getJointId(joint.name)]
                      .translation)[[0, 2]]  # fmt: skip
    parent = joint.parent
    while (above := next((j for j in mechanism.joints if j.child == parent), None)) is not None:
        stands = mechanism.model.jointPlacements[mechanism.model.getJointId(above.name)]
        origin = origin + np.array(stands.translation)[[0, 2]]
        parent = above.parent
    local = 1e-3 * np.array(drawing.points[point]) - origin
    step = max(1, len(angle) // 90)
    turn = angle[::step, body]
    x = np.cos(turn) * local[0] - np.sin(turn) * local[1]
    z = np.sin(turn) * local[0] + np.cos(turn) * local[1]
    return np.asarray(position[::step, body] + np.column_stack([x, z]))


def _blocks(drawing: Drawing) -> set[str]:
    """Links that are blocks in slots."""
    return {f"{part.name}_block" for part in drawing.parts if isinstance(part, Slot)}


def _fills(seen: Flat, drawn: tuple[Solid, ...]) -> dict[int, str]:
    """Colour of the lightest face of each solid that is seen."""
    shades = colours(seen, drawn, (), (0.0, 0.0, 0.0))
    best: dict[int, tuple[float, str]] = {}
    for item, place, light, shade in zip(seen.items, seen.solid, seen.light, shades, strict=True):
        if len(item) == 3 and light > best.get(int(place), (0.0, ""))[0]:
            best[int(place)] = float(light), shade
    return {place: shade for place, (_, shade) in best.items()}


def _outline(seen: Flat, place: int) -> list[int]:
    """Corners of a solid's outline, in order."""
    follows: dict[int, list[int]] = {}
    for item, of in zip(seen.items, seen.solid, strict=True):
        if of == place and len(item) == 2:
            follows.setdefault(item[0], []).append(item[1])
            follows.setdefault(item[1], []).append(item[0])
    start = next(iter(follows))
    loop, before = [start], -1
    while True:
        here = loop[-1]
        ahead = next((n for n in follows[here] if n != before), start)
        if ahead == start:
            return loop
        before = here
        loop.append(ahead)


def _sentence(words: str) -> str:
    return f"{words[0].upper()}{words[1:]}."


if __name__ == "__main__":
    main(*sys.argv[1:2])
