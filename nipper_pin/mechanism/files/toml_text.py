"""Reading of TOML text, whatever is wrong with it."""

from __future__ import annotations

from ...errors import ModelError


def read_toml(text: str, file: str) -> dict[str, object]:
    """Return a TOML document as plain data.

    Args:
        text: The text.
        file: Name of its file, for messages.

    Raises:
        ModelError: It is no well-formed TOML, nests too deeply or has a number that is too long.
    """
    import tomllib

    try:
        return tomllib.loads(text)
    except (ValueError, RecursionError) as error:
        allowed = "a well-formed TOML document"
        raise ModelError(file=file, key="TOML", value=str(error), allowed=allowed) from error
