"""Other people's solvers on the same transition, one short file each; an optional extra."""

from .protocol import Four, Peer, Setting, available

__all__ = ["Four", "Peer", "Setting", "available"]
