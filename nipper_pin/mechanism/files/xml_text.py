"""The XML of a URDF: its encoding, its default namespace, and xacro that nobody expanded."""

from __future__ import annotations

import codecs
import re
from typing import NoReturn
from xml.etree import ElementTree

from ...errors import ModelError
from ...texts import MOST_TEXT

_DECLARED = re.compile(rb"""\s*<\?xml[^>]*?\sencoding\s*=\s*["']([A-Za-z0-9._-]+)["']""")
_WORDS = re.compile(r"""(\A\s*<\?xml[^>]*?)\sencoding\s*=\s*["'][A-Za-z0-9._-]+["']""")
_MARKS = (
    (codecs.BOM_UTF8, "utf-8-sig"),
    (codecs.BOM_UTF16_LE, "utf-16"),
    (codecs.BOM_UTF16_BE, "utf-16"),
    (b"<\0", "utf-16-le"),
    (b"\0<", "utf-16-be"),
)
_EXPRESSION = re.compile(r"\$[({]")
# Writers of XML call themselves for each element in another; those of a URDF are five deep.
_DEEPEST = 100
# The elements that are read; others belong to other programs.
_READ = ("link", "joint", "material")


def encoding_of(content: bytes) -> str:
    """Encoding of an XML file: by its byte order mark, or what its first line declares."""
    for mark, encoding in _MARKS:
        if content.startswith(mark):
            return encoding
    declared = _DECLARED.match(content)
    return "utf-8" if declared is None else declared[1].decode("ascii")


def as_unicode(text: str) -> str:
    """XML text without the encoding it declares: it is written in UTF-8."""
    return _WORDS.sub(r"\1", text, 1)


def parse_xml(text: str, file: str) -> ElementTree.Element:
    """Parse URDF text, comments kept; elements of a default namespace lose it.

    Raises:
        ModelError: The text is not well-formed XML, not a URDF, or xacro that is not expanded.
    """
    if len(text) > MOST_TEXT:
        allowed = f"at most {MOST_TEXT} characters"
        raise ModelError(file=file, key="length", value=len(text), allowed=allowed)
    builder = ElementTree.TreeBuilder(insert_comments=True)
    try:
        root = ElementTree.fromstring(text, ElementTree.XMLParser(target=builder))
    except (ElementTree.ParseError, ValueError) as error:
        if "<xacro:" in text:
            _call_it_xacro("<xacro:", file)
        value = str(error)
        raise ModelError(
            file=file, key="XML", value=value, allowed="a URDF is well-formed XML"
        ) from error
    space, _, name = root.tag.rpartition("}")
    if name != "robot":
        raise ModelError(
            file=file, key="root element", value=root.tag, allowed="a URDF starts with <robot>"
        )
    _check_depth(root, file)
    for element in root.iter() if space else ():
        if isinstance(element.tag, str):
            element.tag = element.tag.removeprefix(space + "}")
    _refuse_xacro(root, file)
    return root


def _check_depth(root: ElementTree.Element, file: str) -> None:
    """Refuse elements in one another that are too many to be written again."""
    level, depth = [root], 0
    while level:
        level = [inner for element in level for inner in element]
        depth += 1
        if depth > _DEEPEST:
            allowed = f"at most {_DEEPEST} elements in one another"
            raise ModelError(file=file, key="XML", value=f"more than {_DEEPEST}", allowed=allowed)


def _refuse_xacro(root: ElementTree.Element, file: str) -> None:
    """Refuse macros and expressions of xacro: what they stand for is not in the file."""
    for element in root.iter():
        if isinstance(element.tag, str) and element.tag.startswith("{"):
            space, _, name = element.tag.partition("}")
            if "xacro" in space:
                _call_it_xacro(f"<xacro:{name}>", file)
    for part in root:
        for element in part.iter() if part.tag in _READ else ():
            for value in element.attrib.values():
                if _EXPRESSION.search(value):
                    _call_it_xacro(value, file)


def _call_it_xacro(value: str, file: str) -> NoReturn:
    allowed = (
        "a URDF; this is xacro that has not been expanded: write the URDF with "
        "'xacro MODEL.urdf.xacro -o MODEL.urdf'"
    )
    raise ModelError(file=file, key="xacro", value=value, allowed=allowed)
