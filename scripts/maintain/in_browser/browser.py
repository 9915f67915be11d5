"""A browser without a window that draws in three dimensions with the processor."""

from __future__ import annotations

import shutil
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager

from playwright.sync_api import Browser, sync_playwright

COMMAND = [sys.executable, "-c", "import sys; from nipper_pin.cli import main; sys.exit(main())"]
NAMES = ("chromium", "chromium-browser", "google-chrome")
# Software for WebGL, and for nothing else: texts and plots are then drawn as in any browser on a
# machine without a graphics card. Root has no sandbox.
FLAGS = ["--no-sandbox", "--enable-unsafe-swiftshader"]


@contextmanager
def chromium() -> Iterator[Browser]:
    """The browser, until the block ends; the script ends if there is none on this machine."""
    program = next((found for name in NAMES if (found := shutil.which(name))), None)
    if program is None:
        sys.exit(f"no browser on this machine (looked for {', '.join(NAMES)})")
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=program, args=FLAGS)
        yield browser
        browser.close()


@contextmanager
def live(*arguments: str) -> Iterator[str]:
    """The address of a live page, which is served until the block ends.

    Args:
        *arguments: Arguments of ``nipper-pin live``.
    """
    command = [*COMMAND, "live", *arguments, "--port", "0", "--no-browser"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as server:
        try:
            line = server.stdout.readline() if server.stdout is not None else ""
            if not line:
                sys.exit("nipper-pin live did not start")
            yield line.split()[4]
        finally:
            server.send_signal(signal.SIGINT)
