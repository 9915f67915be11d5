"""A film as one GIF file for reports: the sketch of the machine, moved, and the lips close up."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.patches import Patch, Polygon, Rectangle
from matplotlib.path import Path as Outline
from matplotlib.text import Text
from matplotlib.transforms import Affine2D
from PIL import Image

from ...arrays import FloatArray
from ...errors import InputError
from ...hybrid import Solution
from ...mechanism import Stop
from ...outputs import complete_file
from ...terms import digits
from ...units import MM_PER_M
from ..phases import intervals
from ..reading import case_text
from ..sketch.draw import DRIVE, symbols
from ..sketch.places import Sketch, sketch
from .arrows import (
    arrow_body,
    arrow_place,
    arrow_scale,
    arrow_shares,
    arrow_sizes,
)
from .closeup import close_up, lip_cuts
from .colours import ARROW
from .film import Film, Look, bouncing_stop, film, poses, worlds
from .pace import LONGEST
from .readings import collision_text, columns, note, rounded
from .solids import solids

Box = tuple[float, float, float, float]
PER_SECOND = 10  # pictures in a second of playback
_SLOWED = "use --slow with a smaller number, or --window transition"
_LONG = "the run itself is that long: simulate a shorter turn, with a larger --speed"
# Pixels: width and height; and left, top, right, bottom, from the upper left corner.
_SIZE, _DPI = (800, 560), 100
_MACHINE = (290, 60, 792, 466)
_LIPS = (16, 308, 272, 462)
_BAR = (16, 480, 784, 492)
_TEXT, _SMALL, _ROW = 13.0, 11.0, 21
_TITLE_COLUMNS, _COLUMNS, _NOTE_COLUMNS = 84, 34, 124
_INK, _PALE, _EDGE = "#101418", "#5c6670", "#30343a"
_MARGIN = 0.06  # of the size of the machine: room of its symbols around it
_SAMPLES = 8  # pictures that the palette is made of


def write_gif(solution: Solution, path: str | Path, look: Look | None = None) -> Path:
    """Write a solution as a GIF in side view: the film of the page, ten pictures a second.

    Raises:
        InputError: There is nothing to show, the film is longer than two minutes, a mesh cannot be
            read, or the file cannot be written.
    """
    shown = film(solution, look or Look())
    length = float(shown.pace.playback[-1])
    if length > LONGEST:
        message = (
            f"{path}: the film takes {length:.0f} s, and a GIF at most {LONGEST:.0f} s; "
            f"{_SLOWED if shown.pace.stretch.max() > 1.0 else _LONG}"
        )
        raise InputError(message, file=str(path), length_s=length)
    with complete_file(Path(path)) as partial:
        # A path that cannot be written is refused before the work, not after.
        partial.touch()
        _write(shown, partial)
    return Path(path)


def _write(shown: Film, partial: Path) -> None:
    moving = MovingSketch(shown)
    chosen = moving.frames[np.linspace(0, len(moving.frames) - 1, _SAMPLES).astype(int)]
    # One palette for all pictures, so that constant parts are stored once.
    samples = np.concatenate([np.asarray(moving.picture(int(frame))) for frame in chosen])
    palette = Image.fromarray(samples).quantize(256, Image.Quantize.FASTOCTREE)

    def pictures() -> Iterator[Image.Image]:
        for frame in moving.frames:
            picture = moving.picture(int(frame))
            yield picture.quantize(palette=palette, dither=Image.Dither.NONE)

    every = pictures()
    next(every).save(partial, format="GIF", save_all=True, append_images=every,
                     duration=1000 // PER_SECOND, loop=0)  # fmt: skip


class MovingSketch:
    """The sketch of a machine, with what a film says beside it: drawn once, moved by the frame.

    Attributes:
        figure: The picture drawn last; its axes are those of the machine [mm] and of the lips.
        frames: Places of the frames of the film that become pictures, shape (pictures,).
        moves: How each link has moved since the touch configuration, in mm, shape (K, links + 1, 3,
            3); the frame, which stands still, comes last.
    """

    def __init__(self, shown: Film) -> None:
        """Draw everything."""
        self._shown, solution = shown, shown.solution
        times = np.arange(0.0, shown.pace.playback[-1], 1.0 / PER_SECOND)
        self.frames = np.searchsorted(shown.pace.playback, times)
        self._worlds = worlds(shown.position, shown.angle)
        touch = worlds(*poses(solution, np.zeros_like(shown.drawn[:1])))
        self.moves = self._worlds @ np.linalg.inv(touch)
        self.moves[..., :2, 2] *= MM_PER_M
        self._intervals = intervals(solution)
        self.figure = Figure(figsize=(_SIZE[0] / _DPI, _SIZE[1] / _DPI), dpi=_DPI)
        self._canvas: Any = FigureCanvasAgg(self.figure)
        self._moved: list[Artist] = []
        self._tints: list[Callable[[str], None]] = []
        self._machine()
        self._close_up()
        self._texts()
        self._moved.sort(key=lambda artist: artist.get_zorder())
        for artist in self._moved:
            artist.set_animated(True)
        self._canvas.draw()  # type: ignore[no-untyped-call]
        self._ground = self._canvas.copy_from_bbox(self.figure.bbox)  # type: ignore[no-untyped-call]

    def picture(self, frame: int) -> Image.Image:
        """One picture."""
        self._move(frame)
        self._say(frame)
        self._canvas.restore_region(self._ground)
        for artist in self._moved:
            artist.draw(self._canvas.get_renderer())
        return Image.frombuffer("RGBA", _SIZE, self._canvas.buffer_rgba()).convert("RGB")

    def _machine(self) -> None:
        """The sketch: all that a link carries has one transform."""
        mechanism = self._shown.solution.mechanism
        still = sketch(mechanism)
        axes = self._axes(_MACHINE)
        made = symbols(axes, still, self._fit(axes, still))
        self._movers = [Affine2D() for _ in mechanism.joints]
        stop = bouncing_stop(mechanism)
        opening = None if stop is None else stop.index
        for link, bar in zip(still.links, made.links, strict=True):
            made.carried.append((link.body, bar))
            if link.body == opening:
                # Before the others, in the colour of the phase.
                bar.set_zorder(1.5)
                self._tints.append(bar.set_edgecolor)
        for body, artist in made.carried:
            if body == opening and isinstance(artist, Patch):
                self._tints.append(artist.set_facecolor)
            if body >= 0:
                artist.set_transform(self._movers[body] + axes.transData)
                self._moved.append(artist)
        self._struts = [(line, np.asarray(line.get_xydata()) @ [1.0, 1.0j]) for line in made.struts]
        self._arrows = [
            (item, axes.add_patch(Polygon(np.zeros((3, 2)), fc=ARROW, zorder=7)))
            for item in arrow_shares(self._shown.solution, self._shown.pace)
        ]
        self._moved += [*made.struts, *(patch for _, patch in self._arrows)]
        self._crank = still.crank
        if self._crank is not None:
            (self._pin,) = axes.plot([], [], color=DRIVE, lw=1.4, marker="o", ms=5, zorder=2)
            self._moved.append(self._pin)

    def _fit(self, axes: Axes, still: Sketch) -> float:
        """Make room for the whole motion, and return its size [mm]."""
        solution, frames = self._shown.solution, self.frames[:: 1 + len(self.frames) // 100]
        self._ends = MM_PER_M * solution.system.body.points(self._shown.drawn)[0]
        found = [self._ends.reshape(-1, 2)]
        for link in still.links:
            points = np.column_stack([MM_PER_M * link.points, np.ones(len(link.points))])
            moved = points @ self.moves[frames, link.body].transpose(0, 2, 1)
            found.append(moved[..., :2].reshape(-1, 2))
        if still.crank is not None:
            axis, radius = still.crank
            found.append(MM_PER_M * (axis + radius * np.array([[-1, -1], [1, 1]])))
        every = np.concatenate(found)
        low, high = every.min(axis=0), every.max(axis=0)
        size = float((high - low).max()) or MM_PER_M
        left, top, right, bottom = _MACHINE
        pixels = np.array([right - left, bottom - top])
        half = 0.5 * pixels * ((high - low + 2.0 * _MARGIN * size) / pixels).max()
        low, high = 0.5 * (low + high) - half, 0.5 * (low + high) + half
        axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]))
        return size

    def _close_up(self) -> None:
        """The cut through the lips at the contact point, as a camera sees it that follows them."""
        self._cuts: list[tuple[int, Affine2D]] = []
        self._lips = lips = close_up(self._shown)
        if lips is None:
            return
        mechanism = self._shown.solution.mechanism
        left, top, right, bottom = _LIPS
        axes = self._axes(_LIPS)
        high = 0.5 * lips.height
        wide = high * (right - left) / (bottom - top)
        axes.set(xlim=(-wide, wide), ylim=(-high, high))
        drawn, opening = solids(mechanism), mechanism.stop(lips.stop).index
        for cut in lip_cuts(mechanism, drawn, lips.across):
            mover, outer = Affine2D(), Outline(cut.loops[0])
            self._cuts.append((cut.body, mover))
            for number, loop in enumerate(cut.loops):
                hole = number > 0 and outer.contains_point(loop[0])
                patch = Polygon(loop, fc="white" if hole else drawn[cut.solid].colour, ec=_EDGE,
                                lw=0.7, transform=mover + axes.transData)  # fmt: skip
                self._moved.append(axes.add_patch(patch))
                if not hole and cut.body == opening:
                    self._tints.append(patch.set_facecolor)
        bar = Rectangle((-0.9 * wide, -0.9 * high), lips.scale_mm / MM_PER_M, 0.04 * high, fc=_INK)
        frame = Rectangle((-wide, -high), 2.0 * wide, 2.0 * high, fill=False, ec=_PALE, lw=1.5)
        self._moved += [axes.add_patch(bar), axes.add_patch(frame)]
        said = f"{lips.stop} cut along its hinge; bar {lips.scale_mm:g} mm"
        self._put((left, bottom + 1), said, _SMALL, _PALE)

    def _texts(self) -> None:
        """Texts and bars of all pictures, and those that change."""
        shown, mechanism = self._shown, self._shown.solution.mechanism
        title = mechanism.title or mechanism.name
        left, top, right, bottom = _BAR
        self._put((left, 12), textwrap.shorten(title, _TITLE_COLUMNS, placeholder=" ..."),
                  weight="bold")  # fmt: skip
        self._put((left, 34), case_text(shown.solution), _SMALL, _PALE)
        self._put((left, bottom + 8), textwrap.fill(note(shown), _NOTE_COLUMNS), _SMALL, _PALE)
        for item in self._intervals:
            begin = left + (right - left) * self._share_of_film(item.start)
            self._box((begin, top, right, bottom), item.colour)
        row = _MACHINE[1]
        square = self._box((left, row, left + 16, row + 16), _INK)
        self._phase = self._put((left + 24, row), weight="bold")
        self._columns = []
        for label, unit, values in columns(shown):
            row += _ROW
            self._put((left, row + 8), label, _SMALL)
            text = self._put((_MACHINE[0] - 20, row + 8), size=_SMALL, ha="right")
            self._columns.append((text, unit, rounded(values)))
        self._last = self._put((left, row + _ROW + 16), "", _SMALL, ARROW)
        self._mark = self._box((left, top - 4, left + 2, bottom + 4), _INK)
        self._tints.append(square.set_color)
        self._moved += [square, self._phase, *(text for text, _, _ in self._columns), self._last,
                        self._mark]  # fmt: skip

    def _move(self, frame: int) -> None:
        """Put everything where it is in a frame, and colour what has the colour of the phase."""
        shown = self._shown
        for tint in self._tints:
            tint(self._intervals[shown.phase[frame]].colour)
        for mover, matrix in zip(self._movers, self.moves[frame], strict=False):
            mover.set_matrix(matrix)
        for (line, coil), ends in zip(self._struts, self._ends[frame], strict=True):
            # As complex numbers: turned and stretched from end to end.
            begin, end = ends @ [1.0, 1.0j]
            here = begin + (coil - coil[0]) * (end - begin) / (coil[-1] - coil[0])
            line.set_data(here.real, here.imag)
        for (stop, times, shares), patch in self._arrows:
            share = float(np.interp(shown.pace.playback[frame], times, shares))
            patch.set(xy=self._arrow(stop, frame, share), visible=share > 0.0)
        if self._crank is not None:
            axis, radius = self._crank
            angle = shown.turned[frame] + shown.solution.mechanism.cylinder.angle_at_touch_rad
            pin = axis + radius * np.array([math.cos(angle), math.sin(angle)])
            self._pin.set_data(MM_PER_M * np.array([axis, pin]).T)
        if self._lips is not None:
            camera = Affine2D().translate(*-self._lips.place[frame])
            camera.rotate(0.5 * math.pi - float(self._lips.angle[frame]))
            for body, mover in self._cuts:
                mover.set_matrix(camera.get_matrix() @ self._worlds[frame, body])

    def _say(self, frame: int) -> None:
        """Write phase, numbers and last collision, and mark the time in the film."""
        shown, solution = self._shown, self._shown.solution
        self._phase.set_text(self._intervals[shown.phase[frame]].name)
        for text, unit, values in self._columns:
            text.set_text(f"{digits(values[frame])} {unit}".rstrip())
        done = [item for item in solution.collisions if item.t <= shown.pace.machine[frame]]
        last = [item for item in done if item.event is done[-1].event]
        said = collision_text(solution.mechanism, last) if last else ""
        self._last.set_text(textwrap.fill(said, _COLUMNS))
        at = self._share_of_film(shown.pace.machine[frame])
        self._mark.set_x((_BAR[0] - 1 + (_BAR[2] - _BAR[0]) * at) / _SIZE[0])

    def _share_of_film(self, t: float) -> float:
        playback = self._shown.pace.playback_at(t)
        return float(playback / self._shown.pace.playback[-1])

    def _arrow(self, stop: Stop, frame: int, share: float) -> FloatArray:
        """Outline of an arrow of an impulse, shape (7, 2) [mm]."""
        mechanism = self._shown.solution.mechanism
        shaft, thick, head, wide = arrow_sizes(mechanism)
        outline = np.array([(-thick, 0.0), (-thick, shaft), (-wide, shaft), (0.0, shaft + head),
                            (wide, shaft), (thick, shaft), (thick, 0.0)])  # fmt: skip
        place = arrow_place(mechanism, stop)
        local = outline * arrow_scale(share)[:2] @ place[[0, 2], :2].T + place[[0, 2], 3]
        world = self._worlds[frame, arrow_body(mechanism, stop)]
        return np.asarray(MM_PER_M * (local @ world[:2, :2].T + world[:2, 2]))

    def _axes(self, box: Box) -> Axes:
        axes = self.figure.add_axes(_shares(box))
        axes.set_axis_off()
        return axes

    def _box(self, box: Box, colour: str) -> Rectangle:
        x, y, width, height = _shares(box)
        patch = Rectangle((x, y), width, height, fc=colour, lw=0)
        self.figure.add_artist(patch)
        return patch

    def _put(self, at: tuple[float, float], text: str = "", size: float = _TEXT,
             colour: str = _INK, **how: Any) -> Text:  # fmt: skip
        x, y = at[0] / _SIZE[0], 1.0 - at[1] / _SIZE[1]
        points = 72.0 * size / _DPI
        return self.figure.text(x, y, text, fontsize=points, color=colour, va="top",
                                 parse_math=False, **how)  # fmt: skip


def _shares(box: Box) -> Box:
    """Left, bottom, width and height of a box, by the size of the picture."""
    left, top, right, bottom = box
    width, height = _SIZE
    return left / width, 1.0 - bottom / height, (right - left) / width, (bottom - top) / height
