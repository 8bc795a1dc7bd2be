"""Reports that are made in pieces, once for all who ask meanwhile."""

import asyncio
from collections.abc import Callable, Iterator
from typing import Any

from hil.vocab.desk_protocol import Encoded
from hil.wire.json_text import json_pieces

PIECE_S = 0.002
"""Time after which others have their turn."""
PART_BYTES = 1 << 16


class SharedReport:
    """Report as JSON. ``made``: answers an iterator that yields None where others may have their turn, and
    the report at last. Each asker gets one that was begun after the question; one is made at a time."""

    def __init__(self, made: Callable[[], Iterator[Any]]) -> None:
        self._made = made
        self._turn = asyncio.Lock()
        self._next: asyncio.Task[Encoded] | None = None

    async def read(self) -> Encoded:
        """Make the report, or wait for the next one, which others wait for already."""
        if self._next is None:
            self._next = asyncio.get_running_loop().create_task(self._make())
        return await asyncio.shield(self._next)

    async def _make(self) -> Encoded:
        async with self._turn:
            self._next = None  # who asks from now on gets another one
            loop = asyncio.get_running_loop()
            parts, part, began_s = list[bytes](), bytearray(), loop.time()
            for piece in self._pieces():
                part += piece
                if len(part) > PART_BYTES:
                    parts.append(bytes(part))
                    part.clear()
                if loop.time() - began_s > PIECE_S:
                    await asyncio.sleep(0)
                    began_s = loop.time()
            return Encoded((*parts, bytes(part)))

    def _pieces(self) -> Iterator[bytes]:
        content: Any = None
        for content in self._made():
            if content is None:
                yield b""
        yield from json_pieces(content)
