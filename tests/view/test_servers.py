"""What a browser gets from the servers of both pages, how they begin and end, what is refused."""

from __future__ import annotations

import _thread
import http.client
import re
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import closing
from io import StringIO
from pathlib import Path
from typing import Any

import pytest

from nipper_pin.cli import main
from nipper_pin.view.scene.server import serve

COMMAND = [sys.executable, "-c", "import sys; from nipper_pin.cli import main; sys.exit(main())"]
MODELS = Path(__file__).parents[1] / "verification" / "models"
WHY = "viser is not installed (extra `live`): the page cannot be built"
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
                _thread.interrupt_main()

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
    viser = pytest.importorskip("viser", reason=WHY)
    connects = {**CONNECTS, "Sec-WebSocket-Protocol": f"viser-v{viser.__version__}"}

    def ask() -> Any:
        """When the address is announced; the server itself is there before."""
        until = time.monotonic() + 60.0
        while not output.getvalue() and time.monotonic() < until:
            time.sleep(0.02)
        origins = f"http://127.0.0.1:{port}", "http://evil.example", "null"
        return get(port, "/"), *(get(port, "/", **connects, Origin=each)[0] for each in origins)

    answers = beside(ask)
    with monkeypatch.context() as patch:
        patch.setattr(sys, "stdout", output)
        words = ["live", "e62", "--speed", "432", "--port", str(port)]
        assert main([*words, *([] if browser else ["--no-browser"])]) == 0
    (((status, _, content), *connected),) = answers
    assert (status, connected) == (200, [101, 403, 403])
    assert b"viser" in content.lower()
    address = f"http://127.0.0.1:{port}/"
    assert output.getvalue() == f"the page is at {address} ; Ctrl-C ends\n\n"
    assert [item for item, _ in opened] == ([address] if browser else [])
    assert output.flushed >= 1
    assert is_free(port)


def test_another_port_than_the_one_that_is_named_is_refused(
    port: int, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Where somebody takes it in between, viser goes to the next one; its server is ended."""
    viser = pytest.importorskip("viser", reason=WHY)
    real, made = viser.ViserServer, []

    def elsewhere(**given: Any) -> Any:
        made.append(real(**{**given, "port": 0}))
        return made[-1]

    monkeypatch.setattr("viser.ViserServer", elsewhere)
    monkeypatch.setattr("nipper_pin.view.live.page.Page.run", lambda _: pytest.fail("it serves"))
    assert main(["live", "--no-browser", "--port", str(port)]) == 2
    out, err = capsys.readouterr()
    assert (out, err.count("\n")) == ("", 1)
    assert f"port {port} cannot be used (another" in err
    with pytest.raises(ConnectionRefusedError), socket.socket() as trial:
        trial.connect(("127.0.0.1", made[0].get_port()))


@pytest.mark.parametrize("port", ["70000", "-1", "taken"])
@pytest.mark.parametrize("command", ["view", "live"])
def test_a_port_that_cannot_be_used_is_one_sentence(
    command: str, port: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """viser itself would take the next free port, where nobody looks."""
    pytest.importorskip("viser", reason=WHY)
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
    pytest.importorskip("viser", reason=WHY)
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
