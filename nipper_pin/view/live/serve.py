"""Serves the page at one port until Ctrl-C."""

from __future__ import annotations

import io
import os
import socket
import sys
import webbrowser
from contextlib import redirect_stdout

import viser

from ...errors import InputError
from ...mechanism import Mechanism
from ..local import HOST
from .guard import only_local
from .page import Page
from .settings import knobs


def serve_live(mechanism: Mechanism, speed_rpm: float, port: int, *, browser: bool) -> None:
    """Serve the page until Ctrl-C, and say where on stdout.

    Args:
        mechanism: The mechanism; its values are where the sliders start.
        speed_rpm: Speed at which the slider starts [r/min].
        port: Port of this machine; 0 for any that is free.
        browser: Whether to open the page in the user's browser.

    Raises:
        InputError: The port cannot be used, or the mechanism has no transition.
    """
    controls = knobs(mechanism, speed_rpm)
    server = _server(port)
    try:
        page = Page(server, mechanism, controls)
        address = f"http://{HOST}:{server.get_port()}/"
        sys.stdout.write(f"the page is at {address} ; Ctrl-C ends\n")
        sys.stdout.flush()
        if browser:
            webbrowser.open(address)
        page.turns.start()
        page.run()
    except KeyboardInterrupt:
        sys.stdout.write("\n")
    finally:
        with redirect_stdout(io.StringIO()):
            server.stop()


def _server(port: int) -> viser.ViserServer:
    """The server at a port, and at no other.

    Raises:
        InputError: The port cannot be used.
    """
    problem: object = "another program holds it"
    try:
        # viser takes the next port in silence when one is taken, so it is tried out before.
        with socket.socket() as trial:
            if os.name == "posix":
                trial.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            trial.bind((HOST, port))
    except (OSError, OverflowError) as error:
        problem = getattr(error, "strerror", None) or error
    else:
        # viser announces itself on stdout, which belongs to the command.
        with redirect_stdout(io.StringIO()), only_local():
            server = viser.ViserServer(host=HOST, port=port, verbose=False)
        if port in (0, server.get_port()):
            return server
        with redirect_stdout(io.StringIO()):
            server.stop()
    message = (
        f"port {port} cannot be used ({problem}): another program may hold it; name another one, "
        "or --port 0 for any that is free"
    )
    raise InputError(message, port=port)
