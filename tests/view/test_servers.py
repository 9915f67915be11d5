"""What a browser gets from the servers of both pages, how they begin and end, what is refused."""

from __future__ import annotations

import asyncio
import http.client
import json
import random
import re
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import AsyncIterator, Callable, Coroutine, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import asynccontextmanager, closing
from io import StringIO
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("tornado", reason="tornado is not installed (extra `live`)")
from tornado.httpclient import HTTPRequest
from tornado.websocket import WebSocketClientConnection, websocket_connect

from nipper_pin.cli import main
from nipper_pin.view.local import is_local
from nipper_pin.view.scene.server import serve

COMMAND = [sys.executable, "-c", "import sys; from nipper_pin.cli import main; sys.exit(main())"]
MODELS = Path(__file__).parents[1] / "verification" / "models"
# What a browser asks a server that it connects to.
CONNECTS = {
    "Connection": "Upgrade", "Upgrade": "websocket", "Sec-WebSocket-Version": "13",
    "Sec-WebSocket-Key": "bmlwcGVyLXBpbiB0ZXN0cw==",
}  # fmt: skip
PAGE = "<!DOCTYPE html>\n<p>\N{GREEK SMALL LETTER PSI}</p>"


class Output(StringIO):
    """A stream that counts how often it is flushed."""

    flushed = 0

    def flush(self) -> None:
        self.flushed += 1


@pytest.fixture
def output() -> Output:
    return Output()


@pytest.fixture
def opened(monkeypatch: pytest.MonkeyPatch, output: Output) -> list[tuple[str, int]]:
    """Addresses that a browser was sent to, and how often stdout was flushed before."""
    found: list[tuple[str, int]] = []
    monkeypatch.setattr(
        "webbrowser.open", lambda address: found.append((address, output.flushed)) or True
    )
    return found


@pytest.fixture
def port() -> int:
    with closing(socket.socket()) as trial:
        trial.bind(("127.0.0.1", 0))
        return int(trial.getsockname()[1])


@pytest.fixture
def beside() -> Iterator[Callable[[Callable[[], Any]], list[Any]]]:
    """Ask a server from beside it, and press Ctrl-C; the answers, or what went wrong."""
    threads: list[threading.Thread] = []
    over = threading.Event()

    def start(ask: Callable[[], Any]) -> list[Any]:
        found: list[Any] = []

        def work() -> None:
            try:
                found.append(ask())
            except Exception as error:
                found.append(error)
            if not over.is_set():
                signal.pthread_kill(threading.main_thread().ident, signal.SIGINT)

        threads.append(threading.Thread(target=work))
        threads[-1].start()
        return found

    yield start
    over.set()
    for thread in threads:
        thread.join()


def get(port: int, path: str, **headers: str) -> tuple[int, dict[str, str], bytes]:
    """Status, headers and body, as soon as the server is there."""
    until = time.monotonic() + 30.0
    while True:
        connection = http.client.HTTPConnection("127.0.0.1", port, timeout=30.0)
        try:
            connection.request("GET", path, headers=headers)
            reply = connection.getresponse()
            return reply.status, dict(reply.getheaders()), reply.read()
        except ConnectionRefusedError:
            if time.monotonic() > until:
                raise
            time.sleep(0.02)
        finally:
            connection.close()


def is_free(port: int) -> bool:
    """Whether a server can take it again."""
    with closing(socket.socket()) as trial:
        trial.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        trial.bind(("127.0.0.1", port))
    return True


@pytest.mark.parametrize("browser", [True, False])
def test_the_page_of_a_scene(
    browser: bool, port: int, output: Output, opened: list[tuple[str, int]], beside: Any,
    monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str],
) -> None:  # fmt: skip
    """At one address, whatever follows a question mark, not to be kept; nothing else is there."""
    paths = ("/", "/?again", "/other")
    asked = ({}, {"Host": "evil.example"}, {"Origin": "http://evil.example"})
    answers = beside(
        lambda: [*(get(port, path) for path in paths), *(get(port, "/", **each) for each in asked)]
    )
    with monkeypatch.context() as patch:
        patch.setattr(sys, "stdout", output)
        serve(PAGE, port, browser=browser)
    assert isinstance(answers[0], list), answers
    first, again, other, *foreign = answers[0]
    assert [reply[0] for reply in foreign] == [200, 403, 403]
    assert all(PAGE.encode() not in reply[2] for reply in foreign[1:])
    assert again[0] == first[0] == 200
    assert again[2] == first[2] == PAGE.encode()
    assert other[0] == 404
    assert PAGE.encode() not in other[2]
    assert first[1]["Content-Type"] == "text/html; charset=utf-8"
    assert first[1]["Content-Length"] == str(len(PAGE.encode()))
    assert first[1]["Cache-Control"] == "no-store"
    address = f"http://127.0.0.1:{port}/"
    assert output.getvalue() == f"the scene is at {address} ; Ctrl-C ends\n\n"
    assert opened == ([(address, 1)] if browser else [])
    # Requests are not reported.
    assert capfd.readouterr().err == ""
    assert is_free(port)


@pytest.mark.parametrize("browser", [True, False])
def test_the_live_page(
    browser: bool, port: int, output: Output, opened: list[tuple[str, int]], beside: Any,
    monkeypatch: pytest.MonkeyPatch,
) -> None:  # fmt: skip
    """Announced, opened if asked, and stopped at the end: the port is free again.

    Its own page connects to it, and none of another site.
    """

    def ask() -> Any:
        """When the address is announced; the server itself is there before."""
        until = time.monotonic() + 60.0
        while not output.getvalue() and time.monotonic() < until:
            time.sleep(0.02)
        origins = f"http://127.0.0.1:{port}", "http://evil.example", "null"
        hosts = {}, {"Host": "evil.example"}, {"Origin": "http://evil.example"}
        return (
            [get(port, "/", **each) for each in hosts],
            [get(port, "/talk", **CONNECTS, Origin=each)[0] for each in origins],
        )

    answers = beside(ask)
    with monkeypatch.context() as patch:
        patch.setattr(sys, "stdout", output)
        words = ["live", "e62", "--speed", "432", "--port", str(port)]
        assert main([*words, *([] if browser else ["--no-browser"])]) == 0
    ((pages, connected),) = answers
    assert connected == [101, 403, 403]
    assert [reply[0] for reply in pages] == [200, 403, 403]
    assert [b"/talk" in reply[2] for reply in pages] == [True, False, False]
    assert pages[0][1]["X-Frame-Options"] == "DENY"
    address = f"http://127.0.0.1:{port}/"
    assert output.getvalue() == f"the page is at {address} ; Ctrl-C ends\n\n"
    assert [item for item, _ in opened] == ([address] if browser else [])
    assert output.flushed >= 1
    assert is_free(port)


@pytest.mark.parametrize("port", ["70000", "-1", "taken"])
@pytest.mark.parametrize("command", ["view", "live"])
def test_a_port_that_cannot_be_used_is_one_sentence(
    command: str, port: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        place = str(taken.getsockname()[1]) if port == "taken" else port
        assert main([command, "--no-browser", "--port", place]) == 2
    out, err = capsys.readouterr()
    assert (out, err.count("\n")) == ("", 1)
    assert f"port {place} cannot be used" in err


@pytest.mark.parametrize("words", [
    ["view"], *(pytest.param(words, marks=pytest.mark.slow)
                for words in (["live"], ["live", str(MODELS / "bouncing_mass")])),
])  # fmt: skip
def test_a_server_ends_on_interrupt_and_says_nothing_but_its_address(words: list[str]) -> None:
    command = [*COMMAND, *words, "--port", "0", "--no-browser"]
    with subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as server:
        assert server.stdout is not None
        assert server.stderr is not None
        first = server.stdout.readline()
        said = r"the (scene|page) is at http://127\.0\.0\.1:\d+/ ; Ctrl-C ends\n"
        assert re.fullmatch(said, first)
        server.send_signal(signal.SIGINT)
        assert server.wait(timeout=60) == 0
        assert server.stdout.read().strip() == ""
        assert server.stderr.read() == ""


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
    command = [*COMMAND, "live", "e62", "--port", "0", "--no-browser"]
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


def finished(task: Coroutine[Any, Any, None]) -> None:
    """Run a task in a thread of its own: beside a browser a loop runs in this one."""
    with ThreadPoolExecutor(1) as pool:
        pool.submit(asyncio.run, asyncio.wait_for(task, 60.0)).result()


@asynccontextmanager
async def talking(port: int) -> AsyncIterator[WebSocketClientConnection]:
    """A page of the server, as its own browsers open it."""
    origin = {"Origin": f"http://127.0.0.1:{port}"}
    page = await websocket_connect(HTTPRequest(f"ws://127.0.0.1:{port}/talk", headers=origin))
    yield page
    page.close()
    while page.close_code is None and await page.read_message() is not None:
        pass


async def asked(port: int, speed: float) -> None:
    """Open a page, move its first slider and read the numbers, then the film."""
    async with talking(port) as page:
        await page.read_message()
        await page.write_message(json.dumps({"kind": "slid", "key": "speed", "value": speed}))
        state = json.loads(await page.read_message() or "")["state"]
        assert state["setting"].startswith(f"speed {speed:g} r/min")
        assert [row[0] for row in state["rows"]][:2] == ["amplitude", "rebound"]
        found = json.loads(await page.read_message() or "")
        while "film" not in found:
            found = json.loads(await page.read_message() or "")
        assert found["film"]["case"].startswith(f"{speed:g} r/min")


def random_message(rng: random.Random) -> bytes | str:
    """Something that a page may send, or should not, or cannot be read at all."""
    values = [0, -1e9, 1e300, 450, "x", None, [], {}, True, 2**70]
    fields = ("kind", "key", "value", "text", "button", "min", "__class__")
    kinds = ("slid", "typed", "pressed", "speed", "reset", "pin", "larger", "nothing")
    made = {rng.choice(fields): rng.choice([*values, *kinds]) for _ in range(rng.randrange(1, 4))}
    slid = {"kind": "slid", "key": rng.choice(["speed", "larger"]), "value": rng.choice(values)}
    texts = [json.dumps(made), *[json.dumps(slid)] * 2, "text", "[" * 4000]
    return rng.choice([rng.randbytes(rng.randrange(200)), *texts])


@pytest.mark.slow
def test_a_message_has_a_largest_size(served: tuple[int, subprocess.Popen[str]]) -> None:
    """A longer one ends its own connection, before it is read."""
    port, process = served

    async def sent(size: int) -> int | None:
        async with talking(port) as page:
            await page.read_message()
            await page.write_message(b" " * size)
            await page.write_message(json.dumps({"kind": "pressed", "button": "fit"}))
            answered = await page.read_message()
            return page.close_code if answered is None else 0

    async def both() -> None:
        assert await sent(4096) == 0
        assert await sent(4097) == 1009

    finished(both())
    assert process.poll() is None


@pytest.mark.slow
def test_an_attacked_page_goes_on_for_others(served: tuple[int, subprocess.Popen[str]]) -> None:
    """A thousand random messages by one browser; others move a slider and read the answer."""
    port, process = served
    rng = random.Random(7)

    async def attack() -> None:
        async with talking(port) as page:
            for _ in range(1000):
                message = random_message(rng)
                await page.write_message(message, binary=isinstance(message, bytes))
                await asyncio.sleep(0.002)

    async def both() -> None:
        attacker = asyncio.create_task(attack())
        await asked(port, 520.0)
        await attacker
        await asked(port, 444.0)

    finished(both())
    assert process.poll() is None
