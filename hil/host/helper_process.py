"""Work in a process of its own, which ends with its caller: the daemon's loop and its threads go on
meanwhile."""

import asyncio
import signal
import sys
from collections.abc import Sequence
from typing import cast

_COMPLAINT_BYTES = 4096


class HelperFailed(Exception):
    """Error of a process that cannot be started, or that ended without an answer: ``str(error)`` says why."""


async def asked_of_process(module: str, request: bytes) -> Sequence[bytes]:
    """Run a module's main function with the request as its input; answers its output, in the pieces in which
    it came. If this is cancelled, the process is killed.

    Raises:
        HelperFailed: there is no answer.
    """
    loop = asyncio.get_running_loop()
    talk = _Talk(loop.create_future())
    command = (sys.executable, "-P", "-m", module)
    try:
        transport, _ = await loop.subprocess_exec(lambda: talk, *command)
    except OSError as error:
        raise HelperFailed(f"no process can be started: {error.strerror}") from None
    try:
        pipe = cast(asyncio.WriteTransport, transport.get_pipe_transport(0))
        pipe.write(request)
        pipe.write_eof()
        await asyncio.shield(talk.ended)
    finally:
        transport.close()  # kills it, if it runs
        await talk.ended
    if code := transport.get_returncode():
        lines = talk.complaint.decode(errors="replace").strip().splitlines()
        raise HelperFailed(_ended(code) + (f": {lines[-1]}" if lines else ""))
    return talk.pieces


class _Talk(asyncio.SubprocessProtocol):
    """Output of a process. ``ended``: done when it has ended and all is read."""

    def __init__(self, ended: "asyncio.Future[None]") -> None:
        self.ended = ended
        self.pieces: list[bytes] = []
        self.complaint = b""

    def pipe_data_received(self, fd: int, data: bytes) -> None:
        if fd == 1:
            self.pieces.append(data)
        else:
            self.complaint = (self.complaint + data)[-_COMPLAINT_BYTES:]

    def connection_lost(self, exc: Exception | None) -> None:
        if not self.ended.done():
            self.ended.set_result(None)


def _ended(code: int) -> str:
    """Say how a process ended that gave no answer."""
    if code == -signal.SIGXCPU:
        return "it takes too long"
    return f"its process was ended by {signal.Signals(-code).name}" if code < 0 else "its process failed"
