"""Structures in Thrift's compact protocol, of which Parquet makes its footer and begins of pages.

Libraries trust the sizes that stand there, and some errors in them end the whole process. Here they
are read as plain data, before any library sees them.

Source: https://github.com/apache/thrift/blob/master/doc/specs/thrift-compact-protocol.md.
"""

from __future__ import annotations

from typing import Any

_BYTE, _DOUBLE, _BINARY, _LIST, _SET, _MAP, _STRUCT = 3, 7, 8, 9, 10, 11, 12
_TRUTHS, _WHOLE = (1, 2), (4, 5, 6)
_DEEPEST = 12
_LONG = 70  # bits that no whole number has


class Reader:
    """Reads structures one after the other.

    Args:
        content: What holds them.
        place: Where the first one begins.
        end: Where the last one ends.

    Attributes:
        place: Where the next one begins.
    """

    def __init__(self, content: bytes, place: int, end: int) -> None:
        """Begin."""
        self._content, self._end = content, end
        self.place = place

    def structure(self, depth: int = 0) -> dict[int, Any]:
        """The values of a structure by the numbers of their fields.

        Args:
            depth: Structures around this one.

        Raises:
            ValueError: It is none, or says a thing twice.
        """
        if depth > _DEEPEST:
            _refuse("nests too deeply")
        found: dict[int, Any] = {}
        field = 0
        while byte := self._byte():
            field = field + (byte >> 4) if byte >> 4 else self._signed()
            if field in found:
                _refuse("says a thing twice")
            kind = byte & 0x0F
            found[field] = kind == 1 if kind in _TRUTHS else self._value(kind, depth)
        return found

    def _value(self, kind: int, depth: int) -> Any:
        if kind in _WHOLE:
            return self._signed()
        if kind == _STRUCT:
            return self.structure(depth + 1)
        if kind == _BINARY:
            return self._part(self._number())
        if kind == _DOUBLE:
            return self._part(8)
        if kind in (_BYTE, *_TRUTHS):
            return self._byte()
        if kind in (_LIST, _SET):
            byte = self._byte()
            count = self._number() if byte >> 4 == 15 else byte >> 4
            return self._values(count, (byte & 0x0F,), depth)
        if kind == _MAP:
            count = self._number()
            return self._values(count, divmod(self._byte(), 16) if count else (), depth)
        return _refuse("holds a value of no kind")

    def _values(self, count: int, kinds: tuple[int, ...], depth: int) -> list[Any]:
        if depth > _DEEPEST or count > self._end - self.place:
            _refuse("holds more than it has")
        return [self._value(kind, depth + 1) for _ in range(count) for kind in kinds]

    def _part(self, length: int) -> bytes:
        begin, self.place = self.place, self.place + length
        if self.place > self._end:
            _refuse("ends early")
        return self._content[begin : self.place]

    def _byte(self) -> int:
        return self._part(1)[0]

    def _number(self) -> int:
        """A whole number, seven bits a byte."""
        value = shift = 0
        while shift < _LONG:
            byte = self._byte()
            value |= (byte & 0x7F) << shift
            if byte < 0x80:
                return value
            shift += 7
        return int(_refuse("holds a number that is too long"))

    def _signed(self) -> int:
        value = self._number()
        return (value >> 1) ^ -(value & 1)


def _refuse(what: str) -> Any:
    message = f"a structure {what}"
    raise ValueError(message)
