"""Sliders with the fields beside them, and the buttons."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import viser

from ..settings import Knob
from .fields import field_text, refusal, refusal_html, typed

RESET, PIN, UNPIN, FIT = "reset", "pin this curve", "unpin", "fit axes"


class Controls:
    """What sets the numbers of the page; slider and field of a number go together.

    Args:
        gui: Where they are put.
        controls: What they set.
        changed: Called when a number has changed.
        pressed: Called with the name of a button.

    Attributes:
        sliders: The sliders, by key.
        fields: The fields beside them, by key.
        refusals: What is said of a text that cannot be used, by key.
    """

    def __init__(
        self,
        gui: viser.GuiApi,
        controls: Sequence[Knob],
        changed: Callable[[], None],
        pressed: Callable[[str], None],
    ) -> None:
        """Put them there, at their starts."""
        self._controls, self._changed = controls, changed
        self.sliders: dict[str, Any] = {}
        self.fields: dict[str, Any] = {}
        self.refusals: dict[str, viser.GuiHtmlHandle] = {}
        for knob in controls:
            key = knob.key
            self.sliders[key] = gui.add_slider(
                knob.label, min=knob.low, max=knob.high, step=knob.step, initial_value=knob.start
            )
            self.fields[key] = gui.add_text(knob.name, field_text(knob.start))
            self.refusals[key] = gui.add_html("")
            self.sliders[key].on_update(self._with(knob, self._slid))
            self.fields[key].on_update(self._with(knob, self._typed))
        self.buttons = gui.add_button_group("", (RESET, PIN, FIT))
        self.buttons.on_click(lambda event: pressed(str(event.target.value)))

    def stand(self) -> dict[str, float]:
        """Values of all numbers in their units, by key."""
        return {key: float(slider.value) for key, slider in self.sliders.items()}

    def reset(self) -> None:
        """Bring everything back to its start; what was refused goes as well."""
        for knob in self._controls:
            self.sliders[knob.key].value = knob.start
            self._write(knob, field_text(knob.start))

    def pinned(self, there: bool) -> None:
        """Let the button say what it would do.

        Args:
            there: Whether a curve is pinned.
        """
        options = (RESET, UNPIN if there else PIN, FIT)
        if self.buttons.options != options:
            self.buttons.options = options

    @staticmethod
    def _with(knob: Knob, follow: Callable[[Knob], None]) -> Callable[[object], None]:
        return lambda _: follow(knob)

    def _slid(self, knob: Knob) -> None:
        """Follow a slider with its field, unless that means the same number already."""
        value = float(self.sliders[knob.key].value)
        if typed(knob, self.fields[knob.key].value) != value:
            self._write(knob, field_text(value))
        self._changed()

    def _typed(self, knob: Knob) -> None:
        """Follow a field with its slider, or say why that cannot be."""
        text, slider = self.fields[knob.key].value, self.sliders[knob.key]
        value = typed(knob, text)
        words = refusal(knob, text, float(slider.value)) if value is None else ""
        self._say(knob, words)
        if value is not None and value != slider.value:
            slider.value = value

    def _write(self, knob: Knob, text: str) -> None:
        self._say(knob, "")
        if self.fields[knob.key].value != text:
            self.fields[knob.key].value = text

    def _say(self, knob: Knob, words: str) -> None:
        content = refusal_html(words)
        if self.refusals[knob.key].content != content:
            self.refusals[knob.key].content = content
