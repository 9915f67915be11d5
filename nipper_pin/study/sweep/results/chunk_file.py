"""One chunk as a Parquet file: plain columns of few types, whose pages carry checksums.

Sizes in a file may be wrong, and a word that repeats is stored once: rows and columns decide what a
table takes, and text is counted before it is written out.
"""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import msgspec
import numpy as np
from msgspec import Meta

from ....errors import InputError
from ....texts import opened

if TYPE_CHECKING:
    import pyarrow as pa

MOST_BYTES = 2**28
"""Most that a chunk may have, or hold after decompression [byte]: 65,536 rows, the most that a plan
puts into one by itself, of five hundred columns."""
_ABOUT, _NUMBER = "nipper_pin", "scenario"
_WORDS = ("engine", "outcome", "message")
_WIDEST = 8  # bytes of a number in a table


class DamageError(InputError):
    """A chunk on disk that is not what was written. Evidence: ``file`` where it is known."""


class _About(msgspec.Struct, frozen=True):
    """What a chunk says of its rows, as far as it is read again.

    Attributes:
        plan: Identity of their plan.
        direct: Rows of the direct engine by the reason why it served.
    """

    plan: str = ""
    direct: dict[str, Annotated[int, Meta(ge=0, le=2**53)]] = msgspec.field(default_factory=dict)


def encode(
    columns: Mapping[str, Any], *, units: Mapping[str, str], about: Mapping[str, Any]
) -> bytes:
    """The file of one chunk.

    Args:
        columns: Values by name, all of one length.
        units: Unit of each column that has one, kept as metadata ``unit`` of its field.
        about: What the rows are of, kept as JSON under ``nipper_pin`` in the file's metadata.

    Returns:
        The bytes; the same arguments give the same ones.
    """
    import pyarrow as pa
    import pyarrow.parquet as pq

    table = pa.table(dict(columns))
    fields = [
        item.with_metadata({"unit": units[item.name]}) if item.name in units else item
        for item in table.schema
    ]
    schema = pa.schema(fields, metadata={_ABOUT: json.dumps(about)})
    # Bytes of numbers of the same size compress when they stand byte by byte.
    split = [item.name for item in fields if pa.types.is_float64(item.type)]
    sink = pa.BufferOutputStream()
    with pq.ParquetWriter(
        sink,
        schema,
        compression="zstd",
        use_dictionary=list(_WORDS),
        use_byte_stream_split=split,
        write_page_checksum=True,
    ) as writer:
        writer.write_table(table.cast(schema))
    return bytes(sink.getvalue())


def check(table: pa.Table, name: str, start: int, stop: int, plan: str) -> None:
    """Refuse rows of another chunk.

    Args:
        table: The rows, with their numbers.
        name: Name of the file, for messages.
        start: First scenario that it should hold.
        stop: The one after the last.
        plan: Identity of the plan that it should belong to.

    Raises:
        DamageError: They are others.
    """
    if not np.array_equal(table["scenario"].to_numpy(), np.arange(start, stop)):
        message = f"{name}: holds other scenarios than {start} to {stop - 1}"
        raise DamageError(message, file=name)
    try:
        found = about(table).get("plan")
    except DamageError as error:
        message = f"{name}: {error.message}"
        raise DamageError(message, file=name) from error
    if found != plan:
        message = f"{name}: holds scenarios of another plan"
        raise DamageError(message, file=name)


def about(table: pa.Table) -> dict[str, Any]:
    """Metadata of a chunk: its rows and their plan.

    Raises:
        DamageError: It has none.
    """
    try:
        found: dict[str, Any] = json.loads((table.schema.metadata or {})[_ABOUT.encode()])
        msgspec.convert(found, _About)
    except (LookupError, ValueError, RecursionError) as error:
        message = f"it does not say which sweep it is of ({error})"
        raise DamageError(message) from error
    return found


def read(content: bytes, columns: Sequence[str] | None = None) -> pa.Table:
    """Rows of a chunk whose pages are as they were written.

    Args:
        content: The file.
        columns: Names of columns, or None for all.

    Raises:
        DamageError: It is damaged, is no chunk, lacks a column, or would take too much.
    """
    import pyarrow as pa
    import pyarrow.parquet as pq

    source, longest = pa.BufferReader(content), max(len(content), 1)
    try:
        metadata = pq.ParquetFile(
            source, thrift_string_size_limit=longest, thrift_container_size_limit=longest
        ).metadata
        _check_size(metadata)
        file = pq.ParquetFile(
            source,
            metadata=metadata,
            read_dictionary=[name for name in _WORDS if name in metadata.schema.names],
            page_checksum_verification=True,
        )
        _check_columns(file.schema_arrow, columns)
        names = file.schema_arrow.names
        chosen = [name for name in names if columns is None or name in columns]
        # Threads of a library that still end with the process may abort it.
        table = file.read(chosen, use_threads=False)
        _check_text(table)
        for place, item in enumerate(table.schema):
            if pa.types.is_dictionary(item.type):
                table = table.set_column(
                    place, item.with_type(pa.string()), table[place].cast(pa.string())
                )
        table.validate(full=True)
        if _NUMBER in table.column_names and (not len(table) or table[_NUMBER].null_count):
            message = "it has no rows, or rows without a number"
            raise DamageError(message)
    except (pa.ArrowException, OSError, LookupError, ValueError, RuntimeError) as error:
        # pyarrow gives errors of its C++ that it has no word for as RuntimeError.
        message = f"damaged, or no chunk of a sweep ({' '.join(str(error).split())})"
        raise DamageError(message) from error
    return table


def _check_size(metadata: Any) -> None:
    """Refuse a file that would take too much, by the metadata in its footer."""
    groups = [metadata.row_group(place) for place in range(metadata.num_row_groups)]
    rows, sizes = [x.num_rows for x in groups], [x.total_byte_size for x in groups]
    if min([metadata.num_rows, *rows, *sizes]) < 0:
        message = "a size is below zero"
        raise ValueError(message)
    numbers = max(metadata.num_rows, sum(rows)) * metadata.num_columns
    size = max(numbers * _WIDEST, sum(sizes))
    if size > MOST_BYTES:
        message = f"it would take {size:.3g} bytes; at most {MOST_BYTES:.3g} are read"
        raise DamageError(message)


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


def _check_text(table: pa.Table) -> None:
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
    if size > MOST_BYTES:
        message = f"its text would take {size:.3g} bytes; at most {MOST_BYTES:.3g} are read"
        raise DamageError(message)


def _content(file: Path) -> bytes:
    """Bytes of a file that is not too large."""
    with opened(file) as stream:
        size = os.fstat(stream.fileno()).st_size
        if size > MOST_BYTES:
            message = f"it has {size:.3g} bytes; at most {MOST_BYTES:.3g} are read"
            raise DamageError(message)
        return stream.read()


def read_file(file: Path, columns: Sequence[str] | None = None) -> pa.Table:
    """Rows of a chunk on disk.

    Args:
        columns: Names of columns, or None for all.

    Raises:
        DamageError: It cannot be read, is damaged, or is no chunk.
    """
    try:
        return read(_content(file), columns)
    except OSError as error:
        message = f"{file}: cannot be read ({error.strerror or error})"
        raise DamageError(message, file=str(file)) from error
    except DamageError as error:
        message = f"{file}: {error.message}"
        raise DamageError(message, file=str(file)) from error
