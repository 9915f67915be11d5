"""Where the time between a key on a slider of the live page and its answer goes.

Run: python scripts/measure_live_delay.py [WIDTH HEIGHT [QUERY]]
     QUERY is put behind the address, for example fixedDpr=0.5

Needs the `dev` extra and Chromium; it draws with the processor. The parts of a delay:
server   key seen by the page -> its own message about the new numbers back in the page
page     that message -> the new numbers in the page
picture  the new numbers -> the next picture of the mechanism
"""

from __future__ import annotations

import shutil
import signal
import statistics
import subprocess
import sys
import time
from collections.abc import Callable, Sequence

import nipper_pin as nip
from nipper_pin.view.live.answer import answer, as_html
from nipper_pin.view.live.settings import SPEED, knobs
from playwright.sync_api import Page, sync_playwright

COMMAND = [sys.executable, "-c", "import sys; from nipper_pin.cli import main; sys.exit(main())"]
BROWSERS = ("chromium", "chromium-browser", "google-chrome")
# Software for WebGL; root has no sandbox.
FLAGS = ["--no-sandbox", "--enable-unsafe-swiftshader", "--use-gl=angle", "--use-angle=swiftshader"]
KEYS, PAUSE = 60, 230  # keys, and milliseconds between them: not a multiple of a frame
# The page's socket lives in a worker; what passes between the two is timed from here.
WATCH = """() => {
    const marks = window.marks = [];
    window.pictures = 0;
    const Plain = window.Worker;
    window.Worker = class extends Plain {
        constructor(...given) {
            super(...given);
            this.addEventListener('message', event => {
                const parts = (event.data && event.data.messages) || [];
                const mark = marks[marks.length - 1];
                if (mark && mark.back === undefined && parts.some(part =>
                        part.type === 'GuiUpdateMessage' && part.updates.content
                        && part.updates.content.includes('id="setting"')))
                    mark.back = performance.now();
            });
        }
    };
    addEventListener('keydown', () => {
        const place = document.querySelector('#setting'), old = place.textContent;
        const mark = {began: performance.now()};
        marks.push(mark);
        const watch = new MutationObserver(() => {
            const now = document.querySelector('#setting');
            if (now && now.textContent !== old) {
                mark.told = performance.now();
                watch.disconnect();
                requestAnimationFrame(() => requestAnimationFrame(() => {
                    mark.seen = performance.now();
                }));
            }
        });
        watch.observe(document.body, {subtree: true, childList: true, characterData: true});
    }, true);
}"""
COUNT = """() => new Promise(done => {
    let pictures = 0;
    const began = performance.now();
    const next = () => {
        pictures += 1;
        const passed = performance.now() - began;
        if (passed > 3000) done(passed / pictures); else requestAnimationFrame(next);
    };
    requestAnimationFrame(next);
})"""


def told(name: str, values: Sequence[float]) -> str:
    """One line of the table [ms]."""
    ordered = sorted(values)
    late = ordered[min(len(ordered) - 1, round(0.95 * len(ordered)))]
    return f"{name:34}{ordered[0]:8.1f}{statistics.median(ordered):8.1f}{late:8.1f}"


def timed(act: Callable[[], object], times: int = 60) -> list[float]:
    """Durations of a call [ms]."""
    found = []
    for _ in range(times):
        began = time.perf_counter()
        act()
        found.append(1e3 * (time.perf_counter() - began))
    return found


def computed() -> None:
    """What the server computes, without any browser."""
    mechanism = nip.load("e62")
    controls = knobs(mechanism, 650.0)
    shown = {item.key: item.start for item in controls} | {SPEED: 650.0}
    found = answer(mechanism, controls, shown)
    print(told("run, numbers and lines of the plots",
               timed(lambda: answer(mechanism, controls, shown))))  # fmt: skip
    print(told("text of the numbers", timed(lambda: as_html(found))))


def pressed(page: Page) -> list[dict[str, float]]:
    """Times of all keys, each pressed when the answer to the last one was there."""
    page.locator("[role=slider]").first.focus()
    for count in range(KEYS):
        page.keyboard.press("ArrowRight" if count % 20 < 10 else "ArrowLeft")
        page.wait_for_function(
            "count => marks.filter(item => item.seen).length === count", arg=count + 1
        )
        page.wait_for_timeout(PAUSE)
    found: list[dict[str, float]] = page.evaluate("marks")
    return found


def browsed(address: str, width: int, height: int) -> None:
    """What the browser waits for and draws."""
    program = next((found for name in BROWSERS if (found := shutil.which(name))), None)
    if program is None:
        sys.exit(f"no browser on this machine (looked for {', '.join(BROWSERS)})")
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=program, args=FLAGS)
        page = browser.new_page(viewport={"width": width, "height": height})
        page.set_default_timeout(60_000)
        page.add_init_script(f"({WATCH})()")
        page.goto(address)
        page.wait_for_selector("#setting")
        page.wait_for_timeout(4000)
        print(f"between two pictures, playing: {page.evaluate(COUNT):.0f} ms (mean of 3 s)")
        marks = pressed(page)
        browser.close()
    for name, start, end in (("server", "began", "back"), ("page", "back", "told"),
                             ("key to numbers", "began", "told"),
                             ("picture", "told", "seen"), ("key to picture", "began", "seen"),
                             ):  # fmt: skip
        print(told(name, [mark[end] - mark[start] for mark in marks]))


def main(width: str = "900", height: str = "700", query: str = "") -> None:
    """Print the table."""
    print(f"{'milliseconds':34}{'least':>8}{'median':>8}{'95 %':>8}")
    computed()
    command = [*COMMAND, "live", "--speed", "650", "--port", "0", "--no-browser"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as server:
        try:
            line = server.stdout.readline() if server.stdout is not None else ""
            browsed(f"{line.split()[4]}?{query}", int(width), int(height))
        finally:
            server.send_signal(signal.SIGINT)


if __name__ == "__main__":
    main(*sys.argv[1:4])
