"""The numbers of the page as HTML."""

from __future__ import annotations

from html import escape

from ..answer import Answer
from ..curves.plots import unlike
from .memory import Kept
from .numbers import Rows, table


def as_html(
    found: Answer, turn: Rows = (), other: Kept | None = None, *, pinned: bool = False
) -> str:
    """The answer as HTML: the setting, its numbers or its message, and those of the whole turn.

    Args:
        turn: Numbers of the turn.
        other: The setting that the numbers are compared with.
        pinned: Whether that one is pinned.
    """
    head = f'<div id="setting">{escape(found.setting)}</div>'
    if other is not None:
        which = "the pinned setting" if pinned else "the setting before"
        head += (
            f'<div id="against">at right: difference to {which} '
            f"({escape(unlike(other, found.parts))})</div>"
        )
    if found.message:
        body = (
            f'<div id="message" role="alert" style="color:#B00020"><b>No numbers:</b> '
            f"{escape(found.message)}</div>"
        )
    else:
        body = table("numbers", found.rows, other.answer.rows if other else ())
    return boxed(f"{head}{body}{table('turn', turn, other.turn if other else ()) if turn else ''}")


def boxed(content: str) -> str:
    """HTML in the size and with the margins of the sliders' labels."""
    return f'<div style="font-size:0.82em;line-height:1.35;padding:0.1em 0.8em">{content}</div>'
