"""How long it takes to make the film of one cycle, and how large its files are.

Run: python scripts/maintain/measure/measure_film.py [RUNS]

The cycle is the E62's at 650 r/min with the jaw's gap drawn ten times as large. A page holds film,
solids and viewer; a GIF holds pictures of the same film. Times are those of the clock.
"""

from __future__ import annotations

import statistics
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import nipper_pin as nip
from nipper_pin.hybrid.case import Window


def timed(act: Callable[[], object], runs: int) -> str:
    """Least and median time of calls [s]."""
    found = []
    for _ in range(runs):
        began = time.perf_counter()
        act()
        found.append(time.perf_counter() - began)
    return f"{min(found):8.3f}{statistics.median(found):9.3f}"


def main(runs: str = "7") -> None:
    """Print the table."""
    solution = nip.simulate(nip.load("e62"), nip.Case(speed_rpm=650.0, window=Window.CYCLE))
    began = time.perf_counter()
    from nipper_pin.view.scene import Look, film
    from nipper_pin.view.scene.gif import write_gif
    from nipper_pin.view.scene.page import scene_page

    print(f"import of the viewer, once: {time.perf_counter() - began:.3f} s")
    look, count = Look(exaggerate=10.0), int(runs)
    began = time.perf_counter()
    shown = film(solution, look)
    page = scene_page(shown)
    print(f"first film and page: {time.perf_counter() - began:.3f} s")
    print("seconds                             least   median")
    for name, act in (
        (f"film of {len(shown.q)} frames", lambda: film(solution, look)),
        (f"page of it ({len(page) / 1e6:.1f} MB)", lambda: scene_page(shown)),
    ):
        print(f"{name:32}{timed(act, count)}")
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "film.gif"
        spent = timed(lambda: write_gif(solution, path, look), min(count, 2))
        print(f"{f'film and GIF ({path.stat().st_size / 1e6:.1f} MB)':32}{spent}")


if __name__ == "__main__":
    main(*sys.argv[1:2])
