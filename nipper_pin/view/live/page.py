"""The page: sliders, and the numbers, plots and picture that follow them."""

from __future__ import annotations

import threading
import time
from collections.abc import Sequence
from html import escape
from typing import Any

import numpy as np
import viser

from ...errors import InputError
from ...mechanism import Mechanism
from ...units import MS_PER_S
from ..scene.film import LARGEST_EXAGGERATION, exaggerated
from .answer import Answer, answer
from .curves.plots import Plots
from .guard import Filter
from .lips import Lips
from .moment import closed_at, impulses_at, moment_text
from .panel.controls import FIT, PIN, RESET, UNPIN, Controls
from .panel.layout import NARROW, SECOND, STYLE, Widths, cursor
from .panel.memory import ONE_CHANGE, Memory
from .panel.text import as_html, boxed
from .settings import Knob
from .stage import Stage
from .whole_turn import WholeTurns

_FRAME = 1.0 / 30.0  # seconds
_AFTER = 0.004  # seconds from new numbers to the picture that belongs to them
_HELD = ONE_CHANGE  # seconds that the film stands after a slider moved
_TOLD = 0.12  # seconds between two texts of the moment; a new one has the panel drawn again
_PAUSE = 0.7  # seconds of playback at its end before the film starts again
_SLOW = (100, 5000, 1000)  # ends and start of the slow motion
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
        self._text, self._share, self._told = "", 0.0, 0.0
        # What the close-up shows: configuration, largest gap and exaggeration.
        self._close = np.zeros(mechanism.model.nv), 0.0, 1.0
        self._stage, self._lips = Stage(server, mechanism), Lips(mechanism)
        self._memory, self._pressed = Memory(), list[str]()
        gui = server.gui
        gui.configure_theme(show_logo=False, show_share_button=False)
        gui.main_panel.dock_right()
        gui.main_panel.set_width(NARROW)
        gui.set_panel_label(f"nipper-pin live: {mechanism.name}")
        title = f'<b id="title">{escape(mechanism.title or mechanism.name)}</b>'
        gui.add_html(f"{STYLE}{boxed(title)}")
        self._set = Controls(gui, controls, self._changed, self._press)
        self._numbers = gui.add_html("")
        if self._lips.html:
            gui.add_html(boxed(self._lips.html))
        gui.add_html(SECOND)
        self._now = gui.add_html("")
        self._plots = Plots(gui, mechanism)
        low, high, start = _SLOW
        self._play = gui.add_checkbox("play", initial_value=True)
        self._slow = gui.add_slider("slow motion 1 :", low, high, low, start)
        self._larger = gui.add_slider(
            "gap drawn larger, times", 1.0, LARGEST_EXAGGERATION, 1.0, 10.0
        )
        if "estimate" in mechanism.title:
            gui.add_html(boxed(f'<span id="note">{escape(_NOTE)}</span>'))
        self._guard()
        Widths(server)
        self._shown: dict[str, float] = {}
        self._came = threading.Event()
        self.turns = WholeTurns(mechanism, controls, self._turned)
        self._answer = self._follow()

    def _guard(self) -> None:
        """Take from browsers what these controls send, and nothing else."""
        numbers: list[Any] = [*self._set.sliders.values(), self._slow, self._larger]
        Filter(
            self._server,
            {item._impl.uuid: (float(item.min), float(item.max)) for item in numbers},
            frozenset({self._play._impl.uuid}),
            frozenset(item._impl.uuid for item in self._set.fields.values()),
            {self._set.buttons._impl.uuid: frozenset({RESET, PIN, UNPIN, FIT})},
        )

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
                self._memory.turned(self.turns.rows(self._shown))
                self._write()
                if not self._pressed and self._set.stand() == self._shown:
                    continue
            if moved:
                self._act()
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

    def _changed(self) -> None:
        """Note that a slider moved; of many moves only the last matters."""
        self._wake.set()

    def _press(self, button: str) -> None:
        """Note that a button was pressed."""
        self._pressed.append(button)
        self._wake.set()

    def _act(self) -> None:
        """Do what the pressed buttons ask for."""
        while self._pressed:
            button = self._pressed.pop(0)
            if button == RESET:
                self._memory.end_change()
                self._set.reset()
            if button in (RESET, FIT):
                self._plots.forget()
            if button in (PIN, UNPIN):
                self._memory.pin()
                self._set.pinned(self._memory.pinned is not None)

    def _turned(self) -> None:
        """Note that whole turns can be followed from now on."""
        self._came.set()
        self._wake.set()

    def _follow(self) -> Answer:
        """Answer the setting of the sliders, and show numbers and curves, or why there are none."""
        stand = self._set.stand()
        if stand != self._shown:
            self._shown = stand
            found = answer(self._mechanism, self._controls, stand)
            self._memory.take(time.perf_counter(), found, self.turns.rows(stand))
        self._write()
        self._plots.show(self._memory)
        present = self._memory.present
        return present.answer if present is not None else self._answer

    def _write(self) -> None:
        """Write the numbers, unless they are there."""
        kept = self._memory.present
        if kept is None:
            return
        pinned = self._memory.pinned is not None
        text = as_html(kept.answer, kept.turn, self._memory.other, pinned=pinned)
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
        self._share = MS_PER_S * t / self._plots.until
        # What stands still is not sent again: every message makes the browsers draw.
        if self._drawn == (self._answer, t, larger):
            return
        self._drawn = (self._answer, t, larger)
        if solution is None:
            self._stage.rest()
            self._close = np.zeros(self._mechanism.model.nv), 0.0, 1.0
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
        self._close = drawn[0], self._answer.largest, larger
        self._stage.phase(closed_at(solution, t))
        self._stage.impulses(impulses_at(solution, t, self._slow.value))
        self._text = f"{moment_text(solution, t, motion.q[0])}{remark}"

    def _tell(self, now: float, *, at_once: bool) -> None:
        """Say what the picture shows, if it is time for that or if it has to be said at once."""
        if at_once or now >= self._told + _TOLD:
            self._told = now
            words = boxed(f'Picture: <span id="now">{escape(self._text)}</span>')
            content = f"{cursor(self._share)}{self._lips.style(*self._close)}{words}"
            if self._now.content != content:
                self._now.content = content
