"""Messages of a page that were read and wait for their turns. A stop passes those before it."""

import asyncio
from typing import Any, Generic, NamedTuple, TypeVar

from hil.vocab.address import owner_of
from hil.vocab.operation import Urgency
from hil.vocab.verbs import VerbRefused

MOST_AHEAD = 64
"""Maximum number of messages that wait; a long one is the last of them."""

Message = TypeVar("Message")


class Ahead(NamedTuple, Generic[Message]):
    """Message that waits. ``place``: counts a page's messages; ``moves``: device, or axis of one, that it
    tells a verb."""

    place: int
    message: Message
    number: int
    urgency: Urgency
    moves: str


class ReadAhead:
    """Messages that wait, the oldest first."""

    def __init__(self) -> None:
        self._queue = asyncio.Queue[Ahead[Any]](MOST_AHEAD)
        self._place = 0
        self._stopped: dict[str, int] = {}
        """Places of the last stops, by what they stopped; empty: all."""

    async def put(self, message: Any, number: int, urgency: Urgency, moves: str, *, is_long: bool) -> None:
        """Let a message wait, when there is room for it; nothing is read behind a long one."""
        self._place += 1
        await self._queue.put(Ahead(self._place, message, number, urgency, moves))
        if is_long:
            await self._queue.join()

    async def next(self) -> Ahead[Any]:
        """The oldest message; ``done`` follows."""
        return await self._queue.get()

    def done(self) -> None:
        self._queue.task_done()

    async def emptied(self, *working: "asyncio.Task[None]") -> None:
        """Wait until nothing waits any more, or one of those ends that work for it: what came before a page
        left is carried out."""
        empty = asyncio.ensure_future(self._queue.join())
        try:
            await asyncio.wait({empty, *working}, return_when=asyncio.FIRST_COMPLETED)
        finally:
            empty.cancel()

    def stop(self, name: str) -> int:
        """Note a stop of a device, or axis of one; empty: of all. Answers its place."""
        self._place += 1
        self._stopped[name] = self._place
        return self._place

    def check(self, place: int, moves: str) -> None:
        """Check that no stop has passed what would move an axis. Raises VerbRefused."""
        names = (moves, owner_of(moves), "")
        if moves and place < max(self._stopped.get(name, 0) for name in names):
            raise VerbRefused("not_now", f"a stop of {moves} came while this waited; ask for it again")
