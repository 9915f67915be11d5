"""How long the live page takes to appear, and to follow a slider, in Chromium without a window.

Run: python scripts/maintain/in_browser/time_live_page.py [MOVES]      (default 20)
     Needs the `dev` extra and Chromium. Medians and the slowest of ten, on an idle machine.
"""

from __future__ import annotations

import sys

import numpy as np
from browser import chromium, live
from playwright.sync_api import Page

SIZE = 1400, 900  # pixels
LOWEST = 600.0  # r/min, from which the slider goes up in steps of 5
# Until the numbers of a setting, and the curves with them, are on the screen.
MOVE = """speed => new Promise(done => {
    const { slider } = controls.speed, began = performance.now(), before = state;
    slider.value = speed;
    slider.dispatchEvent(new Event("input"));
    const look = () => requestAnimationFrame(() => {
        if (state === before) look();
        else setTimeout(() => done(performance.now() - began));
    });
    look();
})"""
PAINTED = """() => performance.getEntriesByName("first-contentful-paint")
    .map(item => item.startTime)[0] ?? null"""


def moves(page: Page, count: int, pause: int) -> str:
    """Time from a move of the speed's slider to what it shows, in words.

    Args:
        pause: Time between two moves [ms].
    """
    found = []
    for number in range(count):
        page.wait_for_timeout(pause)
        found.append(float(page.evaluate(MOVE, LOWEST + 5.0 * (number % 21))))
    return (
        f"median {np.median(found):.0f} ms, slowest of ten {np.quantile(found, 0.9):.0f} ms, "
        f"{count} moves"
    )


def main(count: str = "20") -> None:
    """Print both."""
    with chromium() as browser, live("--speed", "650") as address:
        appeared = []
        for _ in range(5):
            page = browser.new_page(viewport={"width": SIZE[0], "height": SIZE[1]})
            page.goto(address)
            while page.evaluate(PAINTED) is None:
                page.wait_for_timeout(20)
            appeared.append(float(page.evaluate(PAINTED)))
            if len(appeared) < 5:
                page.close()
        while page.locator("[data-key=rest]").count() == 0:
            page.wait_for_timeout(50)
        for pause, what in ((60, "while it is dragged"), (2000, "after the film has played on")):
            print(f"a move of the slider {what}: {moves(page, int(count), pause)}")
    print(f"first paint: median {np.median(appeared):.0f} ms, slowest {max(appeared):.0f} ms")


if __name__ == "__main__":
    main(*sys.argv[1:2])
