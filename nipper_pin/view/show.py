"""A solution seen: served to the browser, or written as a page or a film."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from ..errors import InputError
from ..extras import require

if TYPE_CHECKING:
    from ..hybrid import Solution
    from ..study.compare import Comparison
    from .scene import Look

PORT = 7000
"""Port that a scene is served at."""


def view(
    solution: Solution | Comparison,
    file: str | Path | None = None,
    *,
    slow: float | None = None,
    exaggerate: float | None = None,
    port: int = PORT,
    browser: bool = True,
) -> Path | None:
    """Show a solution, or a comparison of two in one film.

    Args:
        solution: The solution, or the comparison.
        file: ``NAME.html`` for one page that holds everything, ``NAME.gif`` for the film in side
            view (of one solution); None to serve it until Ctrl-C.
        slow: Time is stretched 1 : slow around events; by default 1000, or less for a run of which
            the film would take more than two minutes.
        exaggerate: Rebounds of the transition stop are drawn so many times as large, 1 to 1000; by
            default a round number of times by which they are seen. The page shows them in true size
            at a click.
        port: Port to serve at; 0 for any that is free.
        browser: Whether to open the page that is served in the user's browser.

    Returns:
        The file; None if it was served.

    Raises:
        InputError: A value is out of range, the file or port cannot be used, or a library of the
            extra ``view`` is not installed.
    """
    from ..hybrid import Solution as Simulated
    from ..study.compare import Comparison as Compared

    if not isinstance(solution, Simulated | Compared):
        message = f"view shows a solution, and this is {solution!r}: nip.view(nip.simulate(...))"
        raise InputError(message, solution=solution)
    from .scene import Look

    look = Look(slow=slow, exaggerate=exaggerate)
    target = None if file is None else Path(file)
    kinds = [".html", *([".gif"] if isinstance(solution, Simulated) else [])]
    if target is not None and target.suffix.lower() not in kinds:
        message = f"{target}: a scene is written as NAME{' or NAME'.join(kinds)}"
        raise InputError(message, file=str(target))
    need_libraries(*([] if target is None else [target]))
    if target is not None:
        write(solution, target, look)
        return target
    from ..given import flag, whole
    from .local import serve

    port = whole("port", port, 0, 65535)
    serve(shown_page(solution, look), port, browser=flag("browser", browser))
    return None


def shown_page(shown: Solution | Comparison, look: Look) -> str:
    """The page of a solution or a comparison, served or written alike.

    Raises:
        InputError: There is nothing to show.
    """
    from ..study.compare import Comparison

    if isinstance(shown, Comparison):
        from .compare.page import comparison_page

        return comparison_page(shown, look)
    from .scene import film
    from .scene.page import scene_page

    return scene_page(film(shown, look))


def write(shown: Solution | Comparison, path: Path, look: Look) -> None:
    """Write the film in side view (``.gif``), or one HTML file that needs nothing else.

    Raises:
        InputError: There is nothing to show, or the file cannot be written.
    """
    from ..hybrid import Solution
    from ..outputs import complete_file

    if path.suffix.lower() == ".gif" and isinstance(shown, Solution):
        from .scene.gif import write_gif

        write_gif(shown, path, look)
        return

    page = shown_page(shown, look)
    with complete_file(path) as partial:
        partial.write_text(page, encoding="utf-8")


def need_libraries(*files: Path) -> None:
    """Refuse to write files, or without any to serve a page, without the libraries that do.

    Raises:
        InputError: One of them is not installed.
    """
    kinds = {file.suffix.lower() for file in files}
    if kinds != {".gif"}:
        require("view", "meshcat", "umsgpack", what="a page of the viewer")
    if ".gif" in kinds:
        require("view", "matplotlib", "PIL", what="a film as a GIF")
