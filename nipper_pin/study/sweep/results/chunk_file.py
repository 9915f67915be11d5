"""One chunk as the bytes of a Parquet file that shows any damage.

Pages carry checksums, which every reader of Parquet can verify. They say nothing of the footer,
where one bit turned gives a column another name or another column's pages. So the footer holds a
checksum of the whole file, too, taken with zeros in its own place.
"""

from __future__ import annotations

import json
import os
import zlib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import msgspec
import numpy as np
from msgspec import Meta

from ....texts import opened
from .chunk_table import DamageError, plain_table

if TYPE_CHECKING:
    import pyarrow as pa

MOST_BYTES = 2**28
"""Most that a chunk may have, or hold after decompression [byte]: 65,536 rows, the most that a plan
puts into one by itself, of five hundred columns."""
_ABOUT, _CRC = "nipper_pin", "nipper_pin.crc32"
# A word before it, so that no other eight zeros of a file are taken for its place.
_MARK = b"crc32:"
_BLANK = _MARK + b"0" * 8


class _About(msgspec.Struct, frozen=True):
    """What a chunk says of its rows, as far as it is read again.

    Attributes:
        plan: Identity of their plan.
        direct: Rows of the direct engine by the reason why it served.
    """

    plan: str = ""
    direct: dict[str, Annotated[int, Meta(ge=0, le=2**53)]] = msgspec.field(default_factory=dict)


def encode(
    columns: Mapping[str, Any],
    *,
    words: Sequence[str],
    units: Mapping[str, str],
    about: Mapping[str, Any],
) -> bytes:
    """The file of one chunk.

    Args:
        columns: Values by name, all of one length.
        words: Columns of text that repeats.
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
        use_dictionary=list(words),
        use_byte_stream_split=split,
        write_page_checksum=True,
    ) as writer:
        writer.write_table(table.cast(schema))
        # Only here: metadata of the schema is stored a second time, in the schema of Arrow.
        writer.add_key_value_metadata({_CRC: _BLANK.decode()})
    content = bytes(sink.getvalue())
    place = _place(content)
    return content[:place] + b"%08x" % zlib.crc32(content) + content[place + 8 :]


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
    """Rows of a chunk whose every bit is as it was written.

    Args:
        content: The file.
        columns: Names of columns, or None for all.

    Raises:
        DamageError: A bit is not as it was written.
    """
    place = _place(content)
    # Without a copy of what may be large.
    whole = memoryview(content)
    found = zlib.crc32(whole[place + 8 :], zlib.crc32(b"0" * 8, zlib.crc32(whole[:place])))
    if content[place : place + 8] != b"%08x" % found:
        message = "damaged: its checksum is not that of its bytes"
        raise DamageError(message)
    return plain_table(content, columns, MOST_BYTES)


def _place(content: bytes) -> int:
    """Position of the checksum: after the last mark, since all other metadata precede it."""
    return content.rfind(_MARK) + len(_MARK)


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
        file: The file.
        columns: Names of columns, or None for all.

    Raises:
        DamageError: It cannot be read, or a bit is not as it was written.
    """
    try:
        return read(_content(file), columns)
    except OSError as error:
        message = f"{file}: cannot be read ({error.strerror or error})"
        raise DamageError(message, file=str(file)) from error
    except DamageError as error:
        message = f"{file}: {error.message}"
        raise DamageError(message, file=str(file)) from error
