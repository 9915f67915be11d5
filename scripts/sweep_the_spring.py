"""Sweep settings of the E62-class nipper: which bounces longest, and which least?

The study file names the ranges of speed, restitution, spring rate and preload. Its 100,000 settings
are cut into chunks, which are stored as Parquet files in a folder; what is stored is not computed
again. Here are the first two chunks; `nipper-pin sweep scripts/sweep_spring.toml` computes all.

Run: python scripts/sweep_the_spring.py [FOLDER]        (needs nipper-pin[sweep])
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

import nipper_pin as nip

STUDY = Path(__file__).with_name("sweep_spring.toml")


def main(folder: str | Path = "out/sweep_spring") -> None:
    """Compute two chunks and print their longest and their shortest transition.

    Args:
        folder: Folder of the results.
    """
    report = nip.sweep(STUDY, folder, chunks=(0, 1))
    print(f"{report.scenarios:,} transitions, {report.computed:,} of them computed now")
    # What one has to know before one uses the rows: refused settings, and settings where the
    # machine does not arrive at the touch as a transition assumes.
    for sentence in report.sentences():
        print(f"  {sentence}")
    results = nip.read_sweep(folder)
    rows = results.table.to_pydict()  # or results.to_frame() for pandas or polars
    duration = np.array(rows["duration_s"], dtype=float)  # nan: no result
    for word, row in (("longest", np.nanargmax(duration)), ("shortest", np.nanargmin(duration))):
        setting = ", ".join(
            f"{axis['name']}={rows[axis['name']][row]:.6g}" for axis in results.axes
        )
        print(f"{word} transition: {1e3 * duration[row]:.6f} ms with {setting}")
    shares = np.nanpercentile(1e3 * duration, [10.0, 50.0, 90.0])
    print("10 %, 50 % and 90 % of them are over after {:.3f}, {:.3f} and {:.3f} ms".format(*shares))


# The workers import this file again: without the line below each would start a sweep itself.
if __name__ == "__main__":
    main(*sys.argv[1:2])
