"""A sweep on a Dask cluster: here two workers of this machine, elsewhere as many as you have.

A cluster is asked for by the address of its scheduler. `dask scheduler` and `dask worker` start one
by hand, dask-jobqueue one on a batch system; see docs/sweeps_cluster.md. A chunk that a lost worker
had is computed by another.

The study has 200 machines with other eccentrics, each at ten speeds; here are the first 36.

Run: python scripts/sweep_with_dask.py [FOLDER]        (needs nipper-pin[cluster])
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from distributed import LocalCluster

import nipper_pin as nip

STUDY = Path(__file__).with_name("sweep_eccentric.toml")


def main(folder: str | Path = "out/sweep_eccentric") -> None:
    """Start a cluster, sweep on it and print how the mean rebound depends on the speed.

    Args:
        folder: Folder of the results.
    """
    # One thread a worker: the work holds Python's lock.
    with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster:
        address = cluster.scheduler_address
        report = nip.sweep(STUDY, folder, scheduler=address, chunks=(0, 3))
        print(f"{report.computed:,} of {report.scenarios:,} scenarios computed at {address}")
    rows = nip.read_sweep(folder).table.to_pydict()
    speed = np.array(rows["speed_rpm"])
    rebound = np.degrees(np.array(rows["rebound_amplitude_1"], dtype=float))  # nan: no result
    for value in np.unique(speed):
        here = rebound[speed == value]
        print(
            f"{value:6.1f} r/min: first rebound {np.nanmean(here):.6f} deg on average, "
            f"{np.nanmax(here):.6f} deg at most, of {np.isfinite(here).sum()} machines"
        )


# The workers import this file again: without the line below each would start a cluster itself.
if __name__ == "__main__":
    main(*sys.argv[1:2])
