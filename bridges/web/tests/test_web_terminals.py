"""Terminals of pages at a port, whose board is the test itself: the other end of a pty."""

import asyncio
import os
import struct
import tty
from collections.abc import Awaitable, Callable, Iterator
from contextlib import suppress
from typing import Any

import pytest
from pages_of_tests import LISTED, PACKED, Door, PagesDesk, frame, opened, raw_page

from bridges.web.web_messages import TIMED, TIMED_HEAD
from bridges.web.web_terminals import TYPED_BYTES
from hil.testing.checks.recording_desk import NOW_NS

ROW = {"device": "m1", "port": "pty", "address": "", "clients": 0, "ports": {}}


@pytest.fixture
def board() -> Iterator[tuple[int, str]]:
    """The board's end of a pty, and the path of the clients' end, which somebody else keeps open."""
    ours, theirs = os.openpty()
    tty.setraw(theirs)
    os.set_blocking(ours, False)
    path = os.ttyname(theirs)
    os.close(theirs)
    try:
        yield ours, path
    finally:
        os.close(ours)


def run(path: str, use: Callable[[Door], Awaitable[None]], kind: str = "pty") -> None:
    async def main() -> None:
        tap = {"tap": "bus0.t", "kind": kind, "port": path, "clients": 0}
        answers = {"list": {**LISTED, "devices": [{**ROW, "address": path}], "taps": [tap]}}
        async with opened(PagesDesk(answers)) as door:
            await use(door)

    asyncio.run(main())


def head(number: int) -> bytes:
    return struct.pack("<BBHI", 2, 0, 0, number)


def is_of(number: int) -> Callable[[Any], bool]:
    return lambda each: isinstance(each, bytes) and each.startswith(head(number))


async def read(door: Door, fd: int, size: int) -> bytes:
    """What a board gets, so many bytes."""
    data = b""

    def have_all() -> bool:
        nonlocal data
        with suppress(OSError):
            data += os.read(fd, 65536)
        return len(data) >= size

    await door.until(have_all)
    return data


def test_all_pages_at_a_port_type_and_see_the_same(board: tuple[int, str]) -> None:
    fd, path = board
    said = b"\x1b[31m\xff\xfe\x00<script>\x9b"

    async def use(door: Door) -> None:
        async with door.page() as one, door.page() as other:
            assert await one.ask("open", port="m1") == {"terminal": 1, "clients": 0}
            assert await other.ask("open", port="m1") == {"terminal": 1, "clients": 0}
            assert await one.ask("open", port="m1") == {"terminal": 2, "clients": 0}
            os.write(fd, said)
            for page, number in ((one, 1), (one, 2), (other, 1)):
                assert await page.until(is_of(number)) == head(number) + said
            await one.socket.send_bytes(head(2) + b"a\x00")
            assert await read(door, fd, 2) == b"a\x00"
            await other.socket.send_bytes(head(1) + b"b\xff")
            assert await read(door, fd, 2) == b"b\xff"
            await one.ask("close", terminal=1)
            await one.socket.send_bytes(head(1) + b"not typed")
            await one.socket.send_bytes(head(2) + b"c")
            assert await read(door, fd, 1) == b"c"

    run(path, use)


def test_a_port_that_goes_closes_its_terminals(board: tuple[int, str]) -> None:
    _, path = board

    async def use(door: Door) -> None:
        async with door.page() as page:
            await page.ask("open", port="m1")
            port = next(iter(door.bridge._pages._around.ports._open.values()))  # type: ignore[attr-defined]
            port.close("m1 has gone")
            assert await page.until(lambda each: "closed" in each) == {
                "closed": {"terminal": 1, "why": "m1 has gone"}
            }
            assert (await page.ask("open", port="m1"))["terminal"] == 2

    run(path, use)


def test_a_board_that_takes_nothing_loses_the_terminal_and_nothing_waits(board: tuple[int, str]) -> None:
    _, path = board

    async def use(door: Door) -> None:
        async with door.page() as page:
            await page.ask("open", port="m1")
            for _ in range(TYPED_BYTES // 16384 + 2):
                await page.socket.send_bytes(head(1) + b"x" * 16384)
            closed = (await page.until(lambda each: "closed" in each))["closed"]
            assert closed == {"terminal": 1, "why": "m1 has not taken what was typed"}
            assert await page.ask("ask", operation="faults") == []

    run(path, use)


def test_with_details_what_comes_has_its_time_and_what_is_taken_is_told(board: tuple[int, str]) -> None:
    fd, path = board

    async def use(door: Door) -> None:
        async with door.page() as page, door.page() as other:
            await page.ask("open", port="m1", details=True)
            await other.ask("open", port="m1")
            os.write(fd, b"hello")
            timed = await page.until(lambda each: isinstance(each, bytes) and each[0] == TIMED)
            assert timed == TIMED_HEAD.pack(TIMED, 0, 0, 1, NOW_NS / 1e9) + b"hello"
            assert await other.until(is_of(1)) == head(1) + b"hello"
            # More than the port takes at once: it is told as far as it is taken, and not what others type.
            await page.socket.send_bytes(head(1) + b"x" * 20_000)
            await other.socket.send_bytes(head(1) + b"y" * 7)
            first = (await page.until(lambda each: isinstance(each, dict) and "taken" in each))["taken"]
            assert first["terminal"] == 1
            assert 0 < first["bytes"] < 20_000
            assert len(await read(door, fd, 20_007)) == 20_007
            last = {"taken": {"terminal": 1, "bytes": 20_000}}
            assert await page.until(lambda each: each == last) == last
            assert not [each for each in other.pushed if isinstance(each, dict)]

    run(path, use)


def test_a_page_that_does_not_read_holds_up_no_board(board: tuple[int, str]) -> None:
    fd, path = board

    async def use(door: Door) -> None:
        deaf, loop = await raw_page(door.url), asyncio.get_running_loop()
        await loop.sock_sendall(deaf, frame('{"id": 1, "do": "open", "port": "m1"}'))
        async with door.page() as page:
            await page.ask("open", port="m1")
            watch = '{"id": 2, "do": "watch", "what": "samples", "target": "m1", "fields": ["x", "r", "n"]}'
            await loop.sock_sendall(deaf, frame(watch))
            door.desk.endless = [PACKED.pack(0, 0, 0, 0)] * 2000
            await door.until(lambda: door.bridge.status()["dropped"] > 0)
            for number in range(50):
                os.write(fd, struct.pack("<I", number))
                heard = b""
                while len(heard) < 4:
                    heard += (await page.until(is_of(1)))[8:]
                assert heard == struct.pack("<I", number)
            clients = door.bridge._pages._clients  # type: ignore[attr-defined]
            assert sorted(len(client._terminals._open) for client in clients) == [0, 1]
        deaf.close()

    run(path, use)


@pytest.mark.parametrize(
    ("port", "kind", "code", "why"),
    [
        ("m9", "pty", "no_place", "there is no port 'm9'; there are m1, bus0.t"),
        ("bus0.t", "serial", "cannot", "bus0.t is at the other end of "),
        ("bus0.t", "pty", "not_now", "/dev/null/nothing: "),
    ],
)
def test_what_cannot_be_opened_is_refused(port: str, kind: str, code: str, why: str) -> None:
    async def use(door: Door) -> None:
        async with door.page() as page:
            refused = await page.ask("open", port=port)
            assert (refused["code"], why in refused["message"]) == (code, True), refused

    run("/dev/null/nothing", use, kind)
