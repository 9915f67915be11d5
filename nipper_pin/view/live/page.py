"""The page: sliders, and the numbers, plots and picture that follow them."""

from __future__ import annotations

import threading
import time
from collections.abc import Sequence
from html import escape
from typing import Any

import numpy as np
import viser
from viser import uplot

from ...errors import InputError
from ...hybrid.result.quantities import force_unit
from ...mechanism import Mechanism
from ..reading import gap_noun, units_of
from ..scene.film import LARGEST_EXAGGERATION, exaggerated
from .answer import Answer, answer, as_html, boxed
from .guard import Filter
from .moment import closed_at, impulses_at, moment_text
from .settings import Knob
from .stage import Stage
from .whole_turn import Rows, WholeTurns

_FRAME = 1.0 / 30.0  # seconds
_AFTER = 0.004  # seconds from new numbers to the picture that belongs to them
_HELD = 0.8  # seconds that the film stands after a slider moved
_TOLD = 0.12  # seconds between two texts of the moment; a new one has the panel drawn again
_PAUSE = 0.7  # seconds of playback at rest before the film starts again
_SLOW = (100, 5000, 1000)  # ends and start of the slow motion
_WIDTH = 400  # pixels, of the panel
_HEIGHT = 170  # pixels, of a plot
_AXIS = (30, 44)  # pixels of the axes below and beside a plot
_LABEL = 18  # pixels of their labels
_PADDING = (10, 20, 0, 0)
_LINE = "#0072B2"
_DOTS = "#D55E00"
_NOTE = (
    "Every number here is computed from these estimates of the class of machine, also where it "
    "agrees with a publication; none is the maker's. The shapes are illustrations."
)


class Page:
    """State of the live page, the same in all browsers; one thread computes and sends.

    Args:
        server: The server.
        mechanism: The mechanism as loaded.
        controls: What the sliders set.

    Attributes:
        turns: Whole turns of the settings, once their tables are made.

    Raises:
        InputError: The mechanism cannot be drawn.
    """

    def __init__(
        self, server: viser.ViserServer, mechanism: Mechanism, controls: Sequence[Knob]
    ) -> None:
        """Build the page."""
        self._server, self._mechanism, self._controls = server, mechanism, controls
        self._wake = threading.Event()
        self._clock = 0.0
        self._drawn: tuple[Answer | None, float, float] = (None, 0.0, 0.0)
        self._text, self._told = "", 0.0
        self._stage = Stage(server, mechanism)
        gui = server.gui
        gui.configure_theme(show_logo=False, show_share_button=False)
        gui.main_panel.dock_right()
        gui.main_panel.set_width(_WIDTH)
        gui.set_panel_label(f"nipper-pin live: {mechanism.name}")
        gui.add_html(boxed(f'<b id="title">{escape(mechanism.title or mechanism.name)}</b>'))
        self._sliders = {
            item.key: gui.add_slider(
                item.label, min=item.low, max=item.high, step=item.step, initial_value=item.start
            )
            for item in controls
        }
        self._numbers, self._now = gui.add_html(""), gui.add_html("")
        self._gap, self._impulse = self._plots()
        low, high, start = _SLOW
        self._play = gui.add_checkbox("play", initial_value=True)
        self._slow = gui.add_slider("slow motion 1 :", low, high, low, start)
        self._larger = gui.add_slider(
            "gap drawn larger, times", 1.0, LARGEST_EXAGGERATION, 1.0, 10.0
        )
        if "estimate" in mechanism.title:
            gui.add_html(boxed(f'<span id="note">{escape(_NOTE)}</span>'))
        for slider in self._sliders.values():
            slider.on_update(self._changed)
        numbers: list[Any] = [*self._sliders.values(), self._slow, self._larger]
        ranges = {item._impl.uuid: (float(item.min), float(item.max)) for item in numbers}
        Filter(server, ranges, frozenset({self._play._impl.uuid}))
        self._shown: dict[str, float] = {}
        self._came = threading.Event()
        self.turns = WholeTurns(mechanism, controls, self._turned)
        self._answer = self._follow()

    def run(self) -> None:
        """Follow the sliders and move the picture, for ever."""
        last = due = time.perf_counter()
        while True:
            moved = self._wake.wait(max(0.0, due - time.perf_counter()))
            if moved:
                # Cleared first: what changes from here on is another change.
                self._wake.clear()
            if self._came.is_set():
                self._came.clear()
                self._write(self._answer, self.turns.rows(self._shown))
                moved = moved and self._stand() != self._shown
                if not moved:
                    continue
            if moved:
                with self._server.atomic():
                    self._answer = self._follow()
                self._server.flush()
                # The browser writes numbers and plots at once if they come alone, and only with
                # its next picture if they come with anything of the scene.
                time.sleep(_AFTER)
            now = time.perf_counter()
            if self._server.get_clients():
                playing = self._play.value and not moved
                with self._server.atomic():
                    self._draw(max(0.0, now - last) if playing else 0.0)
                    self._tell(now, at_once=moved)
                self._server.flush()
            # A browser draws for a quarter of a second after each picture that it is sent, and
            # pictures between two moves of a slider would only delay what the next one changes.
            due = now + (_HELD if moved else _FRAME)
            # The film goes on where it stood.
            last = due if moved else now

    def _changed(self, _: object) -> None:
        """Note that a slider moved; of many moves only the last matters."""
        self._wake.set()

    def _turned(self) -> None:
        """Note that whole turns can be followed from now on."""
        self._came.set()
        self._wake.set()

    def _follow(self) -> Answer:
        """Answer the setting of the sliders, and show numbers and plots, or why there are none."""
        self._shown = self._stand()
        found = answer(self._mechanism, self._controls, self._shown)
        self._write(found, self.turns.rows(self._shown))
        for plot, x, y in (
            (self._gap, found.time, found.gap),
            (self._impulse, found.hit_time, found.impulse),
        ):
            plot.visible = not found.message
            if not found.message:
                plot.data = (x, y)
        return found

    def _stand(self) -> dict[str, float]:
        """Where the sliders stand."""
        return {key: float(slider.value) for key, slider in self._sliders.items()}

    def _write(self, found: Answer, turn: Rows) -> None:
        """Write the numbers, unless they are there."""
        text = as_html(found, turn)
        if self._numbers.content != text:
            self._numbers.content = text

    def _draw(self, passed: float) -> None:
        """Draw the next frame, so many seconds of playback after the last."""
        solution, larger = self._answer.solution, self._larger.value
        end = 0.0 if solution is None else solution.segments[-1].t_end
        self._clock += passed / self._slow.value
        # At the start of the film all settings look alike, so a film at its end stays there.
        if passed > 0.0 and self._clock > end + _PAUSE / self._slow.value:
            self._clock = 0.0
        t = min(self._clock, end)
        # What stands still is not sent again: every message makes the browsers draw.
        if self._drawn == (self._answer, t, larger):
            return
        self._drawn = (self._answer, t, larger)
        if solution is None:
            self._stage.rest()
            self._stage.impulses({})
            self._text = "there is no motion to show: the touch configuration"
            return
        motion = solution.trajectory.evaluate(t)
        drawn, remark = motion.q, ""
        try:
            drawn = exaggerated(solution, motion.t, motion.q, larger)
        except InputError as error:
            remark = f" {error.message}"
        self._stage.pose(drawn[0], float(motion.cylinder_angle[0]))
        self._stage.phase(closed_at(solution, t))
        self._stage.impulses(impulses_at(solution, t, self._slow.value))
        self._text = f"{moment_text(solution, t, motion.q[0])}{remark}"

    def _tell(self, now: float, *, at_once: bool) -> None:
        """Say what the picture shows, if it is time for that or if it has to be said at once."""
        if at_once or now >= self._told + _TOLD:
            self._told = now
            self._now.content = boxed(f'Picture: <span id="now">{escape(self._text)}</span>')

    def _plots(self) -> tuple[viser.GuiUplotHandle, viser.GuiUplotHandle]:
        """Gap of the transition stop, and impulses of its collisions, against time."""
        mechanism, gui = self._mechanism, self._server.gui
        stop = mechanism.stop(mechanism.transition_stop)
        units = units_of(mechanism, stop.index)
        x = "time from the first collision [ms]"
        none = (np.zeros(1), np.ones(1))
        dots = uplot.Series_Points(show=True, size=7.0, fill=_DOTS, stroke=_DOTS)
        time_axis = uplot.Axis(label=x, size=_AXIS[0], labelSize=_LABEL)
        return (
            gui.add_uplot(
                none,
                (uplot.Series(label=x), uplot.Series(stroke=_LINE, width=1.5)),
                scales={"x": uplot.Scale(time=False)},
                axes=(
                    time_axis,
                    _axis(f"{stop.name} {gap_noun(mechanism, stop)} [{units.coordinate}]"),
                ),
                legend=uplot.Legend(show=False),
                height=_HEIGHT,
                padding=_PADDING,
            ),
            gui.add_uplot(
                none,
                (uplot.Series(label=x), uplot.Series(stroke="transparent", points=dots)),
                scales={"x": uplot.Scale(time=False), "y": uplot.Scale(distr=3)},
                axes=(time_axis, _axis(f"impulse [{force_unit(mechanism, stop)} s]")),
                legend=uplot.Legend(show=False),
                height=_HEIGHT,
                padding=_PADDING,
            ),
        )


def _axis(label: str) -> uplot.Axis:
    """The vertical axis of a plot, without the crowd of lines that a logarithmic one draws."""
    none = uplot.Axis_Ticks(show=False)
    return uplot.Axis(
        label=label, size=_AXIS[1], labelSize=_LABEL, grid=uplot.Axis_Grid(show=False), ticks=none
    )
