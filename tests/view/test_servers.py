"""What a browser gets from the servers of both pages, how they begin and end, what is refused."""

from __future__ import annotations

import asyncio
import http.client
import json
import random
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import AsyncIterator, Callable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import asynccontextmanager, closing, contextmanager
from io import StringIO
from typing import Any

import pytest

pytest.importorskip("tornado", reason="tornado is not installed (extra `live`)")
from tornado.httpclient import HTTPRequest
from tornado.websocket import WebSocketClientConnection, websocket_connect

from nipper_pin.cli import main
from nipper_pin.mechanism.gallery import GALLERY
from nipper_pin.view.local import is_local

# What a browser asks a server that it connects to.
CONNECTS = {
    "Connection": "Upgrade", "Upgrade": "websocket", "Sec-WebSocket-Version": "13",
    "Sec-WebSocket-Key": "bmlwcGVyLXBpbiB0ZXN0cw==",
}  # fmt: skip
EVIL = "http://evil.example"


class Output(StringIO):
    """A stream that counts how often it is flushed."""

    flushed = 0

    def flush(self) -> None:
        self.flushed += 1


@contextmanager
def beside(ask: Callable[[], Any]) -> Iterator[Future[Any]]:
    """Ask a server from beside it, and press Ctrl-C."""
    over = threading.Event()

    def work() -> Any:
        try:
            return ask()
        finally:
            if not over.is_set():
                signal.pthread_kill(threading.main_thread().ident, signal.SIGINT)

    with ThreadPoolExecutor(1) as pool:
        yield pool.submit(work)
        over.set()


def get(port: int, path: str, **headers: str) -> tuple[int, dict[str, str], bytes]:
    """Status, headers and body."""
    with closing(http.client.HTTPConnection("127.0.0.1", port, timeout=30.0)) as connection:
        connection.request("GET", path, headers=headers)
        reply = connection.getresponse()
        return reply.status, dict(reply.getheaders()), reply.read()


@pytest.mark.parametrize("browser", [True, False])
@pytest.mark.parametrize(("command", "what"), [("view", "scene"), ("live", "page")])
def test_a_page_and_its_server(
    command: str, what: str, browser: bool,
    monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str],
) -> None:  # fmt: skip
    """At one address, whatever follows a question mark, not to be kept, for this machine alone.

    It is announced, opened if asked, and stopped at the end, when the port is free again. Requests
    are not reported; the live page's own may connect, and none of another site.
    """
    output, opened = Output(), list[tuple[str, int]]()

    def ask() -> tuple[Any, ...]:
        until = time.monotonic() + 60.0
        while not output.flushed and time.monotonic() < until:
            time.sleep(0.02)
        port = int(output.getvalue().partition("127.0.0.1:")[2].partition("/")[0])
        pages = [get(port, path) for path in ("/", "/?again", "/other")]
        foreign = [get(port, "/", **each) for each in ({"Host": EVIL[7:]}, {"Origin": EVIL})]
        origins = f"http://127.0.0.1:{port}", EVIL, "null"
        talks = [get(port, "/talk", **CONNECTS, Origin=each)[0] for each in origins]
        return port, pages, foreign, talks

    with monkeypatch.context() as patch, beside(ask) as answers:
        patch.setattr(sys, "stdout", output)
        patch.setattr(
            "webbrowser.open", lambda address: opened.append((address, output.flushed)) or True
        )
        words = [command, "e62", "--speed", "432", "--port", "0"]
        assert main([*words, *([] if browser else ["--no-browser"])]) == 0
    port, (first, again, other), foreign, talks = answers.result()
    assert (first[0], again[0], other[0]) == (200, 200, 404)
    assert again[2] == first[2]
    assert first[2].startswith(b"<!DOCTYPE html>")
    assert all(b'id="film"' in reply[2] for reply in (first, again))
    assert not any(b'id="film"' in reply[2] for reply in (other, *foreign))
    assert [reply[0] for reply in foreign] == [403, 403]
    assert talks == ([101, 403, 403] if command == "live" else [404, 403, 403])
    assert first[1].items() >= {
        "Content-Type": "text/html; charset=utf-8", "Content-Length": str(len(first[2])),
        "Cache-Control": "no-store", "X-Frame-Options": "DENY",
    }.items()  # fmt: skip
    address = f"http://127.0.0.1:{port}/"
    assert output.getvalue() == f"the {what} is at {address} ; Ctrl-C ends\n\n"
    assert opened == ([(address, 1)] if browser else [])
    assert capfd.readouterr().err == ""
    with closing(socket.socket()) as trial:
        trial.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        trial.bind(("127.0.0.1", port))


@pytest.mark.parametrize("port", ["70000", "-1", "taken"])
@pytest.mark.parametrize(
    "command", ["view", "view --solution none.npz", "live", f"live {GALLERY['sieve']}"]
)
def test_a_port_that_cannot_be_used_is_one_sentence(
    command: str, port: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """Before anything is computed, which a missing run and a machine without transition show."""
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        place = str(taken.getsockname()[1]) if port == "taken" else port
        assert main([*command.split(), "--no-browser", "--port", place]) == 2
    out, err = capsys.readouterr()
    assert (out, err.count("\n")) == ("", 1)
    assert f"port {place} cannot be used" in err


# Whoever talks to the live page.


@pytest.mark.parametrize(("host", "origin", "local"), [
    ("127.0.0.1:7001", None, True), ("localhost:7001", None, True),
    ("127.0.0.1:7001", "http://127.0.0.1:7001", True),
    ("localhost:7001", "http://localhost:7001", True),
    ("127.0.0.1:7002", None, False), ("127.0.0.1", None, False), (None, None, False),
    ("evil.example:7001", None, False), ("evil.example:7001", "http://evil.example:7001", False),
    ("127.0.0.1:7001", "http://evil.example", False), ("127.0.0.1:7001", "null", False),
    ("127.0.0.1:7001", "https://127.0.0.1:7001", False), ("127.0.0.1:7001", "", False),
    ("127.0.0.1:7001", "http://127.0.0.1:7001.evil.example", False),
    ("127.0.0.1:7001", "http://localhost:7001", False),
    ("127.0.0.1:7001", "http://127.0.0.1:8080", False),
    # Of two headers of one name a server reads both.
    ("127.0.0.1:7001,evil.example", None, False),
    ("127.0.0.1:7001", "http://127.0.0.1:7001,http://evil.example", False),
])  # fmt: skip
def test_requests_of_this_page_are_told_from_others(
    host: str | None, origin: str | None, local: bool
) -> None:
    """A page of another program on this machine is another origin; so is a name of elsewhere."""
    assert is_local(host, origin, 7001) is local


@pytest.fixture(scope="module")
def served() -> Iterator[tuple[int, subprocess.Popen[str]]]:
    """A live page as the command serves it, which says nothing whatever it is sent."""
    program = "import sys; from nipper_pin.cli import main; sys.exit(main())"
    command = [sys.executable, "-c", program, "live", "e62", "--port", "0", "--no-browser"]
    with subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as process:
        assert process.stdout is not None
        line = process.stdout.readline()
        yield int(line.partition("127.0.0.1:")[2].partition("/")[0]), process
        process.send_signal(signal.SIGINT)
        assert process.wait(timeout=60) == 0
        assert process.stderr is not None
        assert process.stderr.read() == ""


@asynccontextmanager
async def talking(port: int) -> AsyncIterator[WebSocketClientConnection]:
    """A page of the server, as its own browsers open it."""
    origin = {"Origin": f"http://127.0.0.1:{port}"}
    page = await websocket_connect(HTTPRequest(f"ws://127.0.0.1:{port}/talk", headers=origin))
    yield page
    page.close()
    while page.close_code is None and await page.read_message() is not None:
        pass


@pytest.mark.slow
def test_an_attacked_page_goes_on_for_others(served: tuple[int, subprocess.Popen[str]]) -> None:
    """One browser sends bytes that are no messages, and ends itself by one that is too long.

    Others move a slider and read the numbers, then the film.
    """
    port, process = served

    async def attack() -> None:
        async with talking(port) as page:
            for size in range(200):
                await page.write_message(random.Random(size).randbytes(size), binary=True)
                await asyncio.sleep(0.002)
            await page.write_message(b" " * 4096)
            assert page.close_code is None
            await page.write_message(json.dumps({"kind": "pressed", "button": "pin"}))
            while not json.loads(await page.read_message() or "")["state"]["pinned"]:
                pass
            await page.write_message(b" " * 4097)
            while await page.read_message() is not None:
                pass
            assert page.close_code == 1009

    async def asked(speed: float) -> None:
        async with talking(port) as page:
            await page.read_message()
            await page.write_message(json.dumps({"kind": "slid", "key": "speed", "value": speed}))
            found = json.loads(await page.read_message() or "")
            while not found["state"]["setting"].startswith(f"speed {speed:g} r/min"):
                found = json.loads(await page.read_message() or "")
            assert [row[0] for row in found["state"]["rows"]][:2] == ["amplitude", "lips"]
            while "film" not in found:
                found = json.loads(await page.read_message() or "")
            assert found["film"]["case"].startswith(f"{speed:g} r/min")

    async def both() -> None:
        attacker = asyncio.create_task(attack())
        await asked(520.0)
        await attacker
        await asked(444.0)

    # In a thread of its own: beside a browser a loop runs in this one.
    with ThreadPoolExecutor(1) as pool:
        pool.submit(asyncio.run, asyncio.wait_for(both(), 60.0)).result()
    assert process.poll() is None
