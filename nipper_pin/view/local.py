"""Requests that a server on this machine answers: those of its own pages."""

from __future__ import annotations

from urllib.parse import urlsplit

HOST = "127.0.0.1"
_NAMES = (HOST, "localhost")


def is_local(host: str | None, origin: str | None, port: int) -> bool:
    """Return whether a request comes from a page of this server, or from no page.

    Args:
        host: Its header Host.
        origin: Its header Origin; None for a program, and where a page is asked for by its address.
        port: Port of the server.
    """
    if host not in {f"{name}:{port}" for name in _NAMES}:
        return False
    if origin is None:
        return True
    parts = urlsplit(origin)
    return parts.scheme == "http" and parts.netloc == host and not parts.path
