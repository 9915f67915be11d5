"""How the page is laid out in windows of all widths."""

from __future__ import annotations

import threading

import viser

NARROW, WIDE = 400, 780
"""Widths of the panel [pixels]: one column, or numbers and curves side by side."""
_ROOM = 1250  # pixels, of the narrowest window with two columns
_COLUMNS = 700  # pixels, of the narrowest panel with two columns
_PHONE = 576  # pixels, of the widest window in which viser puts the panel below the picture

# Children of the panel, one an element; a field of text follows the slider that it stands beside.
_PANEL = "div:has(> div > #layout)"
_FIELD = ".mantine-TextInput-root"
STYLE = f"""<style id="layout">
:root {{ --at: 0 }}
[data-dock-region] {{ container-type: inline-size }}
@container (min-width: {_COLUMNS}px) {{
  {_PANEL} {{ column-count: 2; column-gap: 0 }}
  {_PANEL} > div:has(> #second) {{ break-before: column }}
}}
{_PANEL} {{ padding-right: 0.4rem }}
{_PANEL} > div {{ break-inside: avoid }}
{_PANEL} > div:has(+ div {_FIELD}) {{ margin-right: 5.2rem; min-height: 2.2rem }}
{_PANEL} > div:has(+ div {_FIELD}) .mantine-NumberInput-root {{ display: none }}
{_PANEL} > div:has({_FIELD}) {{ width: 6rem; margin: -2.15rem 0 0 auto }}
{_PANEL} > div:has({_FIELD}) > div > div:first-child {{ display: none }}
div:has(+ div > .refused) input {{ border-color: #B00020; color: #B00020;
  text-decoration: line-through }}
.refused {{ color: #B00020; font-size: 0.8em; line-height: 1.3; padding: 0 0.9em 0.4em }}
#lips {{ display: block; width: 100%; max-width: 360px; background: #fff; margin: 0.3em auto 0;
  border: 1px solid #c5ccd6 }}
#lips path {{ stroke-width: 1 }}
#lips-scale {{ text-align: center; color: #4a5360 }}
#legend {{ display: flex; flex-wrap: wrap; gap: 0 1em; font-size: 0.8em; padding: 0.2em 1em }}
#legend i {{ display: inline-block; width: 1.8em; margin-right: 0.4em; vertical-align: middle }}
.u-over::after {{ content: ""; position: absolute; top: 0; bottom: 0; width: 1px;
  left: calc(var(--at) * 100%); background: #1c2430 }}
.uplot-container {{ margin-top: 0.25em !important; margin-bottom: 0.25em !important }}
@media (max-width: {_PHONE}px) {{
  div:has(> div > canvas[data-engine]) {{ height: 40vh !important }}
  .mantine-Paper-root:has(#layout), .mantine-Paper-root:has(#layout) div:has(#layout) {{
    width: 100% !important }}
}}
</style>"""
SECOND = '<div id="second"></div>'
"""Where the second column begins."""


def cursor(share: float) -> str:
    """Style that puts the cursor of the plots at a share of their time.

    Args:
        share: The share, 0 to 1.
    """
    return f"<style>:root {{ --at: {min(max(share, 0.0), 1.0):.4f} }}</style>"


class Widths:
    """Gives each browser a panel that fits its window."""

    def __init__(self, server: viser.ViserServer) -> None:
        """Follow all browsers that come."""
        self._lock = threading.Lock()
        self._known: dict[int, int] = {}
        server.on_client_connect(self._come)
        server.on_client_disconnect(self._go)

    def _come(self, client: viser.ClientHandle) -> None:
        self._fit(client)
        client.camera.on_update(lambda _: self._fit(client))

    def _go(self, client: viser.ClientHandle) -> None:
        with self._lock:
            self._known.pop(client.client_id, None)

    def _fit(self, client: viser.ClientHandle) -> None:
        """The picture and the panel share the window; a panel that fits stays as it is."""
        with self._lock:
            had = self._known.get(client.client_id, NARROW)
            window = client.camera.image_width + had
            wanted = WIDE if window >= _ROOM else NARROW
            self._known[client.client_id] = wanted
        if wanted != had:
            client.gui.main_panel.set_width(wanted)
