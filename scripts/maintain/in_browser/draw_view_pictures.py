"""Pictures of the viewer, of a comparison and of the live page for the documents.

Run: python scripts/maintain/in_browser/draw_view_pictures.py [FOLDER]      (default docs/images)
     Needs the `dev` extra and Chromium.
"""

from __future__ import annotations

import io
import sys
import tempfile
from pathlib import Path

import numpy as np
from browser import chromium, live
from PIL import Image
from playwright.sync_api import Browser, Page

import nipper_pin as nip
from nipper_pin.view.compare.pair import pair
from nipper_pin.view.scene import Film, Look, film

ROOT = Path(__file__).resolve().parents[3]
SPEED = 650.0
VIEW, LIVE = (1120, 860), (1400, 900)  # pixels
LIVE_SPEEDS = (675.0, 700.0)  # r/min, one after the other, beside the pinned curves of SPEED
COMPARED = (450.0, 520.0)  # r/min
COLOURS = 256  # of the palette of a file


def moments(shown: Film) -> dict[str, float]:
    """Playback times [s] of the pictures, by name."""
    solution, pace = shown.solution, shown.pace
    stop = solution.mechanism.transition_stop
    hit = max(solution.collisions, key=lambda item: item.impulse if item.stop == stop else 0.0)
    opened = next(item for item in solution.phases if item.number == 1)
    foremost = solution.mechanism.cylinder.reference_index
    rear = int(np.argmin(np.abs((shown.index - foremost) % 40.0 - 20.0)))
    return {
        "phase1": float(pace.playback_at(0.5 * (opened.t_start + opened.t_end))),
        "phase2": float(pace.playback[rear]),
        "phase3": float(pace.playback_at(hit.t + 0.5 * (hit.rebound_time or 0.0))),
        "impulse": float(pace.playback_at(hit.t)) + 0.2,
    }


def save(page: Page, path: Path) -> None:
    """What a page shows, as a small PNG file."""
    image = Image.open(io.BytesIO(page.screenshot())).convert("RGB")
    # An octree palette keeps colours that few pixels have, as those of the springs.
    small = image.quantize(COLOURS, method=Image.Quantize.FASTOCTREE)
    small.save(path, optimize=True)
    print(f"wrote {path} ({path.stat().st_size / 1e3:.0f} kB)")


def view_pictures(browser: Browser, folder: Path) -> None:
    """The three phases, and an impulse."""
    solution = nip.simulate(nip.load("e62"), nip.Case(speed_rpm=SPEED, window=nip.Window.CYCLE))
    with tempfile.TemporaryDirectory() as place:
        file = Path(place) / "view.html"
        nip.view(solution, file)
        page = opened(browser, file)
        for name, time in moments(film(solution, Look())).items():
            stop_at(page, time)
            save(page, folder / f"view_{name}.png")
        page.close()


def comparison_picture(browser: Browser, path: Path) -> None:
    """Two speeds, in the middle of the first rebound at the slower one."""
    model = nip.load("e62")
    cases = (nip.Case(speed_rpm=rpm, window=nip.Window.CYCLE) for rpm in COMPARED)
    comparison = nip.compare(*(nip.simulate(model, case) for case in cases))
    first = moments(pair(comparison, Look()).a)["phase3"]
    with tempfile.TemporaryDirectory() as place:
        file = Path(place) / "both.html"
        nip.view(comparison, file)
        page = opened(browser, file)
        page.locator("#names").uncheck()
        stop_at(page, first)
        save(page, path)
        page.close()


def opened(browser: Browser, file: Path) -> Page:
    """A page of the viewer, once it plays."""
    page = browser.new_page(viewport={"width": VIEW[0], "height": VIEW[1]})
    page.goto(file.as_uri())
    wait(page, "animator.time > 0.1")
    return page


def stop_at(page: Page, time: float) -> None:
    """Stop the film at a time [s] and wait until it is drawn."""
    page.evaluate(
        "time => { animator.pause(); animator.seek(time); animator.display_progress(time); }", time
    )
    page.wait_for_timeout(1000)


def live_picture(browser: Browser, path: Path) -> None:
    """The live page in the first rebound, beside a pinned setting."""
    with live("--speed", f"{SPEED:g}") as address:
        page = browser.new_page(viewport={"width": LIVE[0], "height": LIVE[1]})
        page.goto(address)
        # The whole turn comes when its tables are made.
        wait(page, "state.turn.length > 1")
        page.click("#pin")
        field = page.locator(".control input[type=text]").first
        for speed in LIVE_SPEEDS:
            # Moves that follow each other at once are one change.
            page.wait_for_timeout(1000)
            field.fill(f"{speed:g}")
        wait(page, f"film.case.startsWith('{LIVE_SPEEDS[-1]:g}')")
        # In the middle of the first rebound; the film is not to play on after the last move.
        page.evaluate("() => { playOn = false; }")
        stop_at(page, 3.0)
        save(page, path)
        page.close()


def wait(page: Page, what: str) -> None:
    """Wait for a condition; the browser's own waiting would need a page that may run any text."""
    while not page.evaluate(what):
        page.wait_for_timeout(50)


def main(folder: str | None = None) -> None:
    """Write all pictures."""
    target = Path(folder) if folder else ROOT / "docs" / "images"
    with chromium() as browser:
        view_pictures(browser, target)
        comparison_picture(browser, target / "compare.png")
        live_picture(browser, target / "live.png")


if __name__ == "__main__":
    main(*sys.argv[1:2])
