"""Pages of the viewer in a browser, which may run no text but their own."""

from __future__ import annotations

import io
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image
from playwright.sync_api import Browser, ConsoleMessage, Page

# Chromium says this when a picture of the page is taken while a processor draws.
BY_PICTURES = "GPU stall due to ReadPixels"
WAIT = 60_000  # ms; a processor that draws and has other work takes its time


def until(page: Page, what: str) -> None:
    """Wait for a condition; the browser's own waiting would need a page that may run any text."""
    end = time.monotonic() + 60.0
    while not page.evaluate(what):
        assert time.monotonic() < end, what
        time.sleep(0.02)


@dataclass
class Watched:
    """What a page complains of and asks for."""

    complaints: list[str] = field(default_factory=list)
    requests: list[str] = field(default_factory=list)


def watch(page: Page) -> Watched:
    """Note all that a page says and asks for from now on, and give it time to answer."""
    found = Watched()

    def say(message: ConsoleMessage) -> None:
        if message.type in ("error", "warning") and BY_PICTURES not in message.text:
            found.complaints.append(message.text)

    page.set_default_timeout(WAIT)
    page.on("console", say)
    page.on("pageerror", lambda error: found.complaints.append(str(error)))
    page.on("request", lambda request: found.requests.append(request.url))
    return found


@contextmanager
def playing(chromium: Browser, file: Path) -> Iterator[Page]:
    """A static page that plays by itself, stopped then: a processor that draws does nothing else.

    Whatever it complained of or asked for fails the test.
    """
    page = chromium.new_page(viewport={"width": 1100, "height": 900})
    found = watch(page)
    page.goto(file.resolve().as_uri())
    page.wait_for_selector("#pane canvas")
    until(page, "animator.time > 0.2")
    page.evaluate("animator.pause()")
    yield page
    page.close()
    assert found.complaints == []
    assert found.requests == [file.resolve().as_uri()]


def _drawn(page: Page, frames: int) -> None:
    """Wait until so many frames have been drawn."""
    for _ in range(frames):
        page.evaluate("() => new Promise(done => requestAnimationFrame(done))")


def seek(page: Page, time: float) -> None:
    """Stop, go to a time of the film, and wait until it has been drawn."""
    page.evaluate(
        "time => { animator.pause(); animator.seek(time); animator.display_progress(time); }", time
    )
    _drawn(page, 3)


def cells(page: Page, rows: str) -> list[list[str]]:
    """Texts of the rows of a table."""
    read = "row => [...row.cells].map(cell => cell.textContent)"
    found: list[list[str]] = page.evaluate(f"[...document.querySelectorAll('{rows}')].map({read})")
    return found


def picture(page: Page, of: str) -> np.ndarray:
    """What a part of the page shows, without names, shape (height, width, 3), 0 to 255."""
    page.locator("#names").uncheck()
    _drawn(page, 2)
    image = Image.open(io.BytesIO(page.locator(of).screenshot()))
    return np.asarray(image.convert("RGB"), dtype=float)


def apart(page: Page, *parts: str) -> list[Any]:
    """Boxes of parts of a page: beside or below one another, within the width of the window."""
    boxes: list[Any] = [page.locator(item).bounding_box() for item in parts]
    for place, one in enumerate(boxes):
        assert one["x"] >= 0.0
        assert one["x"] + one["width"] <= page.evaluate("innerWidth") + 0.5
        for other in boxes[:place]:
            common = [min(one[at] + one[size], other[at] + other[size]) - max(one[at], other[at])
                      for at, size in (("x", "width"), ("y", "height"))]  # fmt: skip
            assert min(common) < 2.0, (one, other)
    return boxes
