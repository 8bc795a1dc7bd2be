"""Dialogues with a real board: when one is broken off, it ends at once."""

import asyncio
from types import SimpleNamespace
from typing import Any, cast

import pytest

from hil.live.board_backend import BoardBackend
from hil.live.port_link import PortLink
from hil.vocab.dialogue import Dialogue, Heard, Listen, Send
from hil.vocab.ports import Port
from hil.vocab.time import NS_PER_MS


class BoardPort:
    """A line with a board on it, which keeps what it is told."""

    address = "/dev/ttyUSB0"

    def __init__(self) -> None:
        self.written = bytearray()

    def stats(self) -> Any:
        return SimpleNamespace(clients=1, connects=1)

    def backlog(self) -> int:
        return 0

    def write(self, data: bytes) -> None:
        self.written += data

    def resume_reading(self) -> None:
        """Ignored: nothing was held."""


def at_board(board: BoardPort) -> BoardBackend:
    link = PortLink[BoardBackend]("m1", cast(Port, BoardPort()))
    link.occupy(BoardBackend(link, cast(Port, board)))
    return link.backend


def chatter() -> Dialogue[None]:
    """Says something each time that the board does."""
    while True:
        heard: Heard = yield Listen(1000 * NS_PER_MS)
        yield Send(heard.data)


@pytest.mark.parametrize("turns", range(6))
def test_a_dialogue_that_is_broken_off_while_the_board_answers_ends(turns: int) -> None:
    """Break the dialogue off at each turn of the event loop between the answer and its handling."""

    async def said_after() -> bytes:
        board = BoardPort()
        through = at_board(board)
        talk = asyncio.create_task(through.talk(chatter()))
        await asyncio.sleep(0.001)
        through.from_board.received(b"a")
        for _ in range(turns):
            await asyncio.sleep(0)
        talk.cancel()
        said = len(board.written)
        for _ in range(20):
            await asyncio.sleep(0)
        assert talk.cancelled()
        assert not through.is_busy
        return bytes(board.written[said:])

    assert asyncio.run(said_after()) == b""


def test_a_look_that_waits_for_nothing_answers_the_time_now() -> None:
    """Bytes that came before are not the answer: they would tell an older time."""

    def dialogue() -> Dialogue[list[Heard]]:
        yield Send(b"x")
        now = yield Listen(0)
        later = yield Listen(NS_PER_MS)
        return [now, later]

    async def heard() -> list[Heard]:
        through = at_board(BoardPort())
        talk = asyncio.create_task(through.talk(dialogue()))
        await asyncio.sleep(0)
        through.from_board.received(b"late")
        return await talk

    now, later = asyncio.run(heard())
    assert now.data == b""
    assert later.data in (b"late", b"")
