"""A film as one GIF file, in side view, for reports and wherever no page can be played."""

from __future__ import annotations

import textwrap
from collections.abc import Iterator
from pathlib import Path

import matplotlib as mpl
import numpy as np
from PIL import Image, ImageDraw, ImageFont

from ...arrays import FloatArray
from ...errors import InputError
from ...hybrid.result.solution import Solution
from ...mechanism import Stop
from ...outputs import complete_file
from ...terms import digits
from ..phases import intervals
from ..reading import case_text
from .arrows import (
    FADE,
    HELD,
    arrow_body,
    arrow_place,
    arrow_scale,
    arrow_sizes,
    arrow_stops,
    drawn_collisions,
)
from .closeup import close_up
from .colours import ARROW, LINE, channels
from .film import Film, Look, bouncing_stop, film
from .flat import colours, flat, moved, placed
from .flat_lips import LipsPainter
from .pace import LONGEST
from .readings import collision_text, columns, note, rounded
from .solids import solids

PER_SECOND = 10  # pictures in a second of playback
_SLOWED = "use --slow with a smaller number, or --window transition"
_LONG = "the run itself is that long: simulate a shorter turn, with a larger --speed"
_SIZE = (800, 560)
_SHARP = 2  # pixels drawn for each one of the file, along each side
_BOX = (290, 66, 784, 462)  # of the mechanism
_BAR = (16, 480, 784, 492)  # of the phases
_LIPS = (16, 308, 272, 462)  # of the lips close up
_TEXT = 13
_SMALL = 11
_LEFT = 16
_ROW = 21
_EDGE = "#30343a"
_INK = "#101418"
_PALE = "#5c6670"
_COLUMNS = 34
_NOTE_COLUMNS = 124
_SAMPLES = 8  # pictures that the palette is made of
_NEAR = 8  # of 255: two colours that differ by less are one


def write_gif(solution: Solution, path: str | Path, look: Look | None = None) -> Path:
    """Write a solution as a GIF in side view: the film of the page, ten pictures a second.

    Args:
        solution: The solution.
        path: File to write; it appears only when it is complete.
        look: How the solution is shown.

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
        _write(_Painter(shown), partial)
    return Path(path)


def _write(painter: _Painter, partial: Path) -> None:
    frames = painter.frames
    chosen = frames[np.linspace(0, len(frames) - 1, _SAMPLES).astype(int)]
    palette = _palette([painter.picture(int(place)) for place in chosen], painter.exact)

    def pictures() -> Iterator[Image.Image]:
        for place in frames:
            yield painter.picture(int(place)).quantize(palette=palette, dither=Image.Dither.NONE)

    every = pictures()
    next(every).save(
        partial,
        format="GIF",
        save_all=True,
        append_images=every,
        duration=1000 // PER_SECOND,
        loop=0,
    )


def _palette(samples: list[Image.Image], exact: list[str]) -> Image.Image:
    """Return one palette for all pictures, so that constant parts are stored once."""
    width, height = _SIZE
    sheet = Image.new("RGB", (width, height * len(samples)))
    for place, sample in enumerate(samples):
        sheet.paste(sample, (0, height * place))
    made = sheet.quantize(256 - len(exact), Image.Quantize.MEDIANCUT).getpalette() or []
    found = np.array(made, dtype=int).reshape(-1, 3)
    kept = np.array([tuple(bytes.fromhex(colour.removeprefix("#"))) for colour in exact])
    # Pillow rounds colours to steps of four, so colours close to an exact one are left out.
    apart = np.abs(found[:, None] - kept).max(axis=-1).min(axis=1) > _NEAR
    palette = Image.new("P", (1, 1))
    palette.putpalette(np.concatenate([kept, found[apart]]).ravel().tolist())
    return palette


class _Painter:
    """Draws the pictures of a film.

    Attributes:
        frames: Places of the frames of the film that become pictures, shape (pictures,).
        exact: Colours that the file keeps as they are.
    """

    def __init__(self, shown: Film) -> None:
        """Compute the parts that all pictures have in common."""
        self._shown, mechanism = shown, shown.solution.mechanism
        pace = shown.pace
        times = np.arange(0.0, pace.playback[-1], 1.0 / PER_SECOND)
        self.frames = np.searchsorted(pace.playback, times)
        drawn = solids(mechanism)
        self._seen = flat(shown, drawn)
        self._intervals = intervals(shown.solution)
        self._phases = [item.colour for item in self._intervals]
        self.exact = ["#ffffff", ARROW, *sorted(set(self._phases))]
        stop = bouncing_stop(mechanism)
        self._drawn = drawn
        self._opening = opening = [place for place, joint in enumerate(mechanism.joints)
                   if stop is not None and joint.index == stop.index]  # fmt: skip
        self._colours = {
            colour: colours(self._seen, drawn, opening, channels(colour)) for colour in self._phases
        }
        self._columns = [(label, unit, rounded(values)) for label, unit, values in columns(shown)]
        lips = close_up(shown)
        left, top, right, bottom = (_SHARP * part for part in _LIPS)
        self._lips = lips and LipsPainter(shown, drawn, lips, (right - left, bottom - top))
        self._caption = (
            "" if lips is None else f"{lips.stop} cut along its hinge; bar {lips.scale_mm:g} mm"
        )
        self._struts, _ = shown.solution.system.body.points(shown.drawn)
        corners = np.concatenate(
            [moved(self._seen, shown, int(place)) for place in self.frames[::20]]
        )
        self._low, self._high = corners.min(axis=0), corners.max(axis=0)
        left, top, right, bottom = _BOX
        self._scale = min(
            (right - left) / (self._high[0] - self._low[0]),
            (bottom - top) / (self._high[1] - self._low[1]),
        )
        fonts = Path(mpl.get_data_path()) / "fonts" / "ttf"
        self._text = ImageFont.truetype(str(fonts / "DejaVuSans.ttf"), _SHARP * _TEXT)
        self._small = ImageFont.truetype(str(fonts / "DejaVuSans.ttf"), _SHARP * _SMALL)
        self._strong = ImageFont.truetype(str(fonts / "DejaVuSans-Bold.ttf"), _SHARP * _TEXT)
        self._base = self._common()

    def picture(self, frame: int) -> Image.Image:
        """One picture of the file.

        Args:
            frame: Place of the frame in the film.
        """
        image = self._base.copy()
        draw = ImageDraw.Draw(image)
        colour = self._phases[self._shown.phase[frame]]
        corners = self._pixels(moved(self._seen, self._shown, frame))
        for item, shade in zip(self._seen.items, self._colours[colour], strict=True):
            if len(item) == 3:
                draw.polygon([corners[place] for place in item], fill=shade)
            else:
                draw.line([corners[place] for place in item], fill=_EDGE, width=_SHARP)
        for ends in self._struts[frame]:
            draw.line(self._pixels(ends), fill=LINE, width=2 * _SHARP)
        self._arrows(draw, frame)
        if self._lips:
            left, top, _, _ = _LIPS
            close = self._lips.picture(frame, self._solid_colours(colour))
            image.paste(close, (_SHARP * left, _SHARP * top))
        self._say(draw, frame, colour)
        return image.reduce(_SHARP)

    def _solid_colours(self, phase: str) -> list[str]:
        """Colours of the solids as in #RRGGBB, in a phase of a colour."""
        found = []
        for item in self._drawn:
            own = channels(phase) if item.body in self._opening else item.colour
            found.append("#" + "".join(f"{round(255.0 * part):02x}" for part in own))
        return found

    def _common(self) -> Image.Image:
        """Draw title, phases along the film, and note."""
        shown, solution = self._shown, self._shown.solution
        mechanism, pace = solution.mechanism, shown.pace
        image = Image.new("RGB", (_SHARP * _SIZE[0], _SHARP * _SIZE[1]), "white")
        draw = ImageDraw.Draw(image)
        self._put(draw, (_LEFT, 12), self._title(mechanism.title or mechanism.name), self._strong)
        self._put(draw, (_LEFT, 34), case_text(solution), self._small, _PALE)
        left, top, right, bottom = _BAR
        starts = pace.playback_at(np.array([item.start for item in self._intervals]))
        for start, colour in zip(starts, self._phases, strict=True):
            at = left + (right - left) * float(start / pace.playback[-1])
            draw.rectangle([_SHARP * part for part in (at, top, right, bottom)], fill=colour)
        for line, text in enumerate(textwrap.wrap(note(shown), _NOTE_COLUMNS)):
            self._put(draw, (_LEFT, bottom + 8 + 14 * line), text, self._small, _PALE)
        if self._caption:
            self._put(draw, (_LIPS[0], _LIPS[3] + 1), self._caption, self._small, _PALE)
        return image

    def _title(self, text: str) -> str:
        """Return a title shortened to one line."""
        room, count = _SHARP * (_BAR[2] - _LEFT), len(text)
        while self._strong.getlength(text) > room:
            count -= 1
            text = textwrap.shorten(text, count, placeholder=" ...")
        return text

    def _say(self, draw: ImageDraw.ImageDraw, frame: int, colour: str) -> None:
        """Write phase, numbers and last collision, and mark the time in the film."""
        shown, solution = self._shown, self._shown.solution
        mechanism, pace = solution.mechanism, shown.pace
        top = _BOX[1]
        draw.rectangle([_SHARP * part for part in (_LEFT, top, _LEFT + 16, top + 16)], fill=colour)
        name = self._intervals[shown.phase[frame]].name
        self._put(draw, (_LEFT + 24, top), name, self._strong)
        for row, (label, unit, values) in enumerate(self._columns, 1):
            at = top + 8 + _ROW * row
            self._put(draw, (_LEFT, at), label, self._small)
            value = f"{digits(values[frame])} {unit}".rstrip()
            self._put(draw, (_BOX[0] - 20, at), value, self._small, anchor="ra")
        done = [item for item in solution.collisions if item.t <= pace.machine[frame]]
        if done:
            at = top + 16 + _ROW * (len(self._columns) + 1)
            last = [item for item in done if item.event is done[-1].event]
            lines = textwrap.wrap(collision_text(mechanism, last), _COLUMNS)
            for line, text in enumerate(lines):
                self._put(draw, (_LEFT, at + 16 * line), text, self._small, ARROW)
        left, top, right, bottom = _BAR
        here = left + (right - left) * float(pace.playback[frame] / pace.playback[-1])
        mark = (here - 1.0, top - 4.0, here + 1.0, bottom + 4.0)
        draw.rectangle([_SHARP * part for part in mark], fill=_INK)

    def _arrows(self, draw: ImageDraw.ImageDraw, frame: int) -> None:
        """Draw arrows for the most recent impulses."""
        shown, mechanism = self._shown, self._shown.solution.mechanism
        shaft, thick, head, wide = arrow_sizes(mechanism)
        outline = np.array([(-thick, 0.0), (-thick, shaft), (-wide, shaft), (0.0, shaft + head),
                            (wide, shaft), (thick, shaft), (thick, 0.0)])  # fmt: skip
        for stop in arrow_stops(mechanism):
            share = self._share(stop, frame)
            if share > 0.0:
                place = arrow_place(mechanism, stop)
                sized = outline * arrow_scale(share)[:2]
                local = sized @ place[[0, 2], :2].T + place[[0, 2], 3]
                body = arrow_body(mechanism, stop)
                draw.polygon(self._pixels(placed(shown, frame, body, local)), fill=ARROW)

    def _share(self, stop: Stop, frame: int) -> float:
        """Size of an arrow relative to the largest one: constant at first, then decreasing."""
        pace = self._shown.pace
        hits = drawn_collisions(self._shown.solution, pace.machine[-1])
        now, largest = pace.machine[frame], max((item.impulse for item in hits), default=0.0)
        past = [item for item in hits if item.stop == stop.name and item.t <= now]
        if not past or largest <= 0.0:
            return 0.0
        left = HELD + FADE - float(pace.playback[frame] - pace.playback_at(past[-1].t))
        return min(max(left / FADE, 0.0), 1.0) * past[-1].impulse / largest

    def _pixels(self, points: FloatArray) -> list[tuple[float, float]]:
        """Places in the large picture of points (x, z), shape (N, 2) [m]."""
        left, top, right, bottom = _BOX
        middle = np.array([0.5 * (left + right), 0.5 * (top + bottom)])
        shifted = (points - 0.5 * (self._low + self._high)) * (self._scale, -self._scale)
        return [(x, y) for x, y in (_SHARP * (middle + shifted)).tolist()]

    def _put(
        self,
        draw: ImageDraw.ImageDraw,
        at: tuple[float, float],
        text: str,
        font: ImageFont.FreeTypeFont,
        colour: str = _INK,
        anchor: str = "la",
    ) -> None:
        draw.text((_SHARP * at[0], _SHARP * at[1]), text, fill=colour, font=font, anchor=anchor)
