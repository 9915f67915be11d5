"""Changes of a chunk of a sweep: its bytes and its table, under a checksum that is right."""

from __future__ import annotations

import io
import json
import random
import zlib
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from .tree import change_tree

_MARK = b"crc32:"
_MOST_ROWS = 2_000


def change_chunk(data: bytes, chance: random.Random) -> bytes:
    """Change bytes or the table of a Parquet file, and repair its checksum.

    Args:
        data: The file.
        chance: Source of chance.
    """
    kind = chance.random()
    if kind < 0.5:
        try:
            return _sealed(_table(data, chance))
        except (pa.ArrowException, OSError, ValueError, TypeError, LookupError, RuntimeError):
            pass
    content = bytearray(data or b"PAR1")
    for _ in range(chance.randint(1, 6)):
        # The footer is at the end, and says what the bytes before it are.
        far = chance.random() < 0.7
        place = len(content) - 1 - chance.randrange(min(len(content), 3000)) if far else None
        content[chance.randrange(len(content)) if place is None else place] = chance.choice(
            (0, 1, 2, 0x7F, 0x80, 0xFF, chance.randrange(256))
        )
    return _sealed(bytes(content)) if chance.random() < 0.95 else bytes(content)


def _sealed(content: bytes) -> bytes:
    """The file with the checksum of its bytes, if it has a place for one."""
    place = content.rfind(_MARK)
    if place < 0:
        return content
    place += len(_MARK)
    blank = content[:place] + b"0" * 8 + content[place + 8 :]
    return content[:place] + b"%08x" % zlib.crc32(blank) + content[place + 8 :]


def _table(data: bytes, chance: random.Random) -> bytes:
    """The file of a table that lacks, renames or changes a column, or its metadata."""
    table = pq.read_table(io.BytesIO(data))
    place = chance.randrange(table.num_columns)
    name = table.column_names[place]
    metadata = dict(table.schema.metadata or {})
    kind = chance.randrange(7)
    if kind == 0:
        table = table.drop_columns([name])
    elif kind == 1:
        names = [*table.column_names]
        names[place] = chance.choice(("", "scenario", "x", "a\nb", *names))
        table = table.rename_columns(names)
    elif kind == 2:
        table = table.set_column(place, name, _column(len(table), chance))
    elif kind == 3:
        about = json.loads(metadata.get(b"nipper_pin", b"{}"))
        metadata[b"nipper_pin"] = json.dumps(change_tree(about, chance)).encode()
    elif kind == 4:
        metadata.pop(b"nipper_pin", None)
    elif kind == 5:
        table = table.take(pa.array([chance.randrange(len(table)) for _ in range(len(table))]))
    else:
        table = pa.concat_tables([table] * chance.randint(2, 5)).slice(0, _MOST_ROWS)
    return _written(table.replace_schema_metadata(metadata))


def _column(rows: int, chance: random.Random) -> Any:
    """A column of some type."""
    kind = chance.randrange(8)
    if kind == 0:
        return pa.nulls(rows)
    if kind == 1:
        return pa.array(["x\ny"] * rows)
    if kind == 2:
        return pa.array([[1.0]] * rows)
    if kind == 3:
        return pa.array([{"a": 1}] * rows)
    if kind == 4:
        return pa.array(np.full(rows, np.nan))
    if kind == 5:
        return pa.array([None] * rows, pa.float64())
    if kind == 6:
        return pa.array([b"\xff"] * rows)
    return pa.array(np.arange(rows)[::-1].copy())


def _written(table: Any) -> bytes:
    sink = pa.BufferOutputStream()
    with pq.ParquetWriter(sink, table.schema, write_page_checksum=True) as writer:
        writer.write_table(table)
        writer.add_key_value_metadata({"nipper_pin.crc32": _MARK.decode() + "0" * 8})
    return bytes(sink.getvalue())
