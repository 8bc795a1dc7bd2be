"""Ends of asyncio's connections."""

import asyncio
from contextlib import suppress


def abort(transport: asyncio.WriteTransport) -> None:
    """End a connection at once, also one that has ended."""
    # One that was closed while something waited to be sent, and that has sent it, has no loop any more.
    with suppress(AttributeError):
        transport.abort()
