"""Who may talk to the live page, and about what.

A page of another site that the same browser shows may try to connect to a server on this machine.
Browsers say from where a page comes (Origin) and under which name it asks (Host): both have to be
the address of this server. Messages of other kinds than the page sends are dropped, and values are
brought into the range of their control.
"""

from __future__ import annotations

import math
from collections.abc import Awaitable, Callable, Iterator, Mapping
from contextlib import contextmanager
from http import HTTPStatus
from types import MappingProxyType
from typing import Annotated, Any

import msgspec
import viser
from msgspec import Meta
from viser import _messages
from websockets.asyncio import server as sockets

from ..local import is_local
from .panel.fields import LONGEST

_REFUSED = "this page is for browsers on this machine, at the address that was printed\n"
# A browser sends the value of a control, or where its camera stands.
_MOST_BYTES = 64 * 1024
# viser makes arrays of the numbers of a camera, and does not check them.
_Number = Annotated[float, Meta(ge=-1e30, le=1e30)]
_Point = tuple[_Number, _Number, _Number]


class _Message(msgspec.Struct, frozen=True, forbid_unknown_fields=True, tag_field="type"):
    """A message, with the fields of viser's class of that name."""


class _Camera(_Message, frozen=True, tag="ViewerCameraMessage"):
    """Where the camera stands."""

    wxyz: tuple[_Number, _Number, _Number, _Number]
    position: _Point
    fov: _Number
    near: _Number
    far: _Number
    image_height: _Number
    image_width: _Number
    look_at: _Point
    up_direction: _Point


class _Update(_Message, frozen=True, tag="GuiUpdateMessage"):
    """A value of a control, which :class:`Filter` checks."""

    uuid: str
    updates: dict[str, Any]


_MESSAGE = msgspec.msgpack.Decoder(_Camera | _Update)
"""All that a page sends."""


@contextmanager
def only_local() -> Iterator[None]:
    """Servers that start in this block refuse requests that are not local."""
    serve = sockets.serve

    def guarded(
        handler: Callable[[Any], Awaitable[None]],
        *place: Any,
        process_request: Callable[..., Any],
        **options: Any,
    ) -> Any:
        def admitted(connection: Any, request: Any) -> Any:
            port, headers = connection.local_address[1], request.headers
            hosts, origins = headers.get_all("Host"), headers.get_all("Origin")
            told = (hosts or [None])[0], (origins or [None])[0]
            if len(hosts) > 1 or len(origins) > 1 or not is_local(*told, port):
                return connection.respond(HTTPStatus.FORBIDDEN, _REFUSED)
            return process_request(connection, request)

        async def handled(connection: Any) -> None:
            connection.recv = _readable(connection.recv)
            await handler(connection)

        options["max_size"] = _MOST_BYTES
        return serve(handled, *place, process_request=admitted, **options)

    sockets.serve = guarded  # type: ignore[assignment, misc]
    try:
        yield
    finally:
        sockets.serve = serve  # type: ignore[misc]


def _readable(receive: Callable[[], Awaitable[bytes | str]]) -> Callable[[], Awaitable[bytes]]:
    """Receive as before, without messages that are unreadable or of no kind that a page sends."""

    async def recv() -> bytes:
        while True:
            raw = await receive()
            if isinstance(raw, bytes) and _taken(raw):
                return raw

    return recv


def _taken(raw: bytes) -> bool:
    try:
        _MESSAGE.decode(raw)
    except (msgspec.MsgspecError, UnicodeDecodeError, RecursionError):
        return False
    return True


class Filter:
    """Takes from browsers nothing but values of controls, each within its range.

    Args:
        server: The server, with all its controls.
        ranges: Lowest and highest value of each slider, by its identity in viser.
        switches: Identities of the check boxes.
        fields: Identities of the fields of text, of which no more than a line is read.
        choices: What each group of buttons offers, by its identity.
    """

    def __init__(
        self,
        server: viser.ViserServer,
        ranges: Mapping[str, tuple[float, float]],
        switches: frozenset[str],
        fields: frozenset[str] = frozenset(),
        choices: Mapping[str, frozenset[str]] = MappingProxyType({}),
    ) -> None:
        """Take the place of viser's own handlers."""
        self._ranges, self._switches = ranges, switches
        self._fields, self._choices = fields, choices
        interface = server.gui._websock_interface
        (self._apply,) = interface._incoming_handlers[_messages.GuiUpdateMessage]
        interface.unregister_handler(_messages.GuiUpdateMessage)
        interface.register_handler(_messages.GuiUpdateMessage, self._update)

    async def _update(self, client: Any, message: _messages.GuiUpdateMessage) -> None:
        """Apply a value that is one of its control; drop all else."""
        value = self.allowed(message.uuid, message.updates)
        if value is not None:
            done = self._apply(client, _messages.GuiUpdateMessage(message.uuid, {"value": value}))
            if done is not None:
                await done

    def allowed(self, control: object, updates: object) -> float | bool | str | None:
        """Return the value of a control that an update asks for, in its range; None if none.

        Args:
            control: Identity of the control.
            updates: What is to be changed.
        """
        if not isinstance(control, str) or not isinstance(updates, Mapping):
            return None
        if set(updates) != {"value"}:
            return None
        value = updates["value"]
        if control in self._switches:
            return value if isinstance(value, bool) else None
        if control in self._fields:
            return value[:LONGEST] if isinstance(value, str) else None
        if control in self._choices:
            known = isinstance(value, str) and value in self._choices[control]
            return value if known else None
        if control not in self._ranges or isinstance(value, bool):
            return None
        if not isinstance(value, int | float) or not math.isfinite(value):
            return None
        low, high = self._ranges[control]
        return min(max(float(value), low), high)
