"""Terminals of pages at ports. All pages at a port share one client of it, so that each sees the same."""

import asyncio
import json
import os
from collections import deque
from collections.abc import Callable, Mapping
from contextlib import ExitStack, suppress
from functools import partial
from inspect import isawaitable
from typing import Any

from bridges.web.outbox import Outbox
from bridges.web.page_rows import TerminalAnswer
from bridges.web.web_messages import FLAG, NAME, WHOLE, taken, terminal_message, timed_message
from hil.net.port_client import PortUnreachable, opened_port
from hil.vocab.desk_protocol import Desk, Encoded, Source
from hil.vocab.near_words import meant
from hil.vocab.port_programs import is_held
from hil.vocab.verbs import Role, VerbRefused
from hil.wire.json_text import json_text

MOST_TERMINALS = 32
TYPED_BYTES = 64 * 1024
"""Maximum of what is typed and waits for a board to take it."""
_PIECE = 4096
Hear = Callable[[bytes], None]
"""Called with what a port says."""
Gone = Callable[[str], None]
"""Called with the reason why a port is closed."""
Took = Callable[[int], object]
"""Called with how many more bytes of a page's a port has taken."""


class SharedPort:
    """Client of a port, for all pages. It always reads: a page that does not never holds up the board."""

    def __init__(self, name: str, ended: Callable[["SharedPort"], None]) -> None:
        self.name = name
        self._ended = ended
        self._loop = asyncio.get_running_loop()
        self._resources = ExitStack()
        self._fd = -1
        self._typed = bytearray()
        self._typists = deque[list[Any]]()
        """Pieces that wait: the number of bytes of each, and who is told that they are taken."""
        self.listeners: dict[Hear, Gone] = {}

    async def open(self, address: str) -> None:
        """Open the port. Raises VerbRefused: it cannot be."""
        try:
            self._fd = await asyncio.to_thread(self._resources.enter_context, opened_port(address))
        except PortUnreachable as error:
            raise VerbRefused("not_now", str(error)) from None
        os.set_blocking(self._fd, False)
        self._loop.add_reader(self._fd, self._readable)

    def write(self, data: bytes, took: Took) -> None:
        """Type at the port. What the board does not take waits; of too much the port is closed."""
        if self._fd < 0 or not data:
            return
        if not self._typed:
            self._loop.add_writer(self._fd, self._writable)
        self._typed += data
        self._typists.append([len(data), took])
        self._writable()
        if len(self._typed) > TYPED_BYTES:
            self.close(f"{self.name} has not taken what was typed")

    def _writable(self) -> None:
        try:
            with suppress(BlockingIOError):
                while self._typed:
                    written = os.write(self._fd, self._typed)
                    del self._typed[:written]
                    self._tell_typists(written)
        except OSError as error:
            self.close(f"{self.name}: {error.strerror}")
            return
        if not self._typed:
            self._loop.remove_writer(self._fd)

    def _tell_typists(self, written: int) -> None:
        while written:
            waiting, took = self._typists[0]
            took(taken := min(waiting, written))
            written -= taken
            self._typists[0][0] -= taken
            if not self._typists[0][0]:
                self._typists.popleft()

    def _readable(self) -> None:
        try:
            data = os.read(self._fd, _PIECE)
        except BlockingIOError:
            return  # another client of the port was quicker
        except OSError:
            data = b""
        if not data:
            self.close(f"{self.name} has gone")
            return
        for hear in list(self.listeners):
            hear(data)

    def close(self, why: str) -> None:
        """Close the port, and tell those who listen why."""
        if self._fd < 0:
            return
        self._loop.remove_reader(self._fd)
        self._loop.remove_writer(self._fd)
        self._fd = -1
        # A client of RFC 2217 waits for its last bytes to leave.
        self._loop.run_in_executor(None, self._resources.close)
        self._ended(self)
        for gone in list(self.listeners.values()):
            gone(why)
        self.listeners.clear()


class SharedPorts:
    """Ports that pages have open."""

    def __init__(self) -> None:
        self._open: dict[str, SharedPort] = {}
        self._opening = asyncio.Lock()

    async def join(self, name: str, address: str, hear: Hear, gone: Gone) -> SharedPort:
        """Listen at a port, which is opened for the first. Raises VerbRefused: it cannot be opened."""
        async with self._opening:
            if (port := self._open.get(name)) is None:
                port = SharedPort(name, self._ended)
                await port.open(address)
                self._open[name] = port
            port.listeners[hear] = gone
            return port

    def leave(self, port: SharedPort, hear: Hear) -> None:
        """Listen no more; the last one closes the port."""
        port.listeners.pop(hear, None)
        if not port.listeners:
            port.close("")

    def close(self) -> None:
        for port in list(self._open.values()):
            port.close("the bench has ended")

    def _ended(self, port: SharedPort) -> None:
        self._open.pop(port.name, None)


class PageTerminals:
    """Terminals of one page."""

    def __init__(self, desk: Desk, source: Source, ports: SharedPorts, outbox: Outbox) -> None:
        self._desk, self._source, self._ports, self._outbox = desk, source, ports, outbox
        self._open: dict[int, tuple[SharedPort, Hear]] = {}
        self._taken: dict[int, int] = {}
        """Bytes that ports have taken, of the terminals that are told."""
        self._last = 0
        self._is_closed = False

    async def open(self, given: Mapping[str, Any]) -> TerminalAnswer:
        """Open a terminal at a port; answers its number, and how many other clients the port has. With
        ``details`` the page gets times of what the port says, and how much it has taken.

        Raises:
            VerbRefused: there is no such port, it cannot be opened, or the user may only look on.
        """
        values = taken(given, {"port": NAME, "details": FLAG}, {"details": False})
        name, has_details = values["port"], values["details"]
        if self._source.role < Role.OPERATOR:
            raise VerbRefused("forbidden", "open needs the role operator")
        if len(self._open) >= MOST_TERMINALS:
            raise VerbRefused("not_now", f"{MOST_TERMINALS} terminals are open already; close one")
        address, clients = await self._place(name)
        self._last += 1
        number, clock = self._last, self._desk.describe().clock

        def hear(data: bytes) -> None:
            if self._outbox.is_full:
                self._end(number, "what it said was not read")
            elif has_details:
                self._outbox.put(timed_message(number, clock.times_ns()[0], data))
            else:
                self._outbox.put(terminal_message(number, data))

        port = await self._ports.join(name, address, hear, lambda why: self._end(number, why))
        if self._is_closed:  # the page has gone meanwhile
            self._ports.leave(port, hear)
        else:
            self._open[number] = port, hear
            if has_details:
                self._taken[number] = 0
        return {"terminal": number, "clients": clients}

    def typed(self, number: int, data: bytes) -> None:
        """Type at a terminal; one that is closed takes nothing."""
        if found := self._open.get(number):
            found[0].write(data, partial(self._took, number))

    def _took(self, number: int, more: int) -> None:
        if number in self._taken:
            self._taken[number] += more
            self._outbox.put(json_text({"taken": {"terminal": number, "bytes": self._taken[number]}}))

    def close(self, given: Mapping[str, Any]) -> dict[str, Any]:
        """Close a terminal, also one that is closed."""
        self._leave(taken(given, {"terminal": WHOLE}, {})["terminal"])
        return {}

    def close_all(self) -> None:
        self._is_closed = True
        for number in list(self._open):
            self._leave(number)

    def _leave(self, number: int) -> None:
        self._taken.pop(number, None)
        if found := self._open.pop(number, None):
            self._ports.leave(*found)

    def _end(self, number: int, why: str) -> None:
        if number in self._open:
            self._leave(number)
            self._outbox.put(json_text({"closed": {"terminal": number, "why": why}}))

    async def _place(self, name: str) -> tuple[str, int]:
        """Address of a port, and how many clients it has."""
        listed = self._desk.ask(self._source, "list", "", {})
        if isawaitable(listed):
            listed = await listed
        if isinstance(listed, Encoded):
            listed = json.loads(b"".join(listed.parts))
        rows: dict[str, Mapping[str, Any]] = {
            row["device"]: {**row, "kind": row["port"]} for row in listed["devices"] if row["address"]
        }
        for row in listed["devices"]:
            rows |= row["ports"]
        rows |= {row["tap"]: {**row, "address": row["port"]} for row in listed["taps"]}
        if name not in rows:
            raise VerbRefused("no_place", f"there is no port {name[:80]!r}; {meant(name, rows)}")
        row = rows[name]
        if is_held(row["kind"]):
            raise VerbRefused(
                "cannot", f"{name} is at the other end of {row['address']}: hil itself has it open"
            )
        return row["address"], row["clients"]
