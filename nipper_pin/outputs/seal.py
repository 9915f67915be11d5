"""JSON documents that show whether they are as they were written."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from typing import Any

SEAL = "sha256"
"""Key of the digest."""


def sealed(document: Mapping[str, Any]) -> dict[str, Any]:
    """A document with the digest of all else that it holds.

    Args:
        document: Plain data for JSON.
    """
    return {**document, SEAL: _digest(document)}


def is_as_written(document: Mapping[str, Any]) -> bool | None:
    """Return whether a document that was read is as it was written; None if it has no digest.

    Args:
        document: The document.
    """
    return document[SEAL] == _digest(document) if SEAL in document else None


def _digest(document: Mapping[str, Any]) -> str:
    # Through JSON once more: keys become text and tuples lists, as they are when they are read.
    plain = json.loads(json.dumps({key: document[key] for key in document if key != SEAL}))
    text = json.dumps(plain, sort_keys=True, separators=(",", ":"))
    return hashlib.sha256(text.encode()).hexdigest()
