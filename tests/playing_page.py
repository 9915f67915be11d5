"""Waiting for a page of the viewer, which may run no text but its own."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from playwright.sync_api import Page


def until(page: Page, what: str) -> None:
    """Wait for a condition; the browser's own waiting would need a page that may run any text."""
    end = time.monotonic() + 60.0
    while not page.evaluate(what):
        assert time.monotonic() < end, what
        time.sleep(0.02)


@contextmanager
def playing(open_page: Any, file: Path) -> Iterator[Page]:
    """A static page that plays; whatever it complained of or asked for fails the test."""
    with open_page(file) as opened:
        opened.page.wait_for_selector("#pane canvas")
        until(opened.page, "animator.time > 0.2")
        yield opened.page
        assert opened.complaints == []
        assert opened.requests == [file.resolve().as_uri()]
