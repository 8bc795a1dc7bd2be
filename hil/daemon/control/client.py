"""Asking at a control socket (``server.py`` answers). Imports little: completion in a shell waits for it."""

import json
import socket
import struct
import time
from pathlib import Path
from typing import Any

_TIMEOUT_S = 10
_QUEUE_AGAIN_S = 0.02
_CREDENTIALS = struct.Struct("3i")  # pid, uid, gid: struct ucred, unix(7)


class ControlError(Exception):
    """A request was refused, or nobody answers: ``str(error)`` says why."""


def listener(path: Path) -> int:
    """The process behind a control socket, even if it is stopped or busy; 0: nobody, it was left behind.

    Raises:
        OSError: the socket may not be used.
    """
    try:
        with socket.socket(socket.AF_UNIX) as client:
            client.settimeout(_TIMEOUT_S)
            client.connect(str(path))
            credentials = client.getsockopt(socket.SOL_SOCKET, socket.SO_PEERCRED, _CREDENTIALS.size)
    except (FileNotFoundError, ConnectionRefusedError):
        return 0
    return int(_CREDENTIALS.unpack(credentials)[0])


def ask(path: Path, verb: str, *, timeout_s: float = _TIMEOUT_S, **arguments: Any) -> Any:
    """One request to the daemon behind a control socket; answers its result.

    Raises:
        ControlError: nobody answers there, or the request was refused.
    """
    try:
        request = json.dumps({"verb": verb} | arguments, allow_nan=False).encode() + b"\n"
    except ValueError:
        raise ControlError("nan and inf are no values here; write a number") from None
    try:
        with socket.socket(socket.AF_UNIX) as client:
            client.settimeout(timeout_s)
            _connect(client, path, timeout_s)
            client.sendall(request)
            # Closed here: Python passes over whatever happens while it clears away, Ctrl-C too.
            with client.makefile("rb") as stream:
                answer = json.loads(stream.readline())
    except (OSError, ValueError) as error:
        raise ControlError(f"no daemon answers at {path}: {error}") from error
    if not answer["ok"]:
        raise ControlError(answer["error"])
    return answer["result"]


def _connect(client: socket.socket, path: Path, timeout_s: float) -> None:
    """Wait for a place in the queue too, for which a unix socket with a time-out does not wait by itself."""
    until_s = time.monotonic() + timeout_s
    while True:
        try:
            return client.connect(str(path))
        except BlockingIOError:
            if time.monotonic() > until_s:
                raise
            time.sleep(_QUEUE_AGAIN_S)
