"""Addresses of zenoh at which this computer cannot listen."""

from collections.abc import Sequence

from hil.net.listeners import ListenRefused, why_refused


async def first_refused(listen: Sequence[str]) -> tuple[int, ListenRefused] | None:
    """Find the first address of these at which nobody could listen now, for one of zenoh's own errors; None:
    all could be had, or are of other transports."""
    for at, each in enumerate(listen):
        transport, _, address = each.partition("/")
        if transport in ("tcp", "tls", "ws") and (refused := await why_refused(address)):
            return at, refused
    return None
