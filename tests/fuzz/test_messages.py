"""Messages that the live page takes: values of controls, and cameras that stand somewhere."""

from __future__ import annotations

import math
from typing import Any

import msgspec
import pytest

pytest.importorskip("viser", reason="viser is not installed (extra `live`)")

from viser import _messages

from nipper_pin.view.live.guard import _taken

CAMERA: dict[str, Any] = {
    "type": "ViewerCameraMessage", "wxyz": [1, 0.0, 0.0, 0.0], "position": [0.0, 0.0, 1.0],
    "fov": 1, "near": 0.1, "far": 10.0, "image_height": 100, "image_width": 100,
    "look_at": [0.0, 0.0, 0.0], "up_direction": [0.0, 0.0, 1.0],
}  # fmt: skip
UPDATE: dict[str, Any] = {"type": "GuiUpdateMessage", "uuid": "a", "updates": {"value": 1}}
WRONG: list[Any] = [
    *({**CAMERA, key: value} for key in CAMERA if key != "type"
      for value in (math.nan, math.inf, 1e31, "1", None, [], [1.0], [[1.0], [1.0, 2.0]], True)),
    *({key: CAMERA[key] for key in CAMERA if key != left} for left in CAMERA),
    {**CAMERA, "more": 1}, {**CAMERA, "position": [0.0, math.nan, 0.0]},
    {**CAMERA, "position": [0.0] * 4}, {**CAMERA, "wxyz": [[0.0, CAMERA, math.nan], 0.0, 0.0, 1.0]},
    {**UPDATE, "uuid": 1}, {**UPDATE, "updates": [1]}, {**UPDATE, "more": 1}, {"type": 1}, [], 1,
    {"type": "GuiButtonHoldMessage", "uuid": "a"}, {"type": "FileTransferPart"},
    {"type": "ShareUrlRequest"},
]  # fmt: skip


@pytest.mark.parametrize("message", [CAMERA, UPDATE])
def test_what_a_page_sends_is_taken_by_viser_too(message: dict[str, Any]) -> None:
    raw = msgspec.msgpack.encode(message)
    assert _taken(raw)
    assert type(_messages.Message.deserialize(raw)).__name__ == message["type"]


@pytest.mark.parametrize("message", WRONG)
def test_all_else_is_dropped_before_viser_sees_it(message: object) -> None:
    """Numbers that are none, and lists of other lengths, ended the connection with a traceback."""
    assert not _taken(msgspec.msgpack.encode(message))


@pytest.mark.parametrize("raw", [b"", b"\xc1", b"\x81" * 60_000, b"\x91" * 60_000, b"\xff" * 9])
def test_bytes_that_are_no_message_are_dropped(raw: bytes) -> None:
    assert not _taken(raw)
