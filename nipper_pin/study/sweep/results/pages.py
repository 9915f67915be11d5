"""What a Parquet file grows to when it is read, by its footer and by each of its pages.

A reader sets memory aside for what a page says it grows to, which the footer need not repeat.

Source: https://github.com/apache/parquet-format, the structures of parquet.thrift.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

from .thrift import Reader

_TAIL, _MARK = 8, b"PAR1"
_MOST_PAGES = 100_000
_WIDEST = 8  # bytes of a number in a table
_TEXT = 6  # kind of a column of bytes
# Fields of FileMetaData, RowGroup, ColumnChunk, ColumnMetaData, SchemaElement and PageHeader.
_SCHEMA, _ROWS, _GROUPS = 2, 3, 4
_COLUMNS, _GROUP_BYTES, _GROUP_ROWS = 1, 2, 3
_META, _COMPRESSED, _DATA_PAGE, _WORDS_PAGE = 3, 7, 9, 11
_KIND, _NAME, _CHILDREN = 1, 4, 5
_PAGE_BYTES, _PAGE_COMPRESSED = 2, 3


class Contents(NamedTuple):
    """What a file holds.

    Attributes:
        size: What it takes when it is read, without text that repeats [byte].
        words: Names of its columns of text.
    """

    size: int
    words: list[str]


def contents(content: bytes) -> Contents:
    """What a Parquet file holds.

    Args:
        content: The file.

    Raises:
        ValueError: It is none, has columns within columns, or contradicts itself.
    """
    footer = len(content) - _TAIL
    begin = footer - int.from_bytes(content[footer : footer + 4], "little")
    if content[-4:] != _MARK or not 0 <= begin < footer:
        _refuse("it has no footer")
    about = Reader(content, begin, footer).structure()
    groups = _list(about, _GROUPS)
    rows = max(_whole(about, _ROWS), sum(_whole(group, _GROUP_ROWS) for group in groups))
    columns = _list(about, _SCHEMA)[1:]
    if any(item.get(_CHILDREN) for item in columns):
        _refuse("it has columns within columns")
    size = max(
        sum(_page_sizes(content, groups)),
        sum(_whole(group, _GROUP_BYTES) for group in groups),
        rows * len(columns) * _WIDEST,
    )
    names = [item.get(_NAME) for item in columns if item.get(_KIND) == _TEXT]
    return Contents(size, [name.decode() for name in names if isinstance(name, bytes)])


def _page_sizes(content: bytes, groups: list[dict[int, Any]]) -> Iterator[int]:
    """Bytes of each page after decompression."""
    pages = 0
    for column in (item for group in groups for item in _list(group, _COLUMNS)):
        about = column.get(_META)
        if not isinstance(about, dict):
            message = "a column does not say where it is"
            raise ValueError(message)  # noqa: TRY004
        place = _whole(about, _DATA_PAGE)
        if _WORDS_PAGE in about:
            place = min(place, _whole(about, _WORDS_PAGE))
        end = place + _whole(about, _COMPRESSED)
        if end > len(content):
            _refuse("a column ends behind the file")
        while place < end:
            reader = Reader(content, place, end)
            page = reader.structure()
            place = reader.place + _whole(page, _PAGE_COMPRESSED)
            pages += 1
            if place > end or pages > _MOST_PAGES:
                _refuse("a page does not end in its column")
            yield _whole(page, _PAGE_BYTES)


def _whole(structure: dict[int, Any], field: int) -> int:
    """A size, which has to be there."""
    value = structure.get(field)
    if not isinstance(value, int) or value < 0:
        _refuse("a size is missing or below zero")
    return int(structure[field])


def _list(structure: dict[int, Any], field: int) -> list[dict[int, Any]]:
    value = structure.get(field)
    if not isinstance(value, list) or not all(isinstance(item, dict) for item in value):
        _refuse("a list of structures is missing")
    return list(structure[field])


def _refuse(message: str) -> None:
    raise ValueError(message)
