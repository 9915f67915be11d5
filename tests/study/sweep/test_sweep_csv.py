"""The rows of a sweep as CSV and as a data frame, in SI units and in mm and degrees."""

from __future__ import annotations

import csv
import math
from pathlib import Path

import numpy as np
import pytest

import nipper_pin as nip
from nipper_pin.cli import main
from nipper_pin.mechanism.gallery import GALLERY

STUDY = """format = 1
title = "two drives of a hammer"
model = '{model}'
quantities = ["duration_s", "rebound_amplitude_1", "approach_rate_1", "impulse_N_s_1"]
[parameters.speed_rpm]
values = [60.0, 120.0]
[parameters.restitution]
values = [0.0, 0.3]
"""


@pytest.mark.parametrize(("model", "unit", "factor", "path"), [
    ("e62", ("rad", "deg"), math.degrees(1.0), "stops.jaw.restitution"),
    (GALLERY["drop_hammer"], ("m", "mm"), 1e3, "stops.height.restitution"),
])  # fmt: skip
def test_heads_of_a_table_say_their_units(
    model: str, unit: tuple[str, str], factor: float, path: str, tmp_path: Path
) -> None:
    """All rows in order, numbers to the last digit, nothing where there is none."""
    study, folder = tmp_path / "study.toml", tmp_path / "out"
    study.write_text(STUDY.format(model=model), encoding="utf-8")
    rows = {}
    for units in ("SI", "mm"):
        file = tmp_path / f"{units}.csv"
        words = ["sweep", study, "--out", folder, "--workers", 1, "--csv", file, "--units", units]
        assert main([str(word) for word in words]) == 0
        with file.open(encoding="utf-8", newline="") as stream:
            rows[units] = list(csv.DictReader(stream))
    stored, shown = nip.read_sweep(folder), nip.read_sweep(folder).to_frame("pyarrow", "mm")
    for kind, name in enumerate(unit):
        own = rows[("SI", "mm")[kind]]
        assert [float(row["speed_rpm"]) for row in own] == [60.0, 60.0, 120.0, 120.0]
        assert [float(row[path]) for row in own] == [0.0, 0.3, 0.0, 0.3]
        scale = factor if kind else 1.0
        heads = {"rebound_amplitude_1": name, "approach_rate_1": f"{name}_s"}
        heads = {key: f"{key}_{end}" for key, end in heads.items()}
        heads |= {key: key for key in ("duration_s", "impulse_N_s_1") if key in own[0]}
        assert {*heads.values()} <= {*own[0]}
        for key, head in heads.items():
            times = scale if head != key else 1.0
            wanted = np.array(stored.table[key].to_pylist(), dtype=float) * times
            found = [float(row[head] or math.nan) for row in own]
            np.testing.assert_array_equal(found, wanted)
            if kind:
                np.testing.assert_array_equal(np.array(shown[head].to_pylist(), float), wanted)
    with pytest.raises(nip.UnknownNameError, match="inch"):
        stored.to_frame(units="inch")
