"""Bench that has a port of some name, among all that run on this computer."""

import os

from hil.net.control_client import ControlError, ask, listener
from hil.net.socket_owner import control_sockets

_PATIENCE_S = 0.5


def bench_with(address: str) -> str:
    """Find the bench of another process which has a port at this address; empty: none that answers has."""
    for socket in control_sockets().values():
        try:
            if listener(socket) in (0, os.getpid()):
                continue
            listed = ask(socket, "list", timeout_s=_PATIENCE_S)
        except (ControlError, OSError):
            continue
        taps = (row["port"] for row in listed.get("taps", ()))
        ports = (port["address"] for row in listed["devices"] for port in (row, *row["ports"].values()))
        if address in (*ports, *taps):
            return str(listed["bench"])
    return ""
