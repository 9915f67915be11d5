"""Serves one page to browsers on this machine until it is interrupted."""

from __future__ import annotations

import os
import sys
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer

from ..local import HEADERS, HOST, announce, is_local, refused_port


def serve(page: str, port: int, *, browser: bool) -> None:
    """Serve a page until Ctrl-C, and say where on stdout.

    Args:
        page: The HTML.
        port: Port of this machine; 0 for any that is free.
        browser: Whether to open the page in the user's browser.

    Raises:
        InputError: The port cannot be used.
    """
    content = page.encode()

    class Handler(_Handler):
        body = content

    try:
        server = _Server((HOST, port), Handler)
    except (OSError, OverflowError) as error:
        raise refused_port(port, error) from error
    with server:
        try:
            announce("scene", server.server_port, browser=browser)
            server.serve_forever(poll_interval=0.1)
        except KeyboardInterrupt:
            sys.stdout.write("\n")


class _Server(ThreadingHTTPServer):
    daemon_threads = True
    # Elsewhere than on Unix this would let two servers share a port.
    allow_reuse_address = os.name == "posix"


class _Handler(BaseHTTPRequestHandler):
    body: bytes
    server: _Server

    def do_GET(self) -> None:
        """Send the page."""
        if not is_local(self.headers["Host"], self.headers["Origin"], self.server.server_port):
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
