"""What the Parquet file of a chunk may hold: plain columns of few types, and not too much of them.

Sizes in a file may be wrong, and a word that repeats is stored once: rows and columns decide what a
table takes, and text is counted before it is written out.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from ....errors import InputError
from .pages import Contents, contents

if TYPE_CHECKING:
    import pyarrow as pa

_NUMBER = "scenario"


class DamageError(InputError):
    """A chunk on disk that is not what was written. Evidence: ``file`` where it is known."""


def plain_table(content: bytes, columns: Sequence[str] | None, most: int) -> pa.Table:
    """Rows of a Parquet file.

    Args:
        content: The file.
        columns: Names of columns, or None for all.
        most: Most that the rows may take [byte].

    Raises:
        DamageError: It is no such file, lacks a column, or would take more.
    """
    import pyarrow as pa
    import pyarrow.parquet as pq

    try:
        words = _words(contents(content), most)
        file = pq.ParquetFile(
            pa.BufferReader(content), page_checksum_verification=True, read_dictionary=words
        )
        _check_columns(file.schema_arrow, columns)
        table = file.read(None if columns is None else list(columns))
        _check_text(table, most)
        for place, item in enumerate(table.schema):
            if pa.types.is_dictionary(item.type):
                table = table.set_column(
                    place, item.with_type(pa.string()), table[place].cast(pa.string())
                )
        table.validate(full=True)
        _check_numbers(table)
    except (pa.ArrowException, OSError, ValueError, RuntimeError) as error:
        # pyarrow gives errors of its C++ that it has no word for as RuntimeError.
        message = f"it is no chunk of a sweep ({' '.join(str(error).split())})"
        raise DamageError(message) from error
    return table


def _words(found: Contents, most: int) -> list[str]:
    """Names of columns of text of a file that is not too large."""
    if found.size > most:
        message = f"it would take {found.size:.3g} bytes; at most {most:.3g} are read"
        raise DamageError(message)
    return found.words


def _check_columns(schema: pa.Schema, columns: Sequence[str] | None) -> None:
    """Refuse columns that stand there twice, are missing, or hold neither numbers nor text."""
    import pyarrow as pa

    text, whole, real = pa.dictionary(pa.int32(), pa.string()), pa.int32(), pa.float64()
    known = {
        _NUMBER: (pa.int64(),), "engine": (text,), "outcome": (text,), "message": (text,),
        "collisions": (whole,), "premise_holds": (pa.bool_(),),
        # A parameter of a sweep of transitions may have these names.
        "turns": (whole, real), "repeats_after": (whole, real),
    }  # fmt: skip
    for item in schema:
        once = schema.names.count(item.name) == 1 and item.name.isprintable()
        if not once or item.type not in known.get(item.name, (real,)):
            message = f"its column {item.name!r} is not the one of that name of a sweep"
            raise DamageError(message)
    for name in {*(columns or ())} - {*schema.names}:
        message = f"its column {name!r} is missing"
        raise DamageError(message)


def _check_numbers(table: pa.Table) -> None:
    """Refuse a chunk without rows, and gaps among their numbers."""
    if _NUMBER in table.column_names and (not len(table) or table[_NUMBER].null_count):
        message = "it has no rows, or rows without a number"
        raise DamageError(message)


def _check_text(table: pa.Table, most: int) -> None:
    """Refuse text that would take too much when it is written out."""
    import pyarrow as pa
    import pyarrow.compute as pc

    size = 0
    for column in table.columns:
        if not pa.types.is_dictionary(column.type):
            continue
        for part in column.chunks:
            lengths = pc.binary_length(part.dictionary).take(part.indices)
            size += pc.sum(lengths.cast(pa.int64())).as_py() or 0
    if size > most:
        message = f"its text would take {size:.3g} bytes; at most {most:.3g} are read"
        raise DamageError(message)
