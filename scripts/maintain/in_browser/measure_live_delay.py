"""Parts of the delay between a move of a slider of the live page and its result.

Run: python scripts/maintain/in_browser/measure_live_delay.py [WIDTH HEIGHT [QUERY]]
     QUERY is put behind the address, for example fixedDpr=0.5

Needs the `dev` extra and Chromium, which draws with the processor here. The mouse drags, because
viser's arrow keys turn the picture as well. Of each move, all seen by the page itself while the
film plays:
sending   move -> message to the server
server    that message -> the one that holds the new numbers: socket, run, plots, socket
telling   that message -> the new numbers in the page
numbers   move -> the new numbers in the page
moving    the message with the numbers -> the one that holds the new motion
drawing   that message -> its picture is complete: a fence put behind the drawing has been passed
picture   move -> that
All of it is measured once more with nothing in the scene: that is the renderer's part.
"""

from __future__ import annotations

import statistics
import sys
import time
from collections.abc import Callable, Sequence

from browser import chromium, live
from playwright.sync_api import Browser, Page

import nipper_pin as nip
from nipper_pin.view.live.answer import answer
from nipper_pin.view.live.panel.text import as_html
from nipper_pin.view.live.settings import SPEED, knobs

STEP = 10  # r/min, of the slider
LOW, HIGH = 180, 900  # r/min, its ends
# Number of moves, and milliseconds between them. After a move the film pauses for a moment; single
# moves are far enough apart for it to play again.
ALONE, DRAGGED = (25, 1200), (40, 60)
# The page's socket lives in a worker; what passes between the two is timed from here.
WATCH = """() => {
    const marks = window.marks = [];
    const speed = text => +/speed ([0-9.]+)/.exec(text)[1];
    const reached = (mark, value) => (value - mark.wanted) * mark.sense >= 0;
    const pictures = () => window.__viserTestpoints.rendererInfo.render.frame;
    const Plain = window.Worker;
    window.Worker = class extends Plain {
        constructor(...given) {
            super(...given);
            this.addEventListener('message', event => {
                const parts = (event.data && event.data.messages) || [], now = performance.now();
                for (const part of parts)
                    if (part.type === 'GuiUpdateMessage'
                            && String(part.updates.content).includes('id="setting"'))
                        for (const mark of marks)
                            if (!mark.back && reached(mark, speed(part.updates.content)))
                                mark.back = now;
                if (!parts.some(part => part.type === 'SetPositionMessage')) return;
                for (const mark of marks)
                    if (mark.back && !mark.moved) {
                        mark.moved = now;
                        mark.before = pictures();
                        requestAnimationFrame(() => look(mark));
                    }
            });
        }
        postMessage(data, ...rest) {
            super.postMessage(data, ...rest);
            if (data.type === 'send' && data.message.type === 'GuiUpdateMessage')
                for (const mark of marks)
                    if (!mark.sent && reached(mark, data.message.updates.value))
                        mark.sent = performance.now();
        }
    };
    const finish = (mark, gl, fence) => {
        if (gl.getSyncParameter(fence, gl.SYNC_STATUS) === gl.SIGNALED)
            mark.seen = performance.now();
        else
            setTimeout(finish, 2, mark, gl, fence);
    };
    const look = mark => {
        // A task of its own comes after all that this frame still draws.
        const { port1, port2 } = new MessageChannel();
        port1.onmessage = () => {
            if (pictures() === mark.before) {
                requestAnimationFrame(() => look(mark));
                return;
            }
            const gl = document.querySelector('canvas[data-engine]').getContext('webgl2');
            const fence = gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0);
            gl.flush();
            finish(mark, gl, fence);
        };
        port2.postMessage(0);
    };
    addEventListener('pointermove', () => {
        if (window.next) marks.push({began: performance.now(), ...window.next});
        window.next = null;
    }, true);
    new MutationObserver(() => {
        const place = document.querySelector('#setting');
        if (!place) return;
        for (const mark of marks)
            if (!mark.told && reached(mark, speed(place.textContent)))
                mark.told = performance.now();
    }).observe(document, {subtree: true, childList: true, characterData: true});
}"""
PARTS = (
    ("  sending", "began", "sent"),
    ("  server", "sent", "back"),
    ("  telling", "back", "told"),
    ("  move to numbers", "began", "told"),
    ("  moving", "back", "moved"),
    ("  drawing", "moved", "seen"),
    ("  move to picture", "began", "seen"),
)
PLAYED = 5000  # ms, over which pictures are counted
COUNT = "window.__viserTestpoints.rendererInfo.render.frame"
SIZE = """() => {
    const canvas = document.querySelector('canvas[data-engine]');
    const { calls, triangles } = window.__viserTestpoints.rendererInfo.render;
    return `${canvas.width} x ${canvas.height}, ${triangles} triangles in ${calls} calls`;
}"""
EMPTY = "window.__viserMutable.scene.visible = false"


def told(name: str, values: Sequence[float]) -> str:
    """One line of the table [ms]."""
    ordered = sorted(values)
    late = ordered[min(len(ordered) - 1, round(0.95 * len(ordered)))]
    return f"{name:34}{ordered[0]:8.1f}{statistics.median(ordered):8.1f}{late:8.1f}"


def timed(act: Callable[[], object], times: int = 60) -> list[float]:
    """Processor time of calls [ms], which other programs disturb less than the time of day."""
    found = []
    for _ in range(times):
        began = time.thread_time()
        act()
        found.append(1e3 * (time.thread_time() - began))
    return found


def computed() -> None:
    """What the server computes, without any browser."""
    mechanism = nip.load("e62")
    controls = knobs(mechanism, 650.0)
    shown = {item.key: item.start for item in controls} | {SPEED: 650.0}
    found = answer(mechanism, controls, shown)
    print(told("run, numbers, plots: processor",
               timed(lambda: answer(mechanism, controls, shown))))  # fmt: skip
    print(told("text of the numbers: processor", timed(lambda: as_html(found))))


def played(browser: Browser, page: Page) -> str:
    """How often a picture is drawn, and how much of all processors one takes, while it plays."""
    session = browser.new_browser_cdp_session()

    def spent() -> float:
        processes = session.send("SystemInfo.getProcessInfo")["processInfo"]
        return 1e3 * sum(float(item["cpuTime"]) for item in processes)

    first, before = page.evaluate(COUNT), spent()
    page.wait_for_timeout(PLAYED)
    count, cost = page.evaluate(COUNT) - first, spent() - before
    return f"a picture every {PLAYED / count:.0f} ms, {cost / count:.0f} ms of processor time each"


def dragged(page: Page, moves: int, pause: int, sense: int) -> list[dict[str, float]]:
    """Times of moves of the slider's speed that follow one another after a pause [ms]."""
    page.evaluate("marks.length = 0")
    knob = page.locator("[role=slider]").first
    track = page.locator(".mantine-Slider-track").first.bounding_box()
    box = knob.bounding_box()
    if track is None or box is None:
        sys.exit("the page shows no slider")
    at, height = box["x"] + 0.5 * box["width"], box["y"] + 0.5 * box["height"]
    value = int(knob.get_attribute("aria-valuenow") or 0)
    page.mouse.move(at, height)
    page.mouse.down()
    page.wait_for_timeout(1200)
    for _ in range(moves):
        value, at = value + sense * STEP, at + sense * STEP * track["width"] / (HIGH - LOW)
        page.evaluate("next => { window.next = next; }", {"wanted": value, "sense": sense})
        # The mouse moves by whole pixels; half a pixel is less than half a step.
        page.mouse.move(round(at), height)
        page.wait_for_timeout(pause)
    page.wait_for_function("marks.every(item => item.seen)")
    page.mouse.up()
    found: list[dict[str, float]] = page.evaluate("marks")
    return found


def told_of(browser: Browser, page: Page) -> None:
    """Print what is measured of a page while its film plays."""
    print(f"canvas {page.evaluate(SIZE)}; {played(browser, page)}")
    for title, how in ((f"a move every {ALONE[1]} ms", (*ALONE, 1)),
                       (f"a move every {DRAGGED[1]} ms", (*DRAGGED, -1))):  # fmt: skip
        marks = dragged(page, *how)
        print(title)
        for name, start, end in PARTS:
            print(told(name, [mark[end] - mark[start] for mark in marks]))


def browsed(address: str, width: int, height: int) -> None:
    """What the browser waits for and draws."""
    with chromium() as browser:
        page = browser.new_page(viewport={"width": width, "height": height})
        page.set_default_timeout(60_000)
        page.add_init_script(f"({WATCH})()")
        page.goto(address)
        page.wait_for_selector("#setting")
        page.wait_for_timeout(4000)
        told_of(browser, page)
        page.evaluate(EMPTY)
        page.wait_for_timeout(2000)
        print("with nothing in the scene:")
        told_of(browser, page)


def main(width: str = "900", height: str = "700", query: str = "") -> None:
    """Print the table."""
    print(f"{'milliseconds':34}{'least':>8}{'median':>8}{'95 %':>8}")
    computed()
    with live("--speed", "650") as address:
        browsed(f"{address}?{query}", int(width), int(height))


if __name__ == "__main__":
    main(*sys.argv[1:4])
