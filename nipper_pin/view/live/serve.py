"""Serves the page at one port until Ctrl-C, and answers each browser over a WebSocket.

A page of another site that the same browser shows may try to connect to a server on this machine.
Browsers say from where a page comes (Origin) and under which name it asks (Host): both have to be
the address of this server.
"""

from __future__ import annotations

import asyncio
import json
import logging
import signal
import socket
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress

from tornado.httpserver import HTTPServer
from tornado.web import Application, RequestHandler
from tornado.websocket import WebSocketClosedError, WebSocketHandler

from ...mechanism import Mechanism
from ..local import HEADERS, announce, is_local, listening
from .session import Session, Shown, shown_live

# A browser sends the value of a control.
_MOST_BYTES = 4 * 1024
# Seconds without a move until the film is made: it would only delay the numbers of the next one.
_QUIET = 0.25


def serve_live(mechanism: Mechanism, speed_rpm: float, port: int, *, browser: bool) -> None:
    """Serve the page until Ctrl-C, and say where on stdout; arguments as of `serve`.

    Args:
        speed_rpm: Speed at which the slider starts [r/min].

    Raises:
        InputError: The port cannot be used, or the mechanism has no transition.
    """
    # A port that cannot be used is told before anything is computed.
    with listening(port) as place:
        shown, page = shown_live(mechanism, speed_rpm)
        # Who asks for what is nobody's concern; errors of the program itself are written.
        for name in ("tornado.access", "tornado.general"):
            logging.getLogger(name).addHandler(logging.NullHandler())
        place.setblocking(False)
        asyncio.run(_serve(shown, page.encode(), place, browser=browser))
    sys.stdout.write("\n")


async def _serve(shown: Shown, page: bytes, place: socket.socket, *, browser: bool) -> None:
    loop, talks = asyncio.get_running_loop(), set[_Talk]()
    port = place.getsockname()[1]
    application = Application(
        [("/", _Page, {"port": port, "page": page}),
         ("/talk", _Talk, {"port": port, "shown": shown, "talks": talks})],
        websocket_max_message_size=_MOST_BYTES,
    )  # fmt: skip

    def turned() -> None:
        for talk in tuple(talks):
            talk.turned()

    def made() -> None:
        # The page may have ended before its tables are there.
        with suppress(RuntimeError):
            loop.call_soon_threadsafe(turned)

    server = HTTPServer(application)
    server.add_socket(place)
    with _interrupted(loop) as over:
        announce("page", port, browser=browser)
        shown.turns.start(made)
        await over.wait()
    server.stop()


@contextmanager
def _interrupted(loop: asyncio.AbstractEventLoop) -> Iterator[asyncio.Event]:
    """Tells of an interrupt, which elsewhere is raised in the middle of whatever is being done."""
    over, before = asyncio.Event(), signal.getsignal(signal.SIGINT)
    if before is not signal.SIG_IGN:
        loop.add_signal_handler(signal.SIGINT, over.set)
    try:
        yield over
    finally:
        loop.remove_signal_handler(signal.SIGINT)
        signal.signal(signal.SIGINT, before)


def _guard(asked: RequestHandler, port: int) -> None:
    """Refuse what does not come from a page of this server."""
    told = asked.request.headers
    if not is_local(told.get("Host"), told.get("Origin"), port):
        asked.send_error(403)


class _Page(RequestHandler):
    """Sends the page, to requests of this machine alone."""

    def initialize(self, port: int, page: bytes) -> None:
        self._port, self._content = port, page

    def prepare(self) -> None:
        _guard(self, self._port)

    def get(self) -> None:
        for name, value in HEADERS.items():
            self.set_header(name, value)
        self.write(self._content)


class _Talk(WebSocketHandler):
    """Answers one browser."""

    def initialize(self, port: int, shown: Shown, talks: set[_Talk]) -> None:
        self._port, self._shown, self._talks = port, shown, talks
        self._later: asyncio.TimerHandle | None = None

    def prepare(self) -> None:
        _guard(self, self._port)

    def open(self) -> None:
        self._session = Session(self._shown)
        self._talks.add(self)
        self._say({"state": self._session.state()})

    def on_message(self, message: str | bytes) -> None:
        if not self._session.take(message):
            return
        self._say({"state": self._session.state()})
        if self._later is not None:
            self._later.cancel()
        self._later = asyncio.get_running_loop().call_later(_QUIET, self._film)

    def on_close(self) -> None:
        self._talks.discard(self)
        if self._later is not None:
            self._later.cancel()

    def turned(self) -> None:
        """Whole turns can be followed from now on."""
        self._session.turned()
        self._say({"state": self._session.state()})

    def _film(self) -> None:
        found = self._session.film()
        if found is not None:
            self._say(found)

    def _say(self, found: dict[str, object]) -> None:
        with suppress(WebSocketClosedError):
            self.write_message(json.dumps(found, allow_nan=False))
