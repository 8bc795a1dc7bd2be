"""A device's serial interface between its firmware and the line, with the line's times.

Without a baud (USB CDC) bytes take no time and the host is held up while the device is busy. With a
baud each character has its time, there is no flow control, and what finds no room is an overrun.
"""

from collections import deque
from collections.abc import Callable, Sequence

from hil.firmware.uart import RxBuffer
from hil.vocab.segment import HeardCharacter
from hil.vocab.time import FOREVER, SimTimeNs
from hil.wire.byte_faults import ByteFaults, apply_all
from hil.wire.serial_line import character_ns, resample

USB_HELD_BYTES = 16
"""What the device takes from a USB host that its sketch has not read yet; more waits at the host. Each may
be a command that answers 126 kB (q) at one instant: all of it stays below what a port queues."""
UART_BUFFER_BYTES = 64
"""Each way: SERIAL_BUFFER_SIZE of the Arduino SAMD core 1.6.20's RingBuffer."""


class DeviceUart:
    """``hil.vocab.firmware.Uart`` for the sketch; ``arrive`` and ``take_arrivals`` for the line.

    ``sent(start_ns, data)`` is called for everything the sketch sends: without a baud all of it is on
    the line at ``start_ns``, else byte i has been sent at ``start_ns + character_ns(i + 1, baud)``.
    ``tx_buffer_bytes`` is 0 for a UART made in software, whose print waits for the last bit.
    """

    def __init__(
        self,
        baud: int | None,
        sent: Callable[[SimTimeNs, bytes], None],
        tx_buffer_bytes: int = UART_BUFFER_BYTES,
    ) -> None:
        self.baud = baud
        self._power_up_baud = baud
        self.now_ns = SimTimeNs(0)
        self.overrun_bytes = 0
        self.rx_faults: dict[int, ByteFaults] = {}
        self.tx_faults: dict[int, ByteFaults] = {}
        """By the numbers that they were injected under."""
        self.polls_from_ns = FOREVER
        """From when on the sketch reads at once what comes: such bytes need no room in the buffer."""
        self._tx_buffer_bytes = tx_buffer_bytes
        self.address: int | None = None
        self.address_changed: Callable[[], None] = lambda: None
        self.due_changed: Callable[[], None] = lambda: None
        """Called when ``next_arrival_ns`` may be earlier than it was."""
        self.busy_flag: tuple[set[str], str] | None = None
        """Where a segment wants to know that the firmware does not poll, and under which name."""
        self._sent = sent
        self._in_flight: deque[tuple[int, int]] = deque()
        self._wake_byte: int | None = None
        self._wakes: deque[int] = deque()
        self._is_woken = False
        self._rx_free_ns = 0
        self.tx_free_ns = 0
        """When the last byte that was written so far has gone out; without a baud 0."""
        self.clear()

    def clear(self) -> None:
        """As after power-up: nothing received. What is on the line stays there."""
        self.baud = self._power_up_baud
        self._rx = RxBuffer(1 << 30 if self.baud is None else UART_BUFFER_BYTES)
        self.wake_on(None)
        self.listen_for(None)

    def listen_for(self, address: int | None) -> None:
        if address != self.address:
            self.address = address
            self.address_changed()

    def wake_on(self, byte: int | None) -> None:
        if byte != self._wake_byte:
            self._is_woken = False
        self._wake_byte = byte
        self._wakes = deque(at_ns for at_ns, flying in self._in_flight if flying == byte)

    @property
    def has_input(self) -> bool:
        """Whether a byte has come that the sketch is woken for."""
        return self._rx.available() > 0 if self._wake_byte is None else self._is_woken

    def set_baud(self, baud: int | None) -> None:
        """What is on the line already keeps its times."""
        if self._power_up_baud is not None:
            self.baud = baud or self._power_up_baud

    def available(self) -> int:
        return self._rx.available()

    def read(self) -> int:
        return self._rx.read()

    def read_all(self) -> bytes:
        self._is_woken = False
        return self._rx.read_all()

    def peek(self) -> int:
        return self._rx.peek()

    def write(self, data: bytes) -> None:
        if not data:
            return
        if self.tx_faults:
            for delay_ns, piece in apply_all(self.tx_faults.values(), data):
                self._send(piece, delay_ns)
        else:
            self._send(data, 0)

    def _send(self, data: bytes, delay_ns: int) -> None:
        if self.baud is None:
            self._sent(self.now_ns, data)
            return
        start_ns = max(self.now_ns, self.tx_free_ns) + delay_ns
        self.tx_free_ns = start_ns + character_ns(len(data), self.baud)
        self._sent(SimTimeNs(start_ns), data)

    def print_returns(self, now_ns: SimTimeNs) -> SimTimeNs:
        """When all but a transmit buffer of what was written has gone out."""
        if self.baud is None:
            return now_ns
        return SimTimeNs(max(now_ns, self.tx_free_ns - character_ns(self._tx_buffer_bytes, self.baud)))

    def room(self) -> int:
        """Bytes that may be taken from a client now."""
        waiting = self._rx.available() if self.baud is None else len(self._in_flight)
        return max(0, USB_HELD_BYTES - waiting)

    def arrive(self, data: bytes, client_baud: int | None) -> None:
        """A client starts to send ``data`` now, at its own baud (None: at ours)."""
        if self.rx_faults:
            for delay_ns, piece in apply_all(self.rx_faults.values(), data):
                self._rx_free_ns = max(self.now_ns, self._rx_free_ns) + delay_ns
                self._receive(piece, client_baud)
        else:
            self._receive(data, client_baud)

    def _receive(self, data: bytes, client_baud: int | None) -> None:
        if self.baud is None:
            self._rx.feed(data)
            return
        start_ns = SimTimeNs(max(self.now_ns, self._rx_free_ns))
        sent_baud = client_baud or self.baud
        self._rx_free_ns = start_ns + character_ns(len(data), sent_baud)
        self.hear(start_ns, data, sent_baud)

    @property
    def baud_now(self) -> int:
        """``hil.vocab.segment.Receiver``, as the next three."""
        assert self.baud is not None
        return self.baud

    def hear_characters(self, characters: Sequence[HeardCharacter]) -> None:
        self._fly([(each.at_ns, each.byte) for each in characters])

    def retract(self, after_ns: SimTimeNs) -> None:
        self._in_flight = deque(each for each in self._in_flight if each[0] <= after_ns)
        self.wake_on(self._wake_byte)

    def hear(self, start_ns: SimTimeNs, data: bytes, sent_baud: int) -> None:
        assert self.baud is not None
        if sent_baud == self.baud:
            times = [(start_ns + character_ns(i + 1, self.baud), byte) for i, byte in enumerate(data)]
        else:
            one_ns = character_ns(1, self.baud)
            times = [
                (start_ns + sampled.offset_ns + one_ns, sampled.byte)
                for sampled in resample(data, sent_baud, self.baud)
            ]
        self._fly(times)

    def _fly(self, times: list[tuple[int, int]]) -> None:
        self._in_flight.extend(times)
        if self._wake_byte is not None:
            self._wakes.extend(at_ns for at_ns, byte in times if byte == self._wake_byte)
        self.due_changed()

    @property
    def next_arrival_ns(self) -> SimTimeNs:
        """When the next character on the line is complete, of those that the sketch is woken for."""
        if self._wake_byte is not None:
            return SimTimeNs(self._wakes[0]) if self._wakes else FOREVER
        return SimTimeNs(self._in_flight[0][0]) if self._in_flight else FOREVER

    def take_arrivals(self) -> None:
        """Characters complete by now enter the receive buffer, or are lost to an overrun."""
        while self._in_flight and self._in_flight[0][0] <= self.now_ns:
            at_ns, byte = self._in_flight.popleft()
            at_once = self._wake_byte is not None and at_ns >= self.polls_from_ns
            if not self._rx.feed(bytes((byte,)), at_once=at_once):
                self.overrun_bytes += 1
            elif byte == self._wake_byte:
                self._is_woken = True
        while self._wakes and self._wakes[0] <= self.now_ns:
            self._wakes.popleft()
