"""A page with sliders whose numbers, curves and film follow them.

It is the viewer's page with a panel; a setting is answered over a WebSocket. Page and server need
the extra ``live``; no other command imports anything of this.
"""
