"""A real browser, and commands that serve pages to it."""

from __future__ import annotations

import shutil
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager

import pytest
from playwright.sync_api import Browser, sync_playwright

NAMES = ("chromium", "chromium-browser", "google-chrome")


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
