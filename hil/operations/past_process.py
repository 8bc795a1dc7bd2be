"""Process that looks at a recording (``hil.lookback.look_process``), as the daemon talks to it."""

import asyncio
import json
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, cast

from hil.lookback.look_head import DROPPED, GIVEN, HEAD, WORKER
from hil.vocab.verbs import VerbRefused

_COMPLAINT_BYTES = 4096


class PastProcess:
    """Process of one recording, from its first request on. ``is_over``: it has ended, and answers nothing
    any more."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self._talk = _Talk()
        self._number = 0
        self._transport: asyncio.SubprocessTransport | None = None
        self._starting = asyncio.Lock()

    @property
    def is_over(self) -> bool:
        return self._talk.ended.is_set()

    async def ask(self, request: Mapping[str, Any]) -> Sequence[bytes]:
        """Ask for something; answers JSON in pieces.

        Raises:
            VerbRefused: there is no answer; says why.
        """
        async with self._starting:
            if self._transport is None:
                await self._start()
        if self.is_over:
            raise VerbRefused("cannot", self._talk.why())
        self._number += 1
        answer: asyncio.Future[tuple[int, bytes]] = asyncio.get_running_loop().create_future()
        self._talk.waiting[number := self._number] = answer
        assert self._transport
        pipe = cast(asyncio.WriteTransport, self._transport.get_pipe_transport(0))
        pipe.write(json.dumps({**request, "id": number}).encode() + b"\n")
        try:
            status, text = await answer
        finally:
            self._talk.waiting.pop(number, None)
        if status == GIVEN:
            return [text]
        raise VerbRefused("not_now" if status == DROPPED else "bad_parameter", text.decode(errors="replace"))

    async def _start(self) -> None:
        command = (sys.executable, "-P", "-m", WORKER, str(self.path))
        try:
            self._transport, _ = await asyncio.get_running_loop().subprocess_exec(
                lambda: self._talk, *command
            )
        except OSError as error:
            raise VerbRefused("cannot", f"no process can be started: {error.strerror}") from None

    async def end(self) -> None:
        """End it, if it has begun, and wait until it is over."""
        if self._transport:
            self._transport.close()  # kills it; its copies end with it
            await self._talk.ended.wait()


class _Talk(asyncio.SubprocessProtocol):
    """Output of a process. ``waiting``: answers by the numbers of their requests."""

    def __init__(self) -> None:
        self.waiting: dict[int, asyncio.Future[tuple[int, bytes]]] = {}
        self.ended = asyncio.Event()
        self._data = bytearray()
        self._complaint = b""

    def why(self) -> str:
        """Reason of its end, for people."""
        lines = self._complaint.decode(errors="replace").strip().splitlines()
        return lines[-1] if lines else "the process that looks at the recording was ended; ask again"

    def pipe_data_received(self, fd: int, data: bytes) -> None:
        if fd == 2:
            self._complaint = (self._complaint + data)[-_COMPLAINT_BYTES:]
            return
        self._data += data
        while len(self._data) >= HEAD.size:
            number, status, length = HEAD.unpack_from(self._data)
            end = HEAD.size + length
            if len(self._data) < end:
                return
            text = bytes(memoryview(self._data)[HEAD.size : end])
            del self._data[:end]
            if (answer := self.waiting.get(number)) and not answer.done():
                answer.set_result((status, text))

    def connection_lost(self, exc: Exception | None) -> None:
        self.ended.set()
        for answer in self.waiting.values():
            if not answer.done():
                answer.set_exception(VerbRefused("cannot", self.why()))
