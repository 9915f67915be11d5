"""Make PNG files of plots small: a palette of few colours, and not wider than they are shown.

Run: python scripts/maintain/figures/shrink_pictures.py [--width PIXELS] FILE...
"""

from __future__ import annotations

import argparse
from pathlib import Path

from PIL import Image

COLOURS = 48


def shrink(path: Path, width: int | None) -> int:
    """Write a file anew, and return its size [byte].

    Args:
        path: The file.
        width: Its largest width [pixel]; None: as it is.
    """
    with Image.open(path) as opened:
        image = opened.convert("RGB")
    if width is not None and image.width > width:
        height = round(image.height * width / image.width)
        image = image.resize((width, height), Image.Resampling.LANCZOS)
    small = image.quantize(COLOURS, method=Image.Quantize.MEDIANCUT, dither=Image.Dither.NONE)
    small.save(path, optimize=True)
    return path.stat().st_size


def main() -> None:
    """Shrink all files that are named."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--width", type=int, metavar="PIXELS", help="largest width")
    parser.add_argument("files", nargs="+", type=Path, metavar="FILE")
    options = parser.parse_args()
    for path in options.files:
        print(f"{path}: {shrink(path, options.width) / 1e3:.0f} kB")


if __name__ == "__main__":
    main()
