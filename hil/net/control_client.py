"""Client of a control socket. Imports little: completion in a shell waits for it.

An answer is checked before it is believed: who sent it, its length and time, and that it has the form of an
answer to the request (``answers.py``).
"""

import json
import os
import socket
import struct
import time
from pathlib import Path
from typing import Any

from hil.net.answers import misfit
from hil.vocab.verbs import NOT_MISTAKES

_TIMEOUT_S = 10
_QUEUE_AGAIN_S = 0.02
_CREDENTIALS = struct.Struct("3i")  # pid, uid, gid: struct ucred, unix(7)
_PIECE = 1 << 16
ANSWER_BYTES = 64 << 20
"""Maximum length of an answer: 5000 samples of all fields are 3 MB."""


class ControlError(Exception):
    """Error of a request that was refused, or that nobody answers: ``str(error)`` says why. ``code``: of the
    refusal (``hil.vocab.verbs.CODES``), or empty; ``is_mistake``: true if the request itself is wrong."""

    def __init__(self, why: str, *, is_mistake: bool = False, code: str = "") -> None:
        super().__init__(why)
        self.is_mistake, self.code = is_mistake, code


class BenchSilent(ControlError):
    """Error of a request that was not answered, or not in order: says whose bench it is and what helps."""


class BenchEnded(BenchSilent):
    """Nobody listens there: the bench has ended, or was killed."""


class BenchLate(BenchSilent):
    """A process listens there, and does not answer in time."""


def already_running(bench: str, pid: int) -> str:
    """Reason why a bench is not started a second time."""
    ends = f"`hil shutdown -b {bench}` ends it"
    return f"bench {bench} is running already, as process {pid}; {ends}, or write another name behind bench:"


def listener(path: Path) -> int:
    """Process behind a control socket, even if it is stopped or busy; 0: nobody, it was left behind.

    Raises:
        OSError: the socket may not be used.
    """
    try:
        with socket.socket(socket.AF_UNIX) as client:
            client.settimeout(_TIMEOUT_S)
            client.connect(str(path))
            return _peer(client)[0]
    except (FileNotFoundError, ConnectionRefusedError):
        return 0


def ask(path: Path, verb: str, *, timeout_s: float = _TIMEOUT_S, **arguments: Any) -> Any:
    """Send one request to the daemon behind a control socket; answers its result.

    Raises:
        BenchSilent: nobody answers there, or not in order.
        ControlError: the request was refused.
    """
    client, result = begin(path, verb, timeout_s=timeout_s, **arguments)
    client.close()
    return result


def begin(
    path: Path, verb: str, *, timeout_s: float = _TIMEOUT_S, **arguments: Any
) -> tuple[socket.socket, Any]:
    """Ask as ``ask``; answers the connection too, from which nothing was read behind the answer."""
    try:
        request = json.dumps({"verb": verb} | arguments, allow_nan=False).encode() + b"\n"
    except ValueError:
        why = "nan and inf are no values here; write a number"
        raise ControlError(why, is_mistake=True) from None
    until_s = time.monotonic() + timeout_s
    client = socket.socket(socket.AF_UNIX)
    try:
        client.settimeout(timeout_s)
        _connect(client, path, until_s)
        _check_peer(client, path)
        client.sendall(request)
        result = _result(_line(client, until_s), verb, path)
        client.settimeout(None)
    except (OSError, ValueError) as error:
        client.close()
        raise _no_answer(path, error, timeout_s) from error
    except BaseException:
        client.close()
        raise
    return client, result


def _no_answer(path: Path, error: OSError | ValueError, timeout_s: float) -> BenchSilent:
    """Error of a request by what Linux said, or what is wrong with the answer."""
    from hil.net.socket_owner import entry_remedy, owner_name

    if isinstance(error, FileNotFoundError):
        return BenchEnded(f"nobody listens at {path}: the bench has ended, or was never there")
    if isinstance(error, ConnectionRefusedError):
        remedy = f"start it again, which cleans up, or `rm -r {path.parent}`"
        return BenchEnded(f"nobody listens at {path} any more: its bench was killed; {remedy}")
    if isinstance(error, BlockingIOError | TimeoutError):
        return BenchLate(
            f"bench {path.parent.name} of {owner_name(path)} does not answer within {timeout_s:g} s:"
            " it starts, hangs, or this computer has too much to do; `hil doctor` says more"
        )
    if isinstance(error, PermissionError) and error.errno:
        return BenchSilent(
            f"bench {path.parent.name} of {owner_name(path)} refuses you: {path}: {error.strerror}; "
            + entry_remedy(path)
        )
    what = error.strerror or str(error) if isinstance(error, OSError) else str(error)
    return BenchSilent(f"what listens at {path}, of {owner_name(path)}, gives no answer: {what}")


def _connect(client: socket.socket, path: Path, until_s: float) -> None:
    """Connect, and wait for a place in the queue, as a unix socket with a time-out does not by itself."""
    while True:
        try:
            return client.connect(str(path))
        except BlockingIOError:
            if time.monotonic() > until_s:
                raise
            time.sleep(_QUEUE_AGAIN_S)


def _peer(client: socket.socket) -> tuple[int, int]:
    """Process and user behind a connection."""
    credentials = client.getsockopt(socket.SOL_SOCKET, socket.SO_PEERCRED, _CREDENTIALS.size)
    pid, uid, _ = _CREDENTIALS.unpack(credentials)
    return pid, uid


def _check_peer(client: socket.socket, path: Path) -> None:
    """Check that the listener is this user, root, or the folder's owner: see ``benches_here.py``."""
    uid = _peer(client)[1]
    if uid not in (0, os.geteuid(), path.parent.stat().st_uid):
        raise ValueError(f"user {uid} listens there, who has no business in {path.parent}")


def _line(client: socket.socket, until_s: float) -> bytes:
    """Read up to the line's end and not further: what follows a capture's answer is no text."""
    line = bytearray()
    while True:
        client.settimeout(max(until_s - time.monotonic(), 0.001))
        seen = client.recv(_PIECE, socket.MSG_PEEK)
        end = seen.find(b"\n") + 1
        line += client.recv(end or len(seen))
        if end or not seen:
            return bytes(line)
        if len(line) > ANSWER_BYTES:
            raise ValueError(f"the answer is longer than {ANSWER_BYTES >> 20} MB")
        if time.monotonic() > until_s:
            raise TimeoutError("timed out")


def _result(line: bytes, verb: str, path: Path) -> Any:
    if not line:
        raise ValueError("it hung up")
    try:
        answer = json.loads(line)
    except RecursionError:
        raise ValueError("the answer is nested too deeply") from None
    if not isinstance(answer, dict):
        raise ValueError("the answer is no object")
    if answer.get("ok") is False and isinstance(answer.get("error"), str):
        code = answer.get("code")
        raise ControlError(
            answer["error"], is_mistake=code not in (None, *NOT_MISTAKES), code=str(code or "")
        )
    if answer.get("ok") is not True:
        raise ValueError("the answer says neither ok nor an error")
    if why := misfit(verb, answer.get("result")):
        raise ControlError(
            f"the answer of {path} to {verb} cannot be understood: {why}; is it another version of hil?"
        )
    return answer["result"]
