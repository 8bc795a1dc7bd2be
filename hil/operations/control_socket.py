"""The control socket: what ``hil``'s commands talk to. A unix stream socket of mode 0660.

A request is one line of JSON: ``{"verb": "status"}`` and the verb's own arguments; the answer is one
line: ``{"ok": true, "result": ...}`` or ``{"ok": false, "error": "..."}``. Verbs: ``VERBS``. Whatever else
comes gets a refusal, and the connection goes on.
"""

import asyncio
import json
import logging
import os
import socket
from collections.abc import Callable
from contextlib import suppress
from inspect import isawaitable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hil.live import real_boards
from hil.live.captures import Capture
from hil.live.off_loop import off_loop
from hil.live.refusals import Refused, StartError
from hil.net.control_client import ControlError, already_running, listener
from hil.net.unix_door import open_door
from hil.net.visitors import Visit, Visitors
from hil.operations.control_verbs import VERBS
from hil.operations.requests import read_request
from hil.vocab.dialogue import DialogueError
from hil.vocab.faults import FaultRefused
from hil.vocab.verbs import VerbRefused

if TYPE_CHECKING:
    from hil.daemon import Daemon

_LINE_LIMIT = 12 * 1024 * 1024  # a pulse train of MAX_ROWS
_LONGEST_REFUSAL = 4000  # characters; what is refused may be of any length
_ARGUMENTS = {name: verb.arguments for name, verb in VERBS.items()}
REFUSALS = (ControlError, DialogueError, FaultRefused, Refused, real_boards.NoDialogue, VerbRefused)

log = logging.getLogger("hil")


class TooLong:
    """A line that was longer than any request; it was not kept."""


class ControlServer:
    """Answers requests about one daemon."""

    def __init__(self, daemon: "Daemon", path: Path) -> None:
        self._daemon = daemon
        self._path = path
        self._visitors: Visitors[socket.socket] | None = None
        self._clients: set[asyncio.StreamWriter] = set()
        self._is_closed = False

    async def open(self) -> None:
        """Listen.

        Raises:
            StartError: a daemon of this bench is running, or the socket cannot be made.
        """
        try:
            if pid := listener(self._path):
                raise StartError(already_running(self._daemon.config.bench, pid))
            self._path.unlink(missing_ok=True)
            old = os.umask(0o117)
            try:
                self._visitors = open_door(self._path, self._client, _LINE_LIMIT)
            finally:
                os.umask(old)
            self._inode = self._path.stat().st_ino
        except OSError as error:
            raise StartError(
                f"control socket {self._path}: {error.strerror or error}; choose another --runtime-dir"
            ) from error

    async def close(self) -> None:
        if self._is_closed:
            return
        self._is_closed = True
        for writer in self._clients:
            writer.close()
        if self._visitors:
            self._visitors.close()
            with suppress(FileNotFoundError):
                if self._path.stat().st_ino == self._inode:  # else it is a successor's
                    self._path.unlink()

    async def _client(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter, visit: Visit) -> None:
        self._clients.add(writer)
        try:
            while not self._is_closed and (line := await _next_line(reader)):
                visit.is_busy = visit.has_asked = True
                answer = await self.answer(line)
                capture = answer.pop("capture", None)
                writer.write(json.dumps(answer).encode() + b"\n")
                if capture:
                    await writer.drain()
                    taken, end = capture
                    await self._capture(taken, end, reader, writer)
                visit.is_busy, visit.since_s = False, asyncio.get_running_loop().time()
                await writer.drain()
        finally:
            self._clients.discard(writer)

    async def _capture(
        self,
        capture: Capture,
        end: Callable[[], None],
        reader: asyncio.StreamReader,
        writer: asyncio.StreamWriter,
    ) -> None:
        """The connection carries a capture until its client leaves."""
        capture.begin(writer)
        try:
            await reader.read(1)
        finally:
            end()

    async def answer(self, line: bytes | TooLong) -> dict[str, Any]:
        """To a request, or to what is none; ``capture`` in it: the connection carries one from now on."""
        name = ""
        try:
            if isinstance(line, TooLong):
                raise ControlError(f"not a request: longer than {_LINE_LIMIT} bytes")
            name, arguments = await off_loop(line, read_request, line, _ARGUMENTS)
            result = VERBS[name].run(self._daemon, **arguments)
            if name == "capture":
                return {"ok": True, "result": {}, "capture": result}
            return {"ok": True, "result": await result if isawaitable(result) else result}
        except REFUSALS as error:
            return {"ok": False, "error": str(error)[:_LONGEST_REFUSAL]}
        except Exception:
            if not self._daemon.reloader.is_open:
                return {"ok": False, "error": "the bench has not started yet, or is ending; ask again"}
            # Ours: this request is lost, all else goes on.
            log.exception("control socket: %s could not be carried out", name)
            return {"ok": False, "error": f"{name} met a fault of hil's own; the bench's log says more"}


async def _next_line(reader: asyncio.StreamReader) -> bytes | TooLong:
    """With its end, or what came before the client has hung up."""
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
