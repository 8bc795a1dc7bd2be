"""Joins one port to one device: here a byte changes hands. ``docs/follow-a-byte.md`` walks this file.

In:  port -> ``Session.received`` -> ``BenchRuntime.give`` -> device's UART -> firmware.
Out: firmware -> device's UART -> ``Session.send`` -> port.
"""

import asyncio
from collections import deque
from collections.abc import Callable
from typing import Protocol

from hil.sim.bench import BenchRuntime
from hil.sim.device import Device
from hil.sim.inputs import Bytes, Reset
from hil.vocab.firmware import MAIN
from hil.vocab.ports import Port, Tap
from hil.vocab.time import FOREVER, SimTimeNs
from hil.vocab.verbs import VerbRefused
from hil.wire.serial_line import character_ns, resample

BACKLOG_HOLD_BYTES = 64 * 1024
"""While more than this waits for a client to read, the device takes no more commands: a board is held
up in print() by a host that does not read."""

TYPED_BYTES = 4096
"""What may wait of what was typed beside the port; the longest text of the verb ``type``."""
TOUCH_BAUD = 1200
"""A board with native USB resets when its port is closed at this rate: Arduino platform specification, "1200
bps bootloader reset"; CDC.cpp of the Arduino SAMD core. The core waits 250 ms before, and
the bootloader runs first."""


class HasLine(Protocol):
    """A session whose line can have something new."""

    def flush(self) -> None:
        """Put what was sent on the line."""

    def release(self, now_ns: SimTimeNs) -> SimTimeNs:
        """Hand the port what is complete by ``now_ns``; answers when the next is due."""

    def refresh(self) -> None:
        """Let the port read on if it was held up and there is room again."""


class Lines:
    """The paced lines of a bench: of hundreds, only those with something on them are looked at. ``scheduled``
    is called when bytes were put on one, for ``release`` to be called in time; ``soon`` calls what it is
    given when the present turns of groups are over."""

    def __init__(self, scheduled: Callable[[], None], soon: Callable[[Callable[[], None]], object]) -> None:
        self._scheduled = scheduled
        self._soon = soon
        self._is_handing_on = False
        self.fresh: list[HasLine] = []
        """Those whose device has sent something since the last ``flush``."""
        self._busy: dict[HasLine, None] = {}
        self._held: dict[HasLine, None] = {}

    def schedule(self, session: HasLine) -> None:
        """A session has something to do at a time that its ``release`` says."""
        self._busy[session] = None
        self._scheduled()

    def hold(self, session: HasLine, is_held: bool) -> None:
        """A session's port may read nothing for now, or it may again."""
        if is_held:
            self._held[session] = None
        else:
            self._held.pop(session, None)

    def turn_over(self) -> None:
        """Firmware may have run (``BenchRuntime.turn_over``): soon, once for all turns until then, what it
        sent goes on, and ports read what it has room for."""
        if (self.fresh or self._held) and not self._is_handing_on:
            self._is_handing_on = True
            self._soon(self._hand_on)

    def _hand_on(self) -> None:
        self._is_handing_on = False
        self.flush()
        self.refresh()

    def flush(self) -> None:
        """Put what devices have sent on their lines."""
        if self.fresh:
            fresh, self.fresh = self.fresh, []
            for session in fresh:
                session.flush()
                self._busy[session] = None
            self._scheduled()

    def release(self, now_ns: SimTimeNs) -> SimTimeNs:
        """Hand ports what is complete by ``now_ns``; answers when the next is due."""
        next_ns = FOREVER
        for session in list(self._busy):
            if (due_ns := session.release(now_ns)) == FOREVER:
                self._busy.pop(session, None)
            next_ns = min(next_ns, due_ns)
        return next_ns

    def forget(self, session: HasLine) -> None:
        """It is looked at no more: what is on its line is lost."""
        self._busy.pop(session, None)
        self._held.pop(session, None)
        self.fresh = [each for each in self.fresh if each is not session]

    def refresh(self) -> None:
        """Let ports read on that were held up, where there is room again."""
        for session in list(self._held):
            session.refresh()


class Session:
    """The port's host (``hil.vocab.ports.PortHost``) and the line of one of the device's serial interfaces,
    ``uart``. ``native_usb``: the board's own processor is on the USB, and resets at ``TOUCH_BAUD``."""

    def __init__(
        self,
        bench: BenchRuntime,
        device: Device,
        port: Port,
        lines: Lines,
        *,
        native_usb: bool = False,
        uart: str = MAIN,
    ) -> None:
        self.device = device
        self.port = port
        self._name = uart
        self._uart = device.uarts[uart]
        self.port_failure: str | None = None
        self._bench = bench
        self._lines = lines
        self._native_usb = native_usb
        self.taps: list[Tap] = []
        """Called with all that passes at the port."""
        self._is_vacant = False
        self._held = False
        self._typed = bytearray()
        self._is_typing = False
        self._fresh: list[tuple[int, bytes]] = []
        self._line: deque[tuple[int, bytes]] = deque()
        self._uart.listeners.append(self.send)

    def vacate(self) -> None:
        """No board is at the port: clients are held up, what it has sent and is not out is lost."""
        self._is_vacant = True
        self._lines.forget(self)
        self._typed.clear()
        self._fresh.clear()
        self._line.clear()

    def occupy(self, device: Device, *, native_usb: bool) -> None:
        """A board is at the port from now on."""
        self._uart.listeners.remove(self.send)
        self.device, self._uart, self._native_usb = device, device.uarts[self._name], native_usb
        self._uart.listeners.append(self.send)
        self._is_vacant = self._held = False
        self.port.resume_reading()

    def received(self, data: bytes) -> None:
        """Bytes from a client: they take effect now."""
        for tap in self.taps:
            tap("board", data)
        client_baud = self.port.client_baud() if self._uart.baud else None
        self._bench.give(self.device, Bytes(data, client_baud, self._name))

    def type(self, data: bytes) -> SimTimeNs:
        """Bytes from somebody beside the port: they take effect as a client's do, the first of them now, on
        USB no more at a time than the board takes: it may have much to say to each. Answers the time.

        Raises:
            VerbRefused: too much that was typed before waits still.
        """
        if self._uart.baud is not None:
            return self._bench.give(self.device, Bytes(data, None, self._name))
        if len(self._typed) + len(data) > TYPED_BYTES:
            raise VerbRefused("not_now", f"{len(self._typed)} bytes that were typed before wait still")
        self._typed += data
        return self._bench.now_ns if self._is_typing else self._type_on()

    def _type_on(self) -> SimTimeNs:
        self._is_typing = False
        room = self.room()
        if not room or not self._typed or not self._bench.drive.is_on:
            return self._bench.now_ns
        piece = bytes(self._typed[:room])
        del self._typed[:room]
        at_ns = self._bench.give(self.device, Bytes(piece, None, self._name))
        self._go_on_typing()
        return at_ns

    def _go_on_typing(self) -> None:
        """In the next turn of the event loop, so that others have theirs between."""
        if self._typed and not self._is_typing and self.room():
            self._is_typing = True
            asyncio.get_running_loop().call_soon(self._type_on)

    def room(self) -> int:
        """What the port may read from its clients now."""
        if self._is_vacant:
            return 0
        room = 0 if self.port.backlog() > BACKLOG_HOLD_BYTES else self._uart.room()
        self._held = room == 0
        self._lines.hold(self, self._held)
        return room

    def drained(self) -> None:
        self.refresh()

    def client_left(self, baud: int | None) -> None:
        """Nobody has the port open any more."""
        if self._is_vacant:
            return
        if self._native_usb and self._uart.baud is None and baud == TOUCH_BAUD:
            self._bench.give(self.device, Reset())

    def port_failed(self, reason: str) -> None:
        self.port_failure = reason

    def refresh(self) -> None:
        if self._held and self.room():
            self.port.resume_reading()
        self._go_on_typing()

    def send(self, at_ns: SimTimeNs, data: bytes) -> None:
        """The device sends; ``Lines.flush`` comes when its group's turn is over."""
        if self._uart.baud is None:
            self._hand_over(data)
            return
        if not self._fresh:
            self._lines.fresh.append(self)
        self._fresh.append((at_ns, data))

    def _hand_over(self, data: bytes) -> None:
        for tap in self.taps:
            tap("client", data)
        self.port.write(data)

    def flush(self) -> None:
        """Put what was sent on the line, with the times at which a client's UART has each byte."""
        baud = self._uart.baud
        if not self._fresh or baud is None:
            return
        for start_ns, data in _joined(self._fresh, baud):
            client_baud = self.port.client_baud() or baud
            if client_baud == baud:
                due = ((start_ns + character_ns(i + 1, baud), data[i : i + 1]) for i in range(len(data)))
                self._line.extend(due)
                continue
            one_ns = character_ns(1, client_baud)
            for sampled in resample(data, baud, client_baud):
                self._line.append((start_ns + sampled.offset_ns + one_ns, bytes((sampled.byte,))))
        self._fresh.clear()

    def release(self, now_ns: SimTimeNs) -> SimTimeNs:
        out = bytearray()
        while self._line and self._line[0][0] <= now_ns:
            out += self._line.popleft()[1]
        if out:
            self._hand_over(bytes(out))
        return SimTimeNs(self._line[0][0]) if self._line else FOREVER


def _joined(pieces: list[tuple[int, bytes]], baud: int) -> list[tuple[int, bytes]]:
    """Pieces that follow each other without a gap, joined: a receiver sees one stream."""
    joined: list[tuple[int, bytes]] = []
    end_ns = -1
    for start_ns, data in pieces:
        if joined and start_ns <= end_ns:
            joined[-1] = (joined[-1][0], joined[-1][1] + data)
        else:
            joined.append((start_ns, data))
        end_ns = start_ns + character_ns(len(data), baud)
    return joined
