"""Check of bridges: what it lets pass, and what it says of those that are broken."""

import asyncio
import gc
import itertools
import threading
import time
from collections.abc import Callable, Collection, Mapping
from typing import Any

import pytest

from hil.testing import CheckFailed, check_bridge
from hil.vocab.bridge_protocol import Bridge
from hil.vocab.desk_protocol import Desk, Source, Watched
from hil.vocab.verbs import Role, VerbRefused

pytestmark = pytest.mark.long

SOURCE = Source("lines", Role.OPERATOR)
REQUEST = b"m1 wave\n"
MOST_CLIENTS, LINE_BYTES = 32, 1024
PATIENCE_S = 2.0


class Lines:
    """A good bridge: ``m1 wave`` is answered with ``ok`` or with why not."""

    def __init__(self, desk: Desk) -> None:
        self.desk = desk
        self.server: asyncio.Server | None = None
        self.writers: set[asyncio.StreamWriter] = set()
        self.at = 0
        self.watch: Any = None

    async def open(self) -> None:
        self.server = await asyncio.start_server(self.served, "127.0.0.1", self.at, limit=LINE_BYTES)
        self.at = self.server.sockets[0].getsockname()[1]
        self.watch = self.desk.watch(SOURCE, Watched.RUNS, "", lambda progress: None)

    async def served(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        if len(self.writers) >= MOST_CLIENTS:
            writer.transport.abort()
            return
        self.writers.add(writer)
        try:
            while line := await reader.readline():
                writer.write(self.answer(line).encode() + b"\n")
                await writer.drain()
        except (OSError, ValueError):
            """Client that left, or says too much."""
        finally:
            self.writers.discard(writer)
            writer.transport.abort()

    def answer(self, line: bytes) -> str:
        device, _, verb = line.decode(errors="replace").strip().partition(" ")
        try:
            self.desk.ask(SOURCE, "do", device, {"name": verb, "parameters": {}})
        except VerbRefused as refusal:
            return f"{refusal.code}: {refusal}"
        return "ok"

    async def close(self) -> None:
        self.watch.close()
        assert self.server
        self.server.close()
        for writer in list(self.writers):
            writer.transport.abort()
        await self.server.wait_closed()

    async def devices_changed(self, names: Collection[str]) -> None:
        """Ignored: each line asks what there is."""

    def status(self) -> Mapping[str, Any]:
        return {
            "root": "lines",
            "listen": [f"127.0.0.1:{self.at}"],
            "connect": [],
            "links": len(self.writers),
            "insecure": False,
        }


class Untold(Lines):
    """Bridge whose status does not say whether it is insecure."""

    def status(self) -> Mapping[str, Any]:
        return {name: value for name, value in super().status().items() if name != "insecure"}


class Unwritable(Lines):
    """Bridge with something in its status that is no JSON."""

    def status(self) -> Mapping[str, Any]:
        return {**super().status(), "clients": self.writers}


class Mute(Lines):
    """Bridge that answers nobody."""

    async def served(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        await reader.read()
        writer.transport.abort()


class Whole(Lines):
    """Bridge that takes each read for a line."""

    async def served(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        while piece := await reader.read(LINE_BYTES):
            writer.write(self.answer(piece).encode() + b"\n")
        writer.transport.abort()


class Eager(Lines):
    """Bridge that waves by itself."""

    async def open(self) -> None:
        await super().open()
        self.answer(REQUEST)


class Guessing(Lines):
    """Bridge that takes whatever it does not know for the usual."""

    def answer(self, line: bytes) -> str:
        return super().answer(line if line.startswith(b"m") else REQUEST)


class Ascii(Lines):
    """Bridge that expects nothing but ASCII."""

    def answer(self, line: bytes) -> str:
        line.decode("ascii")
        return super().answer(line)

    async def served(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        while line := await reader.read(LINE_BYTES):
            writer.write(self.answer(line).encode() + b"\n")
        writer.transport.abort()


class Sulking(Lines):
    """Bridge that answers nobody any more when it was refused something."""

    is_offended = False

    def answer(self, line: bytes) -> str:
        if self.is_offended:
            raise ValueError
        said = super().answer(line)
        self.is_offended = said != "ok"
        return said


class Surprised(Lines):
    """Bridge that fails when a board is removed."""

    async def devices_changed(self, names: Collection[str]) -> None:
        for name in names:
            self.desk.describe().devices[name]


class Counting(Lines):
    """Bridge that counts on where another bridge ended."""

    number = itertools.count()

    async def open(self) -> None:
        await super().open()
        self.mine = next(self.number)

    def answer(self, line: bytes) -> str:
        return f"{super().answer(line)} {self.mine}"


class Numbering(Lines):
    """Bridge that never gives the same answer twice."""

    number = 0

    def answer(self, line: bytes) -> str:
        self.number += 1
        return f"{super().answer(line)} {self.number}"


class Blocking(Lines):
    """Bridge that blocks the event loop for 1.5 s."""

    has_thought = False

    def answer(self, line: bytes) -> str:
        if not self.has_thought:
            self.has_thought = True
            time.sleep(1.5)
        return super().answer(line)


class Hospitable(Lines):
    """Bridge that lets everybody stay."""

    async def served(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        kept, self.writers = self.writers, set()
        try:
            await super().served(reader, writer)
        finally:
            self.writers = kept


class Patient(Lines):
    """Bridge that waits for a line's end, however long it is."""

    async def served(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        self.writers.add(writer)
        line = b""
        while len(self.writers) < MOST_CLIENTS and (piece := await reader.read(LINE_BYTES)):
            line += piece
            if line.endswith(b"\n"):
                writer.write(self.answer(line).encode() + b"\n")
                line = b""
        self.writers.discard(writer)
        writer.transport.abort()


class Watching(Lines):
    """Bridge that leaves its watch open."""

    async def close(self) -> None:
        self.watch = self.desk.watch(SOURCE, Watched.RUNS, "", lambda progress: None)
        await super().close()


class Busy(Lines):
    """Bridge that leaves a task behind."""

    async def open(self) -> None:
        await super().open()
        self.task = asyncio.create_task(asyncio.sleep(100), name="watcher")


class Threaded(Lines):
    """Bridge that leaves a thread behind."""

    async def open(self) -> None:
        await super().open()
        self.thread = threading.Thread(target=time.sleep, args=(4,), name="worker", daemon=True)
        self.thread.start()


class Open(Lines):
    """Bridge that leaves a socket open."""

    async def open(self) -> None:
        await super().open()
        self.reader, self.writer = await asyncio.open_connection("127.0.0.1", self.at)

    async def close(self) -> None:
        assert self.server
        self.watch.close()
        self.server.close()


BROKEN: dict[Callable[[Desk], Bridge], tuple[str, str]] = {
    Untold: ("opened", "has no insecure"),
    Unwritable: ("opened", "cannot be written"),
    Mute: ("answer", "was not answered"),
    Whole: ("chunking", "byte by byte"),
    Eager: ("silence", "nobody asked"),
    Guessing: ("garbage", "it carried out [('m1', 'wave')"),
    Ascii: ("garbage", "UnicodeDecodeError"),
    Sulking: ("refusal", "answered with nothing"),
    Surprised: ("devices", "KeyError: 'm1'"),
    Counting: ("reset", "made again"),
    Numbering: ("replay", "asked again"),
    Blocking: ("time", "held up the event loop for "),
    Hospitable: ("limits", "of 150 silent clients"),
    Patient: ("limits", "a request that has no end"),
    Watching: ("left", "1 watches"),
    Busy: ("left", "watcher"),
    Threaded: ("left", "worker"),
    Open: ("left", ""),
}


def test_a_good_bridge_passes() -> None:
    check_bridge(Lines, request=REQUEST)


@pytest.mark.thorough
@pytest.mark.filterwarnings("ignore::ResourceWarning", "ignore::pytest.PytestUnraisableExceptionWarning")
@pytest.mark.parametrize("broken", BROKEN, ids=lambda broken: broken.__name__)
def test_a_broken_one_is_found_by_the_word_for_it(broken: Callable[[Desk], Bridge]) -> None:
    word, said = BROKEN[broken]
    only = "answer" if word == "time" else word
    with pytest.raises(CheckFailed) as failed:
        check_bridge(broken, request=REQUEST, patience_s=PATIENCE_S, only=only)
    gc.collect()  # what it has left open
    (finding,) = [each for each in failed.value.findings if each.startswith(f"{word}: ")]
    assert said in finding
