"""Drawing: a program in G-code, read, checked and planned for the axes of a bench. Nothing moves."""

import asyncio
import pickle
from typing import Any

from hil.host.helper_process import HelperFailed, asked_of_process
from hil.operations.drawing_request import HEAD, WORKER, DrawingRequest, split_at
from hil.operations.table import Asked
from hil.vocab.axis import Axes
from hil.vocab.desk_protocol import Encoded
from hil.vocab.verbs import Role, VerbRefused

DRAWING_CHARACTERS = 4 << 20
MACHINE_CHARACTERS = 64 << 10
MOST_WAITING = 4
"""Maximum number of drawings that wait for their turn: each takes a processor for a second or more."""


class DrawingOperation:
    """Plans drawings, one after the other, each in a process, which ends with its asker."""

    def __init__(self, axes: Axes) -> None:
        self._axes = axes
        self._waiting = 0
        self._last: Encoded | None = None
        self._digest: str | None = None
        self._turn = asyncio.Lock()

    def last(self) -> str | None:
        """Digest of the last drawing of an operator; None: there is none yet."""
        return self._digest

    def drawing(
        self,
        asked: Asked,
        text: str,
        machine: str,
        file: str,
        machine_file: str,
        feed_percent: float,
        check: bool,
    ) -> Any:
        """Read, check and plan a program; a coroutine of the answer. Without a program and a machine: the
        last drawing of an operator, with its texts, so that all who look on see it. ``check``: it is not
        kept, and answered without its path and its runs."""
        if not text and not machine:
            if self._last is None:
                raise VerbRefused("not_now", "this bench has no drawing yet")
            return self._last
        for name, given, most in (
            ("text", text, DRAWING_CHARACTERS),
            ("machine", machine, MACHINE_CHARACTERS),
        ):
            if len(given) > most:
                raise VerbRefused("bad_request", f"{name}: {len(given)} characters; {most} are the most")
        axes = dict(self._axes.axes())
        request = DrawingRequest(text, machine, file, machine_file, feed_percent, axes, check)
        return self._planned(request, is_kept=not check and asked.source.role >= Role.OPERATOR)

    async def _planned(self, request: DrawingRequest, *, is_kept: bool) -> Encoded:
        if self._waiting >= MOST_WAITING:
            raise VerbRefused("not_now", f"{self._waiting} drawings are being planned; ask again later")
        self._waiting += 1
        try:
            async with self._turn:
                pieces = await asked_of_process(WORKER, pickle.dumps(request))
        except HelperFailed as error:
            raise VerbRefused("cannot", f"{request.file} cannot be planned: {error}") from None
        finally:
            self._waiting -= 1
        head, content = split_at(pieces, HEAD.size)
        can_run, digest, length = HEAD.unpack(b"".join(head))
        answer, texts = split_at(content, length)
        if is_kept and can_run:
            self._last, self._digest = Encoded((*answer, *texts)), digest.decode()
        return Encoded((*answer, b"}"))
