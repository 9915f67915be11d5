"""JSON schemas of the TOML files of models and drawings, made from the tables that read them.

Editors complete keys, show what they mean and mark mistakes by it. The words are those of the
docstrings in :mod:`.description`, so that neither text nor limits are written twice.
"""

from __future__ import annotations

import inspect
import json
import re
from importlib import import_module
from pathlib import Path
from typing import Any, Literal

import msgspec

from ...written_units import pattern_of_key
from . import description
from .description import Description
from .register import DRIVES, FORCES, RESTITUTIONS, STOPS

_ATTRIBUTE = re.compile(r"(?P<name>\w+): (?P<text>.*?)(?=\n\w+: |\Z)", re.DOTALL)


def model_schema() -> dict[str, Any]:
    """Return the JSON schema (draft 2020-12) of a model's TOML file."""
    return _schema(Description, "nipper_pin model")


def drawing_schema() -> dict[str, Any]:
    """Return that of a drawing: its own tables, and those of a model that it does not make."""
    from ..drawing.layout import MADE, DrawingTable

    schema = _schema(DrawingTable, "nipper_pin drawing")
    tables = schema["$defs"]
    own, others = tables["DrawingTable"]["properties"], tables.pop("Description")["properties"]
    own |= {key: value for key, value in others.items() if key not in (*own, *MADE)}
    ends = {"type": "array", "items": {"type": "string"}, "minItems": 2, "maxItems": 2}
    words = "Link and point of either end, in place of its frames."
    for name in ("SpringDescription", "DamperDescription"):
        tables[name]["properties"]["ends"] = {"description": words, **ends}
    for name in ("CylinderDescription", "ClosureDescription"):
        del tables[name]
    return schema


def _schema(of_file: type, title: str) -> dict[str, Any]:
    """Schema of a file, with the tables of a model and of all laws."""
    registers = {
        "drives": DRIVES,
        "forces": FORCES,
        "restitution_law": RESTITUTIONS,
        "adjusted": STOPS,
    }
    laws = {key: list(register.tables().values()) for key, register in registers.items()}
    tables = {kind.__name__: kind for kinds in laws.values() for kind in kinds}
    (whole, *_), parts = msgspec.json.schema_components(
        [of_file, Description, *tables.values()], ref_template="#/$defs/{name}"
    )
    schema = json.loads(msgspec.json.encode({**whole, "$defs": parts}))
    choices = {
        key: {"anyOf": [{"$ref": f"#/$defs/{kind.__name__}"} for kind in kinds]}
        for key, kinds in laws.items()
    }
    document = schema["$defs"]["Description"]["properties"]
    for key in ("drives", "forces"):
        document[key]["additionalProperties"] = choices[key]
    of_stop = schema["$defs"]["StopDescription"]["properties"]
    for key in ("restitution_law", "adjusted"):
        of_stop[key] |= choices[key]
    homes = (description, import_module(of_file.__module__))
    for name, table in schema["$defs"].items():
        found = (getattr(home, name, None) for home in homes)
        kind = tables.get(name) or next(each for each in found if each is not None)
        # The first paragraph of its docstring, on one line.
        table["description"] = " ".join((inspect.getdoc(kind) or "").partition("\n\n")[0].split())
        del table["title"]
        words = {"law": table["description"], **_attributes(kind)}
        for key, value in table["properties"].items():
            table["properties"][key] = _plain(value, words.get(key))
        table |= _in_other_units(table["properties"])
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", "title": title, **schema}


def schema_text(kind: Literal["model", "drawing"]) -> str:
    """Return a schema as the text of its file."""
    schema = model_schema() if kind == "model" else drawing_schema()
    return json.dumps(schema, indent=1) + "\n"


def write_document(file: Path, text: str, kind: Literal["model", "drawing"] = "model") -> None:
    """Write a TOML document; its first line refers to its schema, which is put beside it."""
    schema = file.with_name(f"{kind}.schema.json")
    file.write_text(f"#:schema ./{schema.name}\n{text}", encoding="utf-8")
    schema.write_text(schema_text(kind), encoding="utf-8")


def _plain(value: dict[str, Any], words: str | None) -> dict[str, Any]:
    """Schema of one key, without types that TOML lacks, with its description."""
    choices = [item for item in value.pop("anyOf", []) if item != {"type": "null"}]
    if len(choices) == 1:
        value = {**choices[0], **value}
    elif choices:
        value["anyOf"] = choices
    if value.get("default", ...) is None:
        del value["default"]
    inner = value.get("additionalProperties")
    if isinstance(inner, dict):
        # Not a keyword of JSON schema; the constant "law" of each choice has the same effect.
        inner.pop("discriminator", None)
    return {"description": words, **value} if words else value


def _in_other_units(properties: dict[str, Any]) -> dict[str, Any]:
    """Patterns of keys that give the same quantity in another unit, without its limits."""
    found = {}
    for key, value in properties.items():
        pattern = pattern_of_key(key)
        number = value.get("type") == "number"
        if pattern and (number or value.get("type") == "array"):
            numbers = {"type": "number"}
            found[pattern] = numbers if number else {"type": "array", "items": numbers}
    return {"patternProperties": found} if found else {}


def _attributes(kind: type) -> dict[str, str]:
    """Descriptions of the attributes of a table, those of its bases included."""
    found: dict[str, str] = {}
    for base in reversed(kind.__mro__):
        _, _, text = (inspect.getdoc(base) or "").partition("Attributes:\n")
        for match in _ATTRIBUTE.finditer(inspect.cleandoc(text)):
            found[match["name"]] = " ".join(match["text"].split())
    return found
