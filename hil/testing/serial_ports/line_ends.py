"""Client's end of a line: bytes with the times at which a client's UART has them, and what a client sends."""

from collections import deque
from typing import Protocol

from hil.sim.bench import BenchRuntime
from hil.sim.client_tap import ClientTap
from hil.sim.flight import heard, joined
from hil.sim.inputs import Bytes, LineOpened, Reset
from hil.sim.segment_tap import Tap
from hil.sim.twin import Twin
from hil.sim.uart import DeviceUart
from hil.vocab.line_format import EIGHT_N_1, LineFormat
from hil.vocab.ports import TOUCH_BAUD
from hil.vocab.time import FOREVER, SimTimeNs


class LineEnd(Protocol):
    """End of a line for one client. ``address``: of what is behind it, as inputs have it."""

    address: str
    baud: int | None
    """Speed of a client that has set none; None: bytes take no time here."""
    is_heard: bool
    """False while what comes from the board is lost."""

    @property
    def next_ns(self) -> SimTimeNs:
        """Time at which the next byte is complete, of those on the line; ``FOREVER``: none is."""

    def time_of(self, count: int) -> SimTimeNs:
        """Time at which so many bytes are complete, at least one, or all of those on the line."""

    def collect(self, now_ns: SimTimeNs) -> bytes:
        """Collect what is complete by now."""

    def room(self, now_ns: SimTimeNs) -> int:
        """Number of bytes that may be sent now; the rest waits at the client."""

    def feed(self, data: bytes) -> None:
        """Send bytes now, at the client's speed and in its format."""

    def set_line(self, baud: int, line_format: LineFormat) -> None:
        """Set the client's speed and format from now on."""

    def opened(self) -> None:
        """Note that a first client has opened the port, or that its DTR has come on."""

    def closed(self) -> None:
        """Note that the last client has closed the port."""


class UartEnd:
    """End of a line at a twin's UART. ``resets``: the board does when its port is closed at the speed of the
    touch."""

    is_heard = True

    def __init__(self, runtime: BenchRuntime, device: Twin, uart: str, *, resets: bool) -> None:
        self._runtime, self._device = runtime, device
        self._name = device.uarts.short(uart)
        self._uart: DeviceUart = device.uarts[uart]
        self._resets = resets and self._uart.baud is None
        self.address = device.name
        self.baud = self._uart.baud
        self._client_baud: int | None = None
        self._format = EIGHT_N_1
        self._fresh: list[tuple[SimTimeNs, bytes]] = []
        """Pieces of this turn, which a receiver at another speed hears as one stream."""
        self._line = deque[tuple[int, bytes]]()
        self._uart.listeners.append(self._sent)

    def _sent(self, at_ns: SimTimeNs, data: bytes) -> None:
        if self.is_heard:
            self._fresh.append((at_ns, data))

    def _flush(self) -> None:
        baud = self._uart.baud
        if baud is None:
            self._line.extend(self._fresh)
        else:
            self._put_on_line(baud)
        self._fresh.clear()

    def _put_on_line(self, baud: int) -> None:
        for at_ns, data in joined(self._fresh, baud):
            if flight := heard(at_ns, data, baud, self._client_baud or baud, None, self._format, EIGHT_N_1):
                self._line.extend((each, bytes((byte,))) for each, byte in flight.characters())

    @property
    def next_ns(self) -> SimTimeNs:
        if self._fresh:
            self._flush()
        return SimTimeNs(self._line[0][0]) if self._line else FOREVER

    def time_of(self, count: int) -> SimTimeNs:
        at_ns = self.next_ns
        for at, piece in self._line:
            at_ns, count = SimTimeNs(at), count - len(piece)
            if count <= 0:
                break
        return at_ns

    def collect(self, now_ns: SimTimeNs) -> bytes:
        if self._fresh:
            self._flush()
        out, line = bytearray(), self._line
        while line and line[0][0] <= now_ns:
            out += line.popleft()[1]
        return bytes(out)

    def room(self, now_ns: SimTimeNs) -> int:
        return self._uart.room(now_ns) if self._uart.baud is None else 1 << 30

    def feed(self, data: bytes) -> None:
        if self._uart.baud is None:
            given = Bytes(data, None, self._name)
        else:
            name = "" if self._format is EIGHT_N_1 else self._format.name
            given = Bytes(data, self._client_baud, self._name, name)
        self._runtime.apply_to(self._device, given)

    def set_line(self, baud: int, line_format: LineFormat) -> None:
        self._flush()  # what is on the line was heard at the speed of then
        self._client_baud, self._format = baud or None, line_format

    def opened(self) -> None:
        if self._device.resets_when_opened:
            self._runtime.apply_to(self._device, LineOpened(self._name))

    def closed(self) -> None:
        if self._resets and self._client_baud == TOUCH_BAUD:
            self.reset()

    def reset(self) -> None:
        """Let the board reset."""
        self._runtime.apply_to(self._device, Reset())


class TapEnd:
    """End of a line at a tap of a segment or of a CAN bus."""

    is_heard = True

    def __init__(self, runtime: BenchRuntime, tap: ClientTap) -> None:
        self._runtime, self._tap = runtime, tap
        self.address = tap.name
        self.baud: int | None = None
        self._client_baud: int | None = None
        if isinstance(tap, Tap):
            self.baud = tap.baud
            tap.client_baud = lambda: self._client_baud

    @property
    def next_ns(self) -> SimTimeNs:
        return self._tap.next_ns

    def time_of(self, count: int) -> SimTimeNs:
        tap = self._tap
        if isinstance(tap, Tap) and tap.heard:
            return SimTimeNs(tap.heard[min(count, len(tap.heard)) - 1][0])
        return tap.next_ns

    def collect(self, now_ns: SimTimeNs) -> bytes:
        return self._tap.drain(now_ns)

    def room(self, now_ns: SimTimeNs) -> int:
        return self._tap.room(now_ns)

    def feed(self, data: bytes) -> None:
        self._runtime.apply_to(self._tap, Bytes(data, self._client_baud))

    def set_line(self, baud: int, line_format: LineFormat) -> None:
        """Set the speed; the segment says the format."""
        self._client_baud = baud or None

    def opened(self) -> None:
        """Wake nothing: a tap has no RESET."""

    def closed(self) -> None:
        """Leave the tap on its wire."""
