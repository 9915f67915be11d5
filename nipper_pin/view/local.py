"""What both servers have in common: where they listen, and which requests they answer."""

from __future__ import annotations

import os
import socket
import sys
import webbrowser
from urllib.parse import urlsplit

from ..errors import InputError

HOST = "127.0.0.1"
_NAMES = (HOST, "localhost")
# Nothing is loaded from anywhere, and no other page may show this one.
HEADERS = {
    "Content-Type": "text/html; charset=utf-8",
    "Cache-Control": "no-store",
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "DENY",
    "Cross-Origin-Resource-Policy": "same-origin",
}
"""Of each page."""


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


def listening(port: int) -> socket.socket:
    """A socket that listens at a port of this machine; 0 for any that is free.

    Raises:
        InputError: The port cannot be used.
    """
    place = socket.socket()
    try:
        if os.name == "posix":
            place.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        place.bind((HOST, port))
        place.listen()
    except (OSError, OverflowError) as error:
        place.close()
        raise refused_port(port, error) from error
    return place


def refused_port(port: int, error: Exception) -> InputError:
    """The error that says why a port cannot be served at."""
    message = (
        f"port {port} cannot be used ({getattr(error, 'strerror', None) or error}): "
        "another program may hold it; name another one, or --port 0 for any that is free"
    )
    return InputError(message, port=port)


def announce(what: str, port: int, *, browser: bool) -> None:
    """Say on stdout where something is served, and open it in the user's browser if asked."""
    address = f"http://{HOST}:{port}/"
    sys.stdout.write(f"the {what} is at {address} ; Ctrl-C ends\n")
    sys.stdout.flush()
    if browser:
        webbrowser.open(address)
