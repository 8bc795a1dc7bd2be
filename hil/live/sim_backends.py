"""Simulated backends of ports: a twin's UART, or a tap of a segment or a CAN bus."""

import asyncio
from collections import deque
from dataclasses import dataclass, field

from hil.live.lines import PacedLines
from hil.live.port_link import BACKLOG_HOLD_BYTES, PortLink
from hil.sim.bench import BenchRuntime
from hil.sim.client_tap import ClientTap
from hil.sim.flight import joined
from hil.sim.inputs import Bytes, LineOpened, Reset
from hil.sim.segment_tap import Tap
from hil.sim.twin import Twin
from hil.sim.uart import USB_HELD_BYTES
from hil.vocab.line_format import EIGHT_N_1, LineFormat
from hil.vocab.ports import TOUCH_BAUD, EchoPort, PowerPort
from hil.vocab.time import FOREVER, SimTimeNs
from hil.vocab.verbs import VerbRefused
from hil.wire.serial_line import Sampled, character_ns, resample

TYPED_BYTES = 4096
"""Maximum that waits of what was typed beside the port; the longest text of the verb ``type``."""


@dataclass(eq=False)
class UartBackend:
    """Backend at one of a twin's UARTs (``name``; empty: the first), and the line between it and the port.
    ``native_usb``: the board's own
    processor is on the USB, and resets at ``TOUCH_BAUD``."""

    bench: BenchRuntime
    lines: PacedLines
    link: "PortLink[UartBackend]"
    device: Twin
    name: str = ""
    native_usb: bool = field(default=False, kw_only=True)
    _powered: PowerPort | None = field(default=None, init=False)
    """Port that is a part of the board."""
    _typed: bytearray = field(default_factory=bytearray, init=False)
    _is_typing: bool = field(default=False, init=False)
    _fresh: list[tuple[int, bytes]] = field(default_factory=list, init=False)
    _fresh_format: LineFormat = field(default=EIGHT_N_1, init=False)
    """Format of what is in ``_fresh``."""
    _line: deque[tuple[int, bytes, Sampled | None]] = field(default_factory=deque, init=False)
    """Bytes on the line, the times at which a client's UART has them, and how it read them, if it reads
    otherwise than they were sent."""

    def __post_init__(self) -> None:
        self._uart = self.device.uarts[self.name]
        self._uart.listeners.insert(0, self.send)  # a client has its answer before it is written down
        if self.native_usb and self._uart.baud is None and isinstance(self.link.port, PowerPort):
            self._powered = self.link.port
            self._powered.power(self.device.power.is_there)
            self.device.power.listeners.append(self._tell_power)

    # ---- Backend ----

    def room(self) -> int:
        if self.link.port.backlog() > BACKLOG_HOLD_BYTES or self.bench.real_time.is_held:
            return 0
        uart = self._uart
        return uart.room_on_usb if uart.baud is None else uart.room(self.bench.now_ns)

    def hold(self, is_held: bool) -> None:
        """Hold the port up. On a line room comes with time, and no firmware has to run for it."""
        self.lines.hold(self, is_held)
        if is_held and self._uart.room_ns(self.bench.now_ns) < FOREVER:
            self.lines.schedule(self)

    def feed(self, data: bytes) -> None:
        if self.link.listeners:
            self.link.tell("board", data)
        if self._uart.baud:
            client_format = self.link.client_format()
            # A port that does not say has the board's, whatever that is: a pty's other end cannot be asked.
            ours = self._uart.format_now or EIGHT_N_1
            name = client_format.name if client_format not in (None, ours) else ""
            self.bench.apply_to(self.device, Bytes(data, self.link.port.client_baud(), self.name, name))
        else:
            self.bench.apply_to(self.device, Bytes(data, None, self.name))

    def refresh(self) -> None:
        self.link.refresh()
        self._go_on_typing()

    def client_left(self, baud: int | None) -> None:
        if self.native_usb and self._uart.baud is None and baud == TOUCH_BAUD:
            self.bench.apply_to(self.device, Reset())

    def line_opened(self) -> None:
        """Reset a board whose RESET hangs on the line."""
        if self.device.resets_when_opened:
            self.bench.apply_to(self.device, LineOpened(self.name))

    def _tell_power(self, is_on: bool) -> None:
        """Tell a port that is a part of the board of its power. With each power-up it was off before."""
        if self._powered:
            self._powered.power(False)
            self._powered.power(is_on)

    def leave(self) -> None:
        self._uart.listeners.remove(self.send)
        if self._powered:
            self.device.power.listeners.remove(self._tell_power)
        self.lines.forget(self)
        self._typed.clear()

    # ---- typing beside the port ----

    def type(self, data: bytes) -> SimTimeNs:
        """Type bytes for somebody beside the port: they take effect as a client's do, the first of them now,
        on USB no more at a time than the board takes: it may have much to say to each. Answers the time.

        Raises:
            VerbRefused: too much that was typed before waits still.
        """
        if self._uart.baud is not None:
            return self._give(data)
        if len(self._typed) + len(data) > TYPED_BYTES:
            raise VerbRefused("not_now", f"{len(self._typed)} bytes that were typed before wait still")
        self._typed += data
        return self.bench.now_ns if self._is_typing else self._type_on()

    def _type_on(self) -> SimTimeNs:
        self._is_typing = False
        if not self._typed or not self.bench.real_time.is_on or not (room := self.link.room()):
            return self.bench.now_ns
        piece = bytes(self._typed[:room])
        del self._typed[:room]
        at_ns = self._give(piece)
        self._go_on_typing()
        return at_ns

    def _give(self, data: bytes) -> SimTimeNs:
        for listener in self.link.listeners_beside:
            listener("board", data)
        return self.bench.apply_to(self.device, Bytes(data, None, self.name))

    def _go_on_typing(self) -> None:
        """Type on in the next turn of the event loop, so that others have theirs between."""
        if self._typed and not self._is_typing and self.link.room():
            self._is_typing = True
            asyncio.get_running_loop().call_soon(self._type_on)

    # ---- out ----

    def send(self, at_ns: SimTimeNs, data: bytes) -> None:
        """Send for the device; on a paced line ``flush`` comes when its group's turn is over."""
        if self._uart.baud is None:
            if (
                self.bench.real_time.is_on or not self.bench.real_time.is_held
            ):  # else there are no clients yet
                self.link.send(data)
            return
        if self._fresh and self._uart.sent_format is not self._fresh_format:
            self.flush()
        if not self._fresh:
            self.lines.has_sent(self)
            self._fresh_format = self._uart.sent_format
        self._fresh.append((at_ns, data))

    def flush(self) -> None:
        """Put what was sent on the line, with the times at which a client's UART has each byte."""
        baud = self._uart.baud
        if not self._fresh or baud is None:
            return
        for start_ns, data in joined(self._fresh, baud, self._fresh_format.bits):
            client_baud = self.link.port.client_baud() or baud
            client_format = self.link.client_format() or self._fresh_format
            if client_baud == baud and client_format is self._fresh_format:
                bits = client_format.bits
                due = (
                    (start_ns + character_ns(i + 1, baud, bits), data[i : i + 1], None)
                    for i in range(len(data))
                )
                self._line.extend(due)
                continue
            one_ns = character_ns(1, client_baud, client_format.bits)
            for sampled in resample(data, baud, client_baud, self._fresh_format, client_format):
                due_ns = start_ns + sampled.offset_ns + one_ns
                self._line.append((due_ns, bytes((sampled.byte,)), sampled))
        self._fresh.clear()

    def lose(self, now_ns: SimTimeNs) -> None:
        """Lose what clients would have had up to a time."""
        self.flush()
        while self._line and self._line[0][0] <= now_ns:
            self._line.popleft()

    def release(self, now_ns: SimTimeNs) -> SimTimeNs:
        out = bytearray()
        framing = parity = False
        while self._line and self._line[0][0] <= now_ns:
            _, data, sampled = self._line.popleft()
            out += data
            if sampled:
                framing, parity = framing or sampled.framing_error, parity or sampled.parity_error
        if out:
            self.link.send(bytes(out))
        if framing or parity:
            self.link.tell_errors(framing=framing, parity=parity)
        due_ns = SimTimeNs(self._line[0][0]) if self._line else FOREVER
        # At half, which `room_ns` has given the time of.
        if self.link.is_held and self._uart.room(now_ns) > USB_HELD_BYTES // 2:
            self.refresh()
        return min(due_ns, self._uart.room_ns(now_ns)) if self.link.is_held else due_ns


class TapBackend:
    """Backend at a tap, which stays on its segment while clients of the port come and go."""

    def __init__(
        self, bench: BenchRuntime, lines: PacedLines, link: "PortLink[TapBackend]", tap: ClientTap
    ) -> None:
        self.tap = tap
        self._bench = bench
        self._lines = lines
        self._link = link
        self._is_fresh = False
        tap.listeners.append(self._has_heard)
        if isinstance(tap, Tap):
            tap.client_baud = link.port.client_baud
        if isinstance(link.port, EchoPort) and isinstance(tap, Tap):
            link.port.tell_sole(tap.sole, in_pieces=True)

    # ---- Backend ----

    def room(self) -> int:
        is_full = self._link.port.backlog() > BACKLOG_HOLD_BYTES or self._bench.real_time.is_held
        return 0 if is_full else self.tap.room(self._bench.now_ns)

    def hold(self, is_held: bool) -> None:
        self._lines.hold(self, is_held)
        if is_held:
            self._lines.schedule(self)

    def feed(self, data: bytes) -> None:
        self._link.tell("board", data)
        self._bench.apply_to(self.tap, Bytes(data, self._link.port.client_baud()))

    def refresh(self) -> None:
        self._link.refresh()

    def client_left(self, baud: int | None) -> None:
        """Ignored: the tap has no power that could go."""

    def leave(self) -> None:
        self.tap.listeners.remove(self._has_heard)
        self._lines.forget(self)

    # ---- out ----

    def _has_heard(self) -> None:
        if not self._is_fresh:
            self._is_fresh = True
            self._lines.has_sent(self)

    def flush(self) -> None:
        """Put nothing on a line: what was heard has its times already."""
        self._is_fresh = False

    def lose(self, now_ns: SimTimeNs) -> None:
        """Lose what clients would have had up to a time."""
        self.tap.drain(min(now_ns, self._bench.known_ns(self.tap.name)))

    def release(self, now_ns: SimTimeNs) -> SimTimeNs:
        due_ns = self.tap.next_ns
        # Only what is decided: a collision would take back what is announced of a later time.
        if due_ns <= now_ns and (data := self.tap.drain(min(now_ns, self._bench.known_ns(self.tap.name)))):
            self._link.send(data)
        room_ns = self.tap.room_ns
        if self._link.is_held and room_ns > now_ns:
            return min(self.tap.next_ns, room_ns)
        if self._link.is_held:  # if it is a client that does not read, the port says when that has changed
            self.refresh()
        return self.tap.next_ns
