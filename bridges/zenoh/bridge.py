"""The zenoh bridge's options, and how it is made. A configuration is checked without the rest of it."""

from typing import TYPE_CHECKING

from bridges.zenoh.options import Options

if TYPE_CHECKING:
    from hil.vocab.bridge_protocol import Bridge
    from hil.vocab.desk_protocol import Desk

__all__ = ["Options", "make", "reference"]


def make(options: Options, desk: "Desk") -> "Bridge":
    from bridges.zenoh.bench_session import ZenohBridge

    return ZenohBridge(options, desk)


def reference() -> str:
    """Part of the reference about the keys."""
    from bridges.zenoh.keys import reference as part

    return part()
