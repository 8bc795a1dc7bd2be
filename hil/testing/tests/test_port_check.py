"""Check of ports: what it lets pass, and what it says of those that are broken."""

import asyncio
import socket
import time
from collections.abc import Callable
from pathlib import Path
from typing import ClassVar

import pytest

from hil.testing import CheckFailed, check_port
from hil.vocab.ports import Port, PortHost, PortStats

pytestmark = pytest.mark.long

PATIENCE_S = 0.5
HELD_BYTES = 1 << 17


class Small:
    """A good port: one client at a time at a socket. ``stats`` is counted as ``PortStats`` says."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.listener: socket.socket | None = None
        self.client: socket.socket | None = None
        self.out = bytearray()
        self.is_held = False
        self.connects = self.rx = self.tx = self.dropped = self.unheard = 0

    @property
    def address(self) -> str:
        assert self.listener
        return "socket://127.0.0.1:{1}".format(*self.listener.getsockname())

    async def open(self, host: PortHost) -> None:
        self.host, self.loop = host, asyncio.get_running_loop()
        self.listener = socket.create_server(("127.0.0.1", 0))
        self.listener.setblocking(False)
        self.loop.add_reader(self.listener, self.accept)

    def accept(self) -> None:
        assert self.listener
        if self.client:
            self.leave()
        self.client, _ = self.listener.accept()
        self.client.setblocking(False)
        self.connects += 1
        self.loop.add_reader(self.client, self.readable)

    def readable(self) -> None:
        assert self.client
        if not (room := self.host.room()):
            self.is_held = True
            self.loop.remove_reader(self.client)
            return
        try:
            data = self.client.recv(min(room, 4096))
        except OSError:
            data = b""
        if data:
            self.rx += len(data)
            self.host.received(data)
        else:
            self.leave()

    def leave(self) -> None:
        assert self.client
        self.loop.remove_reader(self.client)
        self.loop.remove_writer(self.client)
        self.client.close()
        self.client = None
        self.dropped += len(self.out)
        self.out.clear()
        self.host.client_left(None)

    def write(self, data: bytes) -> None:
        if self.client is None:
            self.unheard += len(data)
            return
        taken = data[: HELD_BYTES - len(self.out)]
        self.dropped += len(data) - len(taken)
        self.out += taken
        self.writable()

    def writable(self) -> None:
        assert self.client
        try:
            sent = self.client.send(self.out)
        except BlockingIOError:
            sent = 0
        except OSError:
            self.leave()
            return
        self.tx += sent
        del self.out[:sent]
        if self.out:
            self.loop.add_writer(self.client, self.writable)
        else:
            self.loop.remove_writer(self.client)

    def resume_reading(self) -> None:
        if self.is_held and self.client:
            self.is_held = False
            self.loop.add_reader(self.client, self.readable)

    def backlog(self) -> int:
        return len(self.out)

    def client_baud(self) -> int | None:
        return None

    def stats(self) -> PortStats:
        here = int(self.client is not None)
        return PortStats(here, self.connects, self.rx, self.tx, self.dropped, self.unheard)

    async def close(self) -> None:
        if self.client:
            self.leave()
        if self.listener:
            self.loop.remove_reader(self.listener)
            self.listener.close()
            self.listener = None


class Nameless(Small):
    """Port without an address."""

    address = ""


class SevenBits(Small):
    """Port that strips the parity bit that nobody sent."""

    def write(self, data: bytes) -> None:
        super().write(bytes(byte & 0x7F for byte in data))


class Lines(Small):
    """Port that loses what is not a whole burst."""

    def write(self, data: bytes) -> None:
        super().write(data if len(data) > 1 else b"")


class Greedy(Small):
    """Port that reads on where there is no room."""

    def readable(self) -> None:
        assert self.client
        if data := self.client.recv(4096):
            self.rx += len(data)
            self.host.received(data)
        else:
            self.leave()


class Deaf(Small):
    """Port that never reads on."""

    def resume_reading(self) -> None:
        """Ignored: this is the fault."""


class Endless(Small):
    """Port that keeps everything for a client that does not read."""

    def write(self, data: bytes) -> None:
        if self.client is None:
            super().write(data)
        else:
            self.out += data
            self.writable()


class Forgetful(Small):
    """Port that does not count what it drops."""

    def leave(self) -> None:
        self.out.clear()
        super().leave()


class Blocking(Small):
    """Port that waits until its client has read."""

    has_waited = False

    def write(self, data: bytes) -> None:
        super().write(data)
        if self.out and not self.has_waited:
            time.sleep(1.1)
            self.has_waited = True


class Answering(Small):
    """Port that keeps what was for nobody, for whoever comes."""

    def __init__(self, folder: Path) -> None:
        super().__init__(folder)
        self.kept = b""

    def write(self, data: bytes) -> None:
        if self.client is None:
            self.kept += data
        super().write(data)

    def accept(self) -> None:
        super().accept()
        kept, self.kept = self.kept, b""
        self.write(kept)


class Uncounting(Small):
    """Port that does not count what was for nobody."""

    def write(self, data: bytes) -> None:
        if self.client is not None:
            super().write(data)


class Delicate(Small):
    """Port that gives up when much comes that it does not know."""

    def readable(self) -> None:
        super().readable()
        if self.rx > 20_000:
            self.host.port_failed("what is that?")


class Once(Small):
    """Port that serves one client, and no other."""

    def accept(self) -> None:
        if self.connects:
            assert self.listener
            self.listener.accept()[0].close()
        else:
            super().accept()


class Counting(Small):
    """Port that counts on where another port ended."""

    before: ClassVar[list[int]] = [0]

    def stats(self) -> PortStats:
        self.before[0] += 1
        stats = super().stats()
        return PortStats(stats.clients, stats.connects + self.before[0] // 2, stats.rx_bytes, 0, 0, 0)


class Open(Small):
    """Port that leaves its socket open."""

    kept: socket.socket | None = None

    async def close(self) -> None:
        self.kept, self.listener = self.listener or self.kept, None
        await super().close()


class Busy(Small):
    """Port that leaves a task behind."""

    async def open(self, host: PortHost) -> None:
        await super().open(host)
        self.task = self.loop.create_task(asyncio.sleep(100), name="watcher")


class Littering(Small):
    """Port that leaves a file behind."""

    async def open(self, host: PortHost) -> None:
        await super().open(host)
        (self.folder / "m1.lock").touch()


class Final(Small):
    """Port that fails if it is closed twice."""

    async def close(self) -> None:
        assert self.listener, "it is closed"
        await super().close()


class Raising(Small):
    """Port that raises when a client leaves."""

    def leave(self) -> None:
        super().leave()
        raise RuntimeError("nobody there")


BROKEN: dict[Callable[[Path], Port], tuple[str, str]] = {
    Nameless: ("opened", "it has no address"),
    SevenBits: ("bytes", "the device sent"),
    Lines: ("chunking", "the client got"),
    Greedy: ("limits", "hands over"),
    Deaf: ("limits", "the device got"),
    Endless: ("limits", "wait for a client"),
    Forgetful: ("limits", "are counted"),
    Blocking: ("time", "a write to a client"),
    Answering: ("silence", "sent before it came"),
    Uncounting: ("silence", "counted as unheard"),
    Delicate: ("garbage", "what is that?"),
    Once: ("reset", ""),
    Raising: ("reset", "RuntimeError: nobody there"),
    Counting: ("replay", "the same again"),
    Open: ("left", "file descriptors"),
    Busy: ("left", "watcher"),
    Littering: ("left", "m1.lock"),
    Final: ("left", "it is closed"),
}


@pytest.mark.thorough
def test_a_good_port_passes() -> None:
    check_port(Small, held_bytes=HELD_BYTES)


@pytest.mark.thorough
@pytest.mark.filterwarnings("ignore::ResourceWarning")
@pytest.mark.parametrize("broken", BROKEN, ids=lambda broken: broken.__name__)
def test_a_broken_one_is_found_by_the_word_for_it(broken: Callable[[Path], Port]) -> None:
    word, said = BROKEN[broken]
    with pytest.raises(CheckFailed) as failed:
        check_port(broken, held_bytes=HELD_BYTES, patience_s=PATIENCE_S, only=word)
    (finding,) = [each for each in failed.value.findings if each.startswith(f"{word}: ")]
    assert said in finding
