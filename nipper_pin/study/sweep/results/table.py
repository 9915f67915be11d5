"""Results of a sweep, read again."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ....errors import InputError
from ....given import whole
from ....hybrid.result.columns import IN_MM, known_units, with_unit
from ....outputs import complete_file
from ....terms import NONE
from .chunk_file import DamageError, check, read_file
from .record import columns_of, read_document
from .store import CHUNKS, PLAN, need_pyarrow

if TYPE_CHECKING:
    import pyarrow as pa


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class SweepTable:
    """Scenarios of a sweep, all of them or evenly thinned out.

    Attributes:
        title: What the sweep is about.
        model: What the model is, in a few words.
        axes: Parameters, each with ``name``, ``path``, ``low``, ``high``, ``scale`` and ``values``
            (empty if it is sampled).
        quantities: Names of what was kept.
        scenarios: Scenarios of the plan.
        stored: Scenarios on disk.
        table: The rows; the unit of a column is in the metadata of its field.
    """

    title: str
    model: str
    axes: tuple[dict[str, Any], ...]
    quantities: tuple[str, ...]
    scenarios: int
    stored: int
    table: pa.Table

    def __repr__(self) -> str:
        """One line."""
        names = ", ".join(axis["name"] for axis in self.axes)
        return f"<SweepTable of {self.model}: {len(self.table):,} scenarios over {names}>"

    def _repr_html_(self) -> str:
        from ....notebook import SHOWN, html

        rows = list(zip(*self.table.slice(0, SHOWN + 1).to_pydict().values(), strict=True))
        facts = {"model": self.model, "scenarios": f"{self.stored:,} of {self.scenarios:,} stored"}
        return html(self.title or "sweep", facts, self.table.column_names, rows, len(self.table))

    def to_frame(self, library: str | None = None, units: str = "SI") -> Any:
        """All rows as a data frame.

        Args:
            library: "pandas", "polars" or "pyarrow"; by default the first that is installed.
            units: "SI", or "mm" for quantities in mm and degrees; parameters have the units of the
                study.

        Raises:
            InputError: The library is not installed.
            UnknownNameError: There are no such units.
        """
        from ....frames import data_frame

        table = self._in_mm() if known_units(units) == "mm" else self.table
        if library == "pyarrow":
            return table
        return data_frame({name: table[name].to_pylist() for name in table.column_names}, library)

    def _in_mm(self) -> pa.Table:
        """The rows with quantities in mm and degrees, and names that say so."""
        import pyarrow.compute as pc

        found = self.table
        for place, field in enumerate(self.table.schema):
            unit = self._unit(field)
            if unit in IN_MM:
                shown, factor = IN_MM[unit]
                values = pc.multiply(found[place], factor)
                found = found.set_column(place, with_unit(field.name, unit, shown), values)
        return found

    def write_csv(self, path: str | Path, units: str = "SI") -> None:
        """Write all rows as CSV, as spreadsheets open it; each head ends with its unit.

        Args:
            path: File to write; it appears when it is complete.
            units: As of `to_frame`; parameters have the names and units of model files.

        Raises:
            InputError: The file cannot be written.
            UnknownNameError: There are no such units.
        """
        from pyarrow.csv import write_csv

        table = self.to_frame("pyarrow", units)
        paths = {axis["name"]: axis["path"] for axis in self.axes}
        heads = []
        for field, name in zip(self.table.schema, table.column_names, strict=True):
            unit = self._unit(field)
            own = with_unit(name, unit, unit) if unit and name == field.name else name
            heads.append(paths.get(name, own))
        with complete_file(Path(path)) as partial:
            write_csv(table.rename_columns(heads), partial)

    def _unit(self, field: pa.Field) -> str:
        """SI unit of a quantity; empty for one without, and for all other columns."""
        unit = (field.metadata or {}).get(b"unit", b"").decode()
        return unit if field.name in self.quantities and unit != NONE else ""


def read_sweep(folder: str | Path, most: int | None = None) -> SweepTable:
    """Read what a sweep has stored so far.

    Args:
        folder: Folder of the sweep.
        most: Most rows to read, evenly spread over all scenarios.

    Raises:
        InputError: The folder holds no sweep, or nothing of it yet, or is damaged.
    """
    need_pyarrow()
    import pyarrow as pa

    if most is not None:
        whole("most", most, 1, 2**53)
    document = read_document(Path(folder) / PLAN)
    files = sorted((Path(folder) / CHUNKS).glob("*.parquet"))
    step = 1 if most is None else -(-int(document["scenarios"]) // most)
    # Every k-th scenario has to meet all values of the grids: k shares no factor with them.
    sizes = 2 * math.prod(len(axis["values"]) or 1 for axis in document["axes"])
    while math.gcd(step, sizes) > 1:
        step += 1
    named = (axis["name"] for axis in document["axes"])
    wanted = [*columns_of(document), *named, *document["quantities"]]
    parts: list[pa.Table] = []
    stored = end = 0
    for file in files:
        try:
            part, end = _part(file, wanted, document["identity"], end)
        except DamageError as error:
            message = f"{error.message}; run the sweep again: it computes this chunk anew"
            raise InputError(message, file=str(file)) from error
        if parts and not part.schema.equals(parts[0].schema):
            message = f"{file}: has other columns than its sweep; run it with another --out"
            raise InputError(message, file=str(file))
        stored += len(part)
        if step > 1:
            first = -part["scenario"][0].as_py() % step
            part = part.take(pa.array(range(first, len(part), step), type=pa.int64()))
        parts.append(part)
    if not parts:
        message = f"{folder}: nothing is computed yet; run nipper-pin sweep"
        raise InputError(message, folder=str(folder))
    return SweepTable(
        title=document["title"],
        model=document["description"].get("title") or document["model"],
        axes=tuple(document["axes"]),
        quantities=tuple(document["quantities"]),
        scenarios=document["scenarios"],
        stored=stored,
        table=pa.concat_tables(parts),
    )


def _part(file: Path, columns: Sequence[str], plan: str, begin: int) -> tuple[pa.Table, int]:
    """Rows of a chunk of a plan behind those of the chunks before it, and where they end."""
    part = read_file(file, columns)
    first = int(part["scenario"][0].as_py())
    check(part, str(file), first, first + len(part), plan)
    if first < begin:
        message = f"{file}: holds scenarios of another chunk"
        raise DamageError(message, file=str(file))
    return part, first + len(part)
