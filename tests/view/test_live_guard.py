"""The live page takes values of its controls from its own pages, and nothing else from anybody."""

from __future__ import annotations

import asyncio
import contextlib
import math
import random
import struct
import subprocess
import sys
from collections.abc import Coroutine, Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any, TypeVar

import msgspec
import pytest

pytest.importorskip("viser", reason="viser is not installed (extra `live`)")

import viser
import zstandard
from websockets.asyncio.client import connect
from websockets.exceptions import WebSocketException

from nipper_pin.view.live.guard import Filter
from nipper_pin.view.local import is_local

T = TypeVar("T")
CAMERA = msgspec.msgpack.encode({
    "type": "ViewerCameraMessage", "wxyz": (1.0, 0.0, 0.0, 0.0),
    "position": (1.0, 1.0, 1.0), "fov": 0.8, "near": 0.01, "far": 100.0,
    "image_height": 600, "image_width": 800, "look_at": (0.0, 0.0, 0.0),
    "up_direction": (0.0, 0.0, 1.0),
})  # fmt: skip
"""Where a camera stands, as a browser says first."""


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
])  # fmt: skip
def test_requests_of_this_page_are_told_from_others(
    host: str | None, origin: str | None, local: bool
) -> None:
    """A page of another program on this machine is another origin; so is a name of elsewhere."""
    assert is_local(host, origin, 7001) is local


@pytest.fixture(scope="module")
def guarded() -> Iterator[Filter]:
    """A guard before a server of its own."""
    server = viser.ViserServer(host="127.0.0.1", port=0, verbose=False)
    buttons = {"buttons": frozenset({"reset", "fit"})}
    yield Filter(
        server, {"speed": (60.0, 2000.0)}, frozenset({"play"}), frozenset({"field"}), buttons
    )
    server.stop()


@pytest.mark.parametrize(("control", "updates", "value"), [
    ("speed", {"value": 450}, 450.0), ("speed", {"value": 1e9}, 2000.0),
    ("speed", {"value": -1e9}, 60.0), ("speed", {"value": math.nan}, None),
    ("speed", {"value": math.inf}, None), ("speed", {"value": "450"}, None),
    ("speed", {"value": True}, None), ("speed", {"value": None}, None),
    ("speed", {"value": [450]}, None), ("speed", {"value": 450, "min": 0}, None),
    ("speed", {"min": 0}, None), ("speed", {"update_cb": []}, None), ("speed", {}, None),
    ("speed", [], None), ("other", {"value": 450}, None), (["speed"], {"value": 450}, None),
    ("play", {"value": False}, False), ("play", {"value": 1}, None), ("play", {"value": "x"}, None),
    ("field", {"value": "<b>6"}, "<b>6"), ("field", {"value": 99 * "6"}, 40 * "6"),
    ("field", {"value": 6}, None), ("field", {"value": b"6"}, None),
    ("buttons", {"value": "reset"}, "reset"), ("buttons", {"value": "other"}, None),
    ("buttons", {"value": True}, None), ("buttons", {"value": ["reset"]}, None),
])  # fmt: skip
def test_values_are_those_of_their_controls(
    guarded: Filter, control: Any, updates: Any, value: Any
) -> None:
    assert guarded.allowed(control, updates) == value
    assert type(guarded.allowed(control, updates)) is type(value)


def finished(task: Coroutine[Any, Any, T]) -> T:
    """The result of a task in a thread of its own: beside a browser a loop runs in this one."""
    with ThreadPoolExecutor(1) as pool:
        return pool.submit(asyncio.run, task).result()


@pytest.fixture(scope="module")
def served() -> Iterator[tuple[int, subprocess.Popen[str]]]:
    """A live page as the command serves it."""
    with subprocess.Popen(
        [str(Path(sys.executable).with_name("nipper-pin")), "live", "e62", "--port", "0",
         "--no-browser"],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
    ) as process:  # fmt: skip
        assert process.stdout is not None
        line = process.stdout.readline()
        yield int(line.partition("127.0.0.1:")[2].partition("/")[0]), process
        process.kill()
        assert process.stderr is not None
        assert "Traceback" not in process.stderr.read()


def page(port: int) -> Any:
    """A page of the server, as its own browsers open it."""
    origin, protocols = f"http://127.0.0.1:{port}", [f"viser-v{viser.__version__}"]
    return connect(f"ws://127.0.0.1:{port}/", origin=origin, subprotocols=protocols,  # type: ignore[arg-type]
                   max_size=None, close_timeout=0.5)  # fmt: skip


def decoded(raw: bytes) -> list[dict[str, Any]]:
    """Messages of a window, without the arrays behind them."""
    size, packed = struct.unpack("<QQ", raw[:16])
    inner = zstandard.ZstdDecompressor().decompress(raw[16 : 16 + packed], max_output_size=size)
    return list(msgspec.msgpack.decode(inner)["messages"])


async def answered(port: int, speed: float) -> list[str]:
    """Open a page as a browser does, move its first slider and read the numbers; the others."""
    async with page(port) as socket:
        await socket.send(CAMERA)
        sliders, texts, moved = list[str](), list[str](), False
        while not any(f"speed {speed:g} r/min" in text and "collision" in text for text in texts):
            for item in decoded(await socket.recv()):
                if item["type"] == "GuiSliderMessage":
                    sliders.append(item["uuid"])
                elif item["type"] == "GuiUpdateMessage":
                    texts.append(item["updates"].get("content", ""))
            if sliders and not moved:
                update = {"uuid": sliders[0], "updates": {"value": speed}}
                await socket.send(msgspec.msgpack.encode({"type": "GuiUpdateMessage", **update}))
                moved = True
        return sliders[1:]


def random_message(rng: random.Random, controls: list[str]) -> bytes | str:
    """Something that a page may send, or should not, or cannot be read at all."""
    values = [0, -1e9, 1e300, math.nan, math.inf, "x", None, [], {}, True, 2**70 % 2**63, b"\0"]
    kinds = [
        "GuiUpdateMessage", "ShareUrlRequest", "FileTransferStartUpload", "FileTransferPart",
        "GuiFormSubmitMessage", "ViewerCameraMessage", "CommandTriggerMessage",
        "SetCameraPositionMessage", "nothing of this kind", "GuiButtonHoldMessage",
    ]  # fmt: skip
    fields = ["value", "min", "max", "update_cb", "visible", "disabled", "_impl", "step"]
    updates = {rng.choice(fields): rng.choice(values) for _ in range(rng.randrange(1, 3))}
    update = {"uuid": rng.choice([*controls, "no control"]), "updates": updates}
    packed = [
        rng.choice(values), {"type": rng.choice(kinds), "uuid": rng.choice(controls)},
        *[{"type": "GuiUpdateMessage", **update}] * 4,
    ]  # fmt: skip
    unread = rng.randbytes(rng.randrange(200)), "text"
    return rng.choice([*unread, *map(msgspec.msgpack.encode, packed)])


@pytest.mark.slow
@pytest.mark.parametrize(("size", "closed"), [(64 * 1024, False), (64 * 1024 + 1, True)])
def test_a_message_has_a_largest_size(
    served: tuple[int, subprocess.Popen[str]], size: int, *, closed: bool
) -> None:
    """A longer one ends its own connection, before it is read."""
    port, process = served

    async def sent() -> bool:
        async with page(port) as socket:
            await socket.send(bytes(size))
            await asyncio.wait_for(await socket.ping(), 10.0)
        return False

    if closed:
        with pytest.raises(WebSocketException, match="1009"):
            finished(sent())
    else:
        assert not finished(sent())
    assert process.poll() is None


@pytest.mark.slow
def test_an_attacked_page_goes_on_for_others(served: tuple[int, subprocess.Popen[str]]) -> None:
    """A thousand random messages by one browser; others move a slider and read the answer."""
    port, process = served
    rng = random.Random(7)

    async def attack(controls: list[str]) -> int:
        sent = 0
        while sent < 1000:
            with contextlib.suppress(WebSocketException, OSError):
                async with page(port) as socket:
                    while sent < 1000:
                        sent += 1
                        await socket.send(random_message(rng, controls))
                        await asyncio.sleep(0.002)
        return sent

    async def both() -> None:
        attacker = asyncio.create_task(attack(await answered(port, 500.0)))
        await answered(port, 520.0)
        assert await attacker == 1000
        await answered(port, 444.0)

    finished(asyncio.wait_for(both(), 60.0))
    assert process.poll() is None
