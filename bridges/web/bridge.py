"""The web bridge's options, and how it is made. A configuration is checked without the rest of it."""

from typing import TYPE_CHECKING

from bridges.web.web_options import Options

if TYPE_CHECKING:
    from hil.vocab.bridge_protocol import Bridge
    from hil.vocab.desk_protocol import Desk

__all__ = ["Options", "make", "reference"]


def make(options: Options, desk: "Desk") -> "Bridge":
    from bridges.web.web_bridge import WebBridge

    return WebBridge(options, desk)


def reference() -> str:
    """Part of the reference about what pages and programs are served."""
    from bridges.web.web_reference import reference as part

    return part()
