"""A real browser, and pages opened in it with everything that they say and ask for."""

from __future__ import annotations

import shutil
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass, field
from pathlib import Path

import pytest
from playwright.sync_api import Browser, ConsoleMessage, Page, sync_playwright

NAMES = ("chromium", "chromium-browser", "google-chrome")
# Chromium says this when a picture of the page is taken while a processor draws.
BY_PICTURES = "GPU stall due to ReadPixels"
WAIT = 60_000  # ms; a processor that draws and has other work takes its time


@dataclass
class Opened:
    """A page, and what happened while it was there."""

    page: Page
    complaints: list[str] = field(default_factory=list)
    requests: list[str] = field(default_factory=list)


@pytest.fixture(scope="session")
def chromium() -> Iterator[Browser]:
    program = next((found for name in NAMES if (found := shutil.which(name))), None)
    if program is None:
        pytest.skip(f"no browser on this machine (looked for {', '.join(NAMES)})")
    with sync_playwright() as playwright:
        # WebGL in software, for pages that draw in three dimensions; root has no sandbox.
        browser = playwright.chromium.launch(
            executable_path=program,
            args=[
                "--no-sandbox",
                "--enable-unsafe-swiftshader",
            ],
        )
        yield browser
        browser.close()


@pytest.fixture(scope="session")
def watch() -> Callable[[Page], Opened]:
    """Notes all that a page says and asks for from now on, and gives it time to answer."""

    def watched(page: Page) -> Opened:
        found = Opened(page)

        def say(message: ConsoleMessage) -> None:
            if message.type in ("error", "warning") and BY_PICTURES not in message.text:
                found.complaints.append(message.text)

        page.set_default_timeout(WAIT)
        page.on("console", say)
        page.on("pageerror", lambda error: found.complaints.append(str(error)))
        page.on("request", lambda request: found.requests.append(request.url))
        return found

    return watched


@pytest.fixture(scope="session")
def open_page(
    chromium: Browser, watch: Callable[[Page], Opened]
) -> Callable[[Path], AbstractContextManager[Opened]]:
    @contextmanager
    def opened(path: Path) -> Iterator[Opened]:
        found = watch(chromium.new_page(viewport={"width": 1100, "height": 900}))
        found.page.goto(path.resolve().as_uri())
        yield found
        found.page.close()

    return opened


@pytest.fixture(scope="session")
def serving() -> Callable[..., AbstractContextManager[str]]:
    """A command that serves a page, and its address; an interrupt ends it as it should."""

    @contextmanager
    def served(*words: str) -> Iterator[str]:
        program = "import sys; from nipper_pin.cli import main; sys.exit(main())"
        command = [sys.executable, "-c", program, *words, "--port", "0", "--no-browser"]
        with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as server:
            assert server.stdout is not None
            try:
                yield server.stdout.readline().split()[4]
            finally:
                server.send_signal(signal.SIGINT)
            assert server.wait(timeout=60) == 0

    return served
