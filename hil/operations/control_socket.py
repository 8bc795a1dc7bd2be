"""Control socket, for ``hil``'s commands: a unix stream socket of mode 0660.

A request is one line of JSON: ``{"verb": "status"}``, with the target and the parameters of the operation of
that name; the answer is one line: ``{"ok": true, "result": ...}``, or ``{"ok": false, "error": "...", "code":
"..."}``. Any other line gets a refusal, and the connection goes on.
"""

import asyncio
import json
import logging
import os
import pwd
import select
import socket
from collections.abc import Awaitable, Callable, Mapping
from contextlib import closing, suppress
from dataclasses import replace
from functools import partial
from inspect import isawaitable
from pathlib import Path
from struct import Struct
from time import thread_time
from typing import Any

from hil.host.paths import STARTING
from hil.live.captures import Capture
from hil.live.off_loop import off_loop
from hil.net.control_client import already_running, listener
from hil.net.fair_share import FairShare
from hil.net.visitors import Visit, Visitors
from hil.operations.desk import no_operation
from hil.operations.table import NAME_CHARACTERS
from hil.vocab.desk_protocol import LOCAL, Desk, Done, Encoded, Source
from hil.vocab.device import ProcessorSession
from hil.vocab.operation import Operation, Urgency, moved_by, urgency_of
from hil.vocab.verbs import OF_TEXTS, VerbRefused
from hil.wire.json_text import JsonError, read_json

CONTROL_VERSION = 1
_MODE = 0o660
MAX_CLIENTS = 64
_BACKLOG = 128
_BUSY = b'{"ok": false, "error": "%d clients wait here already; ask again", "code": "busy"}\n' % MAX_CLIENTS
"""Answer to a client for whom there is no room."""
_LINE_LIMIT = 12 * 1024 * 1024  # a pulse train of MAX_ROWS
ENDS_WITH_CLIENT = ("benches", "drawing", "run", "wait")
"""Operations that end where their client has gone before they have done anything."""
CLIENTS_LOOK_S = 0.25
"""Time between two looks whether a client that waits for an answer is still there."""
SHORT_BYTES = 1024
"""Length of a line that is read before its turn: a stop must not wait for one. It takes some 10 us."""
_DEBUG_BYTES = 4096
_PEER = Struct("3i")
"""Process, user and group of the other end: `struct ucred` of unix(7)."""
_LONGEST_REFUSAL = 4000  # characters; what is refused may be of any length

log = logging.getLogger("hil")

Serve = Callable[[asyncio.StreamReader, asyncio.StreamWriter, Visit], Awaitable[None]]


class SocketRefused(Exception):
    """Error of a socket that cannot be had: ``str(error)`` says why and what to do."""


class TooLong:
    """Line that was longer than any request; it was not kept."""


class ClaimedSocket:
    """Listening socket of a bench, which keeps other daemons away; clients wait until they are served.

    Raises:
        SocketRefused: a daemon of this bench is running, or the socket cannot be made.
    """

    def __init__(self, path: Path, bench: str) -> None:
        self._path = path
        try:
            if pid := listener(path):
                raise SocketRefused(already_running(bench, pid))
            path.unlink(missing_ok=True)
            old = os.umask(0o117)
            try:
                self.listening = listen_at(path)
            finally:
                os.umask(old)
            path.chmod(_MODE | STARTING)
            self._inode = path.stat().st_ino
        except OSError as error:
            why = error.strerror or error
            raise SocketRefused(f"control socket {path}: {why}; choose another --runtime-dir") from error

    def serve(self) -> None:
        """Show that clients are served from now on."""
        with suppress(OSError):  # somebody has removed it: those who are inside stay
            self._path.chmod(_MODE)

    def release(self) -> None:
        """Let nobody in any more; the socket's file goes, unless it is a successor's."""
        self.listening.close()
        with suppress(OSError):
            if self._path.stat().st_ino == self._inode:
                self._path.unlink()


def listen_at(path: Path) -> socket.socket:
    """Make a listening unix socket; clients wait until ``let_in``.

    Raises:
        OSError: the socket cannot be made.
    """
    listener = socket.socket(socket.AF_UNIX)
    try:
        listener.bind(str(path))
        listener.listen(_BACKLOG)
    except OSError:
        listener.close()
        raise
    listener.setblocking(False)
    return listener


def let_in(listener: socket.socket, serve: Serve, line_limit: int) -> Visitors:
    """Run ``serve`` for each client; it is cancelled where it waits when its client has to go."""

    async def stay(connection: socket.socket, visit: Visit) -> None:
        try:
            reader, writer = await asyncio.open_unix_connection(sock=connection, limit=line_limit)
        except BaseException:
            connection.close()
            raise
        with closing(writer), suppress(ConnectionError):
            await serve(reader, writer, visit)

    loop = asyncio.get_running_loop()
    visitors = Visitors("control socket", MAX_CLIENTS, loop, stay, log.warning, _BUSY, has_spare=True)
    visitors.listen(listener)
    return visitors


class ControlServer:
    """Server of the clients of a socket, from its making on."""

    def __init__(self, desk: Desk, claimed: ClaimedSocket) -> None:
        self._desk = desk
        self._operations = desk.describe().operations
        self._is_closed = False
        self._turns = FairShare()
        self._visitors = let_in(claimed.listening, self._client, _LINE_LIMIT)
        claimed.serve()

    async def close(self) -> None:
        """Send everybody away: what still waits for an answer is not carried out."""
        self._is_closed = True
        self._visitors.close()
        self._turns.close()
        await asyncio.gather(*self._visitors.send_away(), return_exceptions=True)

    async def _client(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter, visit: Visit) -> None:
        asker = replace(LOCAL, user=peer_name(writer.get_extra_info("socket")))
        while not self._is_closed and (line := await _next_line(reader)):
            visit.is_busy = visit.has_asked = True
            answer = await self.answer(line, writer, asker)
            carry = answer.pop("carry", None)
            await _write(answer, writer)
            if carry:
                await carry(reader, writer)
            visit.is_busy, visit.since_s = False, asyncio.get_running_loop().time()
            await writer.drain()

    async def answer(
        self, line: bytes | TooLong, client: asyncio.StreamWriter | None = None, asker: Source = LOCAL
    ) -> dict[str, Any]:
        """Answer a line of a client, request or not; ``carry`` in the answer: what the connection carries
        from now on, something else than requests.

        Raises:
            ConnectionError: the client has gone; what was done for it has ended.
        """
        name = ""
        is_short = not isinstance(line, TooLong) and len(line) <= SHORT_BYTES
        if not is_short:
            await self._turns.wait()
        try:
            if isinstance(line, TooLong):
                raise VerbRefused("bad_request", f"not a request: longer than {_LINE_LIMIT} bytes")
            name, target, given = await off_loop(line, read_request, line, self._operations)
            operation = self._operations[name]
            urgency = urgency_of(operation, given)
            if is_short:
                await self._turns.wait(urgency, moved_by(operation, target))
            began_s = thread_time()
            result = self._desk.ask(asker, name, target, given)
            self._turns.note(client, thread_time() - began_s)
            if urgency is Urgency.STOP:
                self._turns.stopped(target)
            if isawaitable(result):
                if client and name in ENDS_WITH_CLIENT:
                    result = _unless_gone(result, client)
                result = await result
        except ConnectionError:
            raise
        except VerbRefused as error:
            if error.code in OF_TEXTS:
                return {"ok": True, "result": {"problems": str(error)}}
            return {"ok": False, "error": str(error)[:_LONGEST_REFUSAL], "code": error.code}
        except Exception:  # hil's own error: this request is lost, all else goes on
            log.exception("control socket: %s could not be carried out", name)
            return {"ok": False, "error": f"{name} met a fault of hil's own; the bench's log says more"}
        if name == "capture":
            carry = partial(_carry_capture, result)
            return {"ok": True, "result": {"epoch_ns": result[0].epoch_ns}, "carry": carry}
        if name == "debug":
            return {"ok": True, "result": {}, "carry": partial(_carry_debugging, result)}
        if isinstance(result, Done):
            result = {"effective_at_ns": result.effective_at_ns, **result.answer}
        return {"ok": True, "result": result}


def peer_name(connection: socket.socket) -> str:
    """Name of the user whose program is at the other end, or its number where it has none here."""
    credentials = connection.getsockopt(socket.SOL_SOCKET, socket.SO_PEERCRED, _PEER.size)
    _, user, _ = _PEER.unpack(credentials)
    try:
        return pwd.getpwuid(user).pw_name
    except KeyError:
        return f"user {user}"


def read_request(line: bytes, operations: Mapping[str, Operation]) -> tuple[str, str, dict[str, Any]]:
    """Read the operation that a request asks for, its target and what is given with it.

    Raises:
        VerbRefused: it is no such request.
    """
    try:
        request = read_json(line)
    except JsonError as error:
        raise VerbRefused("bad_request", f"not a request: {error}; write a line of JSON") from None
    if not isinstance(request, dict) or not isinstance(name := request.pop("verb", None), str):
        example = '{"verb": "status"}'
        raise VerbRefused("bad_request", f"not a request: write an object with a verb, as in {example}")
    if name not in operations or operations[name].answer is None:
        raise no_operation(name)
    if not (argument := operations[name].target.argument):
        return name, "", request
    target = request.pop(argument, None)
    if not isinstance(target, str) or len(target) > NAME_CHARACTERS:
        raise VerbRefused(
            "bad_parameter", f"{argument}: write a text of at most {NAME_CHARACTERS} characters"
        )
    return name, target, request


async def _unless_gone(answering: Awaitable[Any], client: asyncio.StreamWriter) -> Any:
    """Wait for an answer as long as its client is there. Raises ConnectionError: it has gone."""
    task = asyncio.ensure_future(answering)
    try:
        while not (await asyncio.wait([task], timeout=CLIENTS_LOOK_S))[0]:
            if _has_gone(client):
                raise ConnectionResetError
        return task.result()
    finally:
        task.cancel()


def _has_gone(writer: asyncio.StreamWriter) -> bool:
    """True if a client has closed its socket; one that only writes no more still wants its answer."""
    if writer.is_closing():
        return True
    look = select.poll()
    look.register(writer.get_extra_info("socket"), 0)
    return bool(look.poll(0))


async def _write(answer: dict[str, Any], writer: asyncio.StreamWriter) -> None:
    """Write an answer; a long one as fast as it is read."""
    if not isinstance(result := answer.get("result"), Encoded):
        writer.write(json.dumps(answer).encode() + b"\n")
        return
    for part in (b'{"ok": true, "result": ', *result.parts, b"}\n"):
        writer.write(part)
        await writer.drain()
        await asyncio.sleep(0)


async def _carry_capture(
    capture: tuple[Capture, Callable[[], None]], reader: asyncio.StreamReader, writer: asyncio.StreamWriter
) -> None:
    """Let a capture go out until its client leaves."""
    taken, end = capture
    try:
        await writer.drain()
        taken.begin(writer, asyncio.get_running_loop())
        await reader.read(1)
    finally:
        end()
        taken.flush()


async def _carry_debugging(
    session: ProcessorSession, reader: asyncio.StreamReader, writer: asyncio.StreamWriter
) -> None:
    """Let GDB's packets go both ways until it leaves. Then the client is sent away."""
    try:
        session.begin(writer.write, writer.close)
        while data := await reader.read(_DEBUG_BYTES):
            if session.received(data):
                break
            await writer.drain()
    finally:
        session.close()
        writer.close()


async def _next_line(reader: asyncio.StreamReader) -> bytes | TooLong:
    """Next line with its end, or what came before the client has hung up."""
    is_too_long = False
    while True:
        try:
            line = await reader.readuntil(b"\n")
            return TooLong() if is_too_long else line
        except asyncio.IncompleteReadError as error:
            return TooLong() if is_too_long else error.partial
        except asyncio.LimitOverrunError as error:
            is_too_long = True
            await reader.readexactly(max(error.consumed, 1))
