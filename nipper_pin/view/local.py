"""Serves one page to browsers on this machine, and what the server of the live page shares with it.

That is where they listen, and which requests they answer.
"""

from __future__ import annotations

import os
import socket
import sys
import webbrowser
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
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
        message = (
            f"port {port} cannot be used ({getattr(error, 'strerror', None) or error}): "
            "another program may hold it; name another one, or --port 0 for any that is free"
        )
        raise InputError(message, port=port) from error
    return place


def announce(what: str, port: int, *, browser: bool) -> None:
    """Say on stdout where something is served, and open it in the user's browser if asked."""
    address = f"http://{HOST}:{port}/"
    sys.stdout.write(f"the {what} is at {address} ; Ctrl-C ends\n")
    sys.stdout.flush()
    if browser:
        webbrowser.open(address)


def serve(page: str, port: int, *, browser: bool) -> None:
    """Serve a page until Ctrl-C, and say where on stdout; at port 0 of any that is free.

    Raises:
        InputError: The port cannot be used.
    """
    place = listening(port)
    address = place.getsockname()

    class Handler(_Handler):
        body, port = page.encode(), address[1]

    with ThreadingHTTPServer(address, Handler, bind_and_activate=False) as server:
        server.socket.close()
        server.socket = place
        try:
            announce("scene", Handler.port, browser=browser)
            server.serve_forever(poll_interval=0.1)
        except KeyboardInterrupt:
            sys.stdout.write("\n")


class _Handler(BaseHTTPRequestHandler):
    body: bytes
    port: int

    def do_GET(self) -> None:
        """Send the page."""
        if not is_local(self.headers["Host"], self.headers["Origin"], self.port):
            self.send_error(403)
            return
        if self.path.partition("?")[0] != "/":
            self.send_error(404)
            return
        self.send_response(200)
        for name, value in HEADERS.items():
            self.send_header(name, value)
        self.send_header("Content-Length", str(len(self.body)))
        self.end_headers()
        self.wfile.write(self.body)

    def log_message(self, format: str, *args: object) -> None:  # noqa: A002
        """Say nothing about every request."""
