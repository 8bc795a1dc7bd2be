"""A device's serial interface between its firmware and the line, with the line's times.

Without a baud (USB CDC) bytes take no time and the host is held up while the device is busy. With a
baud each character has its time, there is no flow control, and what finds no room is an overrun.
"""

from collections.abc import Callable, Sequence

from hil.firmware.runtime import RxBuffer
from hil.sim.flight import Flight, flight_of, heard
from hil.sim.processor_line import ProcessorLine
from hil.sim.uart_rx_line import DueChanged, Incoming
from hil.vocab.firmware import UartFrame
from hil.vocab.framing import Framing, Item
from hil.vocab.line_format import EIGHT_N_1, LineFormat
from hil.vocab.segment import HeardCharacter, Receiver, Segment
from hil.vocab.time import FOREVER, SimTimeNs
from hil.wire.byte_faults import ByteFaults, apply_all
from hil.wire.serial_line import character_ns


class StationLink:
    """Link of a UART, the ``receiver``, to its segment, where it is the station of this name."""

    def __init__(self, segment: Segment, name: str, receiver: Receiver) -> None:
        self.segment = segment
        self.name = name
        self.told_address: int | None = None
        self._told_polling = True
        segment.join(name, receiver)

    def tell_address(self, address: int | None) -> None:
        """Let the segment know which packets concern the sketch now."""
        if address != self.told_address:
            self.told_address = address
            self.segment.set_address(self.name, address)

    def tell_polling(self, is_polling: bool) -> None:
        """Let the segment know whether the sketch reads at once what comes."""
        if is_polling != self._told_polling:
            self._told_polling = is_polling
            self.segment.set_polling(self.name, is_polling)


RxBegun = Callable[[SimTimeNs, bytes, int, LineFormat], None]
"""Called with what begins on a line towards a UART: the time of its first bit, the bytes, the sender's speed
and format."""

Sent = Callable[[SimTimeNs, bytes], None]
"""Called with what is sent: the time of its first bit on the line, and the bytes."""


class Transmitter:
    """Transmit side of a UART. ``sent(start_ns, data)`` is called for all that leaves: without a baud all of
    it is on the line at ``start_ns``, else byte i has been sent at ``start_ns + character_ns(i + 1, baud)``.
    ``buffer_bytes``: 0 for a UART made in software, whose print waits for the last bit."""

    def __init__(self, sent: Sent, buffer_bytes: int) -> None:
        self.faults: dict[int, ByteFaults] = {}
        """Faults of what is sent, by their numbers."""
        self.free_ns = 0
        """Time at which the last byte written so far has gone out; without a baud 0."""
        self._sent = sent
        self._buffer_bytes = buffer_bytes

    def put(self, now_ns: SimTimeNs, baud: int | None, data: bytes) -> None:
        """Send what was written, through the faults."""
        if baud is None and not self.faults:
            self._sent(now_ns, data)
            return
        for delay_ns, piece in apply_all(self.faults.values(), data) if self.faults else ((0, data),):
            self._send(now_ns, baud, piece, delay_ns)

    def _send(self, now_ns: SimTimeNs, baud: int | None, data: bytes, delay_ns: int) -> None:
        if baud is None:
            self._sent(now_ns, data)
            return
        start_ns = max(now_ns + delay_ns, self.free_ns)
        self.free_ns = start_ns + character_ns(len(data), baud)
        self._sent(SimTimeNs(start_ns), data)

    def send_at(self, start_ns: SimTimeNs, data: bytes) -> None:
        """Send bytes whose time is known: after those before them only where a fault has delayed those."""
        self._sent(start_ns, data)

    def print_returns(self, now_ns: SimTimeNs, baud: int | None) -> SimTimeNs:
        """Time at which all but a transmit buffer of what was written has gone out."""
        if baud is None or self.free_ns <= now_ns:
            return now_ns
        return SimTimeNs(max(now_ns, self.free_ns - character_ns(self._buffer_bytes, baud)))


USB_HELD_BYTES = 16
"""Maximum number of bytes taken from a USB host that the sketch has not read yet; more waits at the host.
Each may be a command that answers 126 kB (q) at one instant: all of it stays below what a port queues."""
UART_BUFFER_BYTES = 64
"""Size of each buffer, both ways: SERIAL_BUFFER_SIZE of RingBuffer in the Arduino SAMD core 1.6.20."""


class DeviceUart:
    """UART: ``hil.vocab.firmware.Uart`` for the sketch, ``arrive`` and ``take_arrivals`` for the line.

    ``sent`` and ``tx_buffer_bytes``: as ``Transmitter`` takes them. ``later``: list in which written bytes
    wait for ``tx.put``; None: they do not. ``due_changed``: as ``Incoming`` takes it.
    ``rx_buffer_bytes``: room of the receive buffer, where bytes take time.

    Long because each way in asks who has the line: the firmware's buffer, or a processor that runs a program.
    """

    def __init__(
        self,
        baud: int | None,
        sent: Sent,
        tx_buffer_bytes: int = UART_BUFFER_BYTES,
        *,
        later: "list[Written] | None" = None,
        due_changed: DueChanged = lambda at_ns: None,
        rx_buffer_bytes: int = UART_BUFFER_BYTES,
    ) -> None:
        self.baud = baud
        self._power_up_baud = baud
        self._rx_buffer_bytes = rx_buffer_bytes
        self.now_ns = SimTimeNs(0)
        self.overrun_bytes = 0
        self.rx_faults: dict[int, ByteFaults] = {}
        """Faults of what it is sent, by their numbers."""
        self.tx = Transmitter(sent, tx_buffer_bytes)
        self.polls_from_ns = FOREVER
        """Time from which the sketch reads at once what comes: such bytes need no room in the buffer."""
        self.address: int | None = None
        self.listeners: list[Sent] = []
        """Called with all that the device has sent, when its turn is over: one piece for each time."""
        self.rx_watchers: list[RxBegun] = []
        """Called with what a client sends, as it goes on the line; never where bytes take no time."""
        self.station: StationLink | None = None
        """Link to its segment, if it is on one."""
        self.processor: ProcessorLine | None = None
        """Line of the processor whose serial interface this is; while it runs, its program has the line."""
        self.has_driver = True
        """False while an output of the processor keeps its line's driver off: nothing reaches its segment."""
        self._later = later
        self.incoming = Incoming(due_changed)
        self._program_format = EIGHT_N_1
        """Format of the last frame of a processor."""
        self._line_format = EIGHT_N_1
        """Format of the line that it is on."""
        self._framing: Framing | None = None
        """Framing by which the sketch reads."""
        self._line_framing: Framing | None = None
        self._rx_free_ns = 0
        self.clear()

    def join(self, segment: Segment, station: str) -> None:
        self.station = StationLink(segment, station, self)
        self._line_framing, self._line_format = segment.framing, segment.line_format
        self.listeners.append(self._transmit)

    def _transmit(self, at_ns: SimTimeNs, data: bytes) -> None:
        if not (self.station and self.has_driver):
            return
        is_other = self.processor and self.processor.is_on and not self.sent_format.is_like(self._line_format)
        sent_format = self.sent_format if is_other else None  # a board's own sketch sends as the line has it
        self.station.segment.transmit(self.station.name, at_ns, data, self.baud or 0, sent_format)

    def clear(self) -> None:
        """Clear what was received, as after power-up. What is on the line stays there."""
        if self.station:
            self.station.tell_address(None)
        self.halt()

    def halt(self) -> None:
        """Undo what a sketch that was stopped did here since its segment was told of it."""
        self.baud = self._power_up_baud
        # On USB the host is held up instead (`room`): nothing is lost to a full buffer.
        self._rx = RxBuffer(1 << 30 if self.baud is None else self._rx_buffer_bytes)
        self.incoming.unread = self._rx.unread
        self.address = self.station.told_address if self.station else None
        self.wake_on(None)

    def reaction_ns(self) -> int:
        return self.station.segment.reactions.delay_ns(self.station.name) if self.station else 0

    def listen_for(self, address: int | None) -> None:
        self.address = address

    def wake_on(self, framing: Framing | None) -> None:
        if framing is not None and not framing.has_ends:
            framing = None
        if framing is not self._framing:
            self.incoming.is_woken = False
            self._framing = framing
        self.incoming.wake_on(framing)

    @property
    def has_input(self) -> bool:
        """True if a byte has come that the sketch is woken for."""
        return bool(self._rx.unread) if self._framing is None else self.incoming.is_woken

    def set_baud(self, baud: int | None) -> None:
        """Change the speed; what is on the line already keeps its times."""
        if self._power_up_baud is not None:
            self.baud = baud or self._power_up_baud

    def available(self) -> int:
        return self._rx.available()

    def read(self) -> int:
        return self._rx.read()

    def read_all(self) -> bytes:
        self.incoming.is_woken = False
        return self._rx.read_all()

    def peek(self) -> int:
        return self._rx.peek()

    def write(self, data: bytes) -> None:
        if not data:
            return
        if type(data) is not bytes:
            data = _bytes_of(data)
        if self._later is None:
            self.tx.put(self.now_ns, self.baud, data)
        else:
            self._later.append((self, self.baud, data))

    def room(self, now_ns: SimTimeNs) -> int:
        """Number of bytes that may be taken from a client now. On a line those count that are not out yet: a
        sketch that is not woken for what has come leaves it there. 0: its buffer is full of it."""
        if self.baud is None:
            return self.room_on_usb
        if self.processor and self.processor.is_on:
            return max(0, USB_HELD_BYTES - len(self.processor.under_way(now_ns)))
        if self.incoming.waiting > self._rx_buffer_bytes:
            return 0
        return max(0, USB_HELD_BYTES - len(self.incoming.under_way(now_ns)))

    @property
    def room_on_usb(self) -> int:
        """Number of bytes that may be taken from a client now, where bytes take no time."""
        return max(0, USB_HELD_BYTES - len(self._rx.unread))

    def room_ns(self, now_ns: SimTimeNs) -> SimTimeNs:
        """Time at which half of what is on the line from a client is out; ``FOREVER``: nothing is."""
        if self.processor and self.processor.is_on:
            return self.processor.room_ns(now_ns)
        times_ns = self.incoming.under_way(now_ns)
        return SimTimeNs(times_ns[len(times_ns) // 2]) if times_ns else FOREVER

    def arrive(self, data: bytes, client_baud: int | None, client_format: LineFormat | None = None) -> None:
        """Let a client start to send ``data`` now, at its own baud and in its own format (None: in ours)."""
        if self.baud is None and not self.rx_faults:
            self._rx.feed(data)
            return
        for delay_ns, piece in apply_all(self.rx_faults.values(), data) if self.rx_faults else ((0, data),):
            self._rx_free_ns = max(self.now_ns + delay_ns, self._rx_free_ns)
            self._begin(piece, client_baud, client_format or self.format_now or EIGHT_N_1)

    def _begin(self, data: bytes, client_baud: int | None, client_format: LineFormat) -> None:
        if self.baud is None:
            self._rx.feed(data)
            return
        self._follow_program()
        start_ns = SimTimeNs(max(self.now_ns, self._rx_free_ns))
        sent_baud = client_baud or self.baud
        self._rx_free_ns = start_ns + character_ns(len(data), sent_baud, client_format.bits)
        for watcher in self.rx_watchers:
            watcher(start_ns, data, sent_baud, client_format)
        if self.processor and self.processor.is_on:
            self.processor.hear(start_ns, data, sent_baud, client_format)
        elif client_format is EIGHT_N_1:
            self.hear(start_ns, data, sent_baud)
        elif flight := heard(
            start_ns, data, sent_baud, self.baud, self._line_framing, EIGHT_N_1, client_format
        ):
            self.incoming.add(flight)

    @property
    def baud_now(self) -> int:
        """Speed in baud. It and the next three: ``hil.vocab.segment.Receiver``."""
        self._follow_program()
        assert self.baud is not None
        return self.baud

    @property
    def sent_format(self) -> LineFormat:
        """Format of the characters that are sent now; a processor's program sets it."""
        return self._program_format if self.processor and self.processor.is_on else EIGHT_N_1

    @property
    def format_now(self) -> LineFormat | None:
        """Format in which a processor's program reads: ``hil.vocab.segment.FormatReceiver``."""
        return self.processor.line_format if self.processor and self.processor.is_on else None

    def _follow_program(self) -> None:
        """Take the speed that a processor's program has set."""
        if self.processor and self.processor.is_on and self._power_up_baud:
            self.baud = self.processor.baud(self._power_up_baud)

    def switch_driver(self, at_ns: SimTimeNs, *, is_on: bool) -> None:
        """Switch the driver of the segment that it is on: frames go there while it is on, and one that is
        under way when it goes off is cut short."""
        self.has_driver = is_on
        if self.station and not is_on and at_ns < self.tx.free_ns:
            self.station.segment.release(self.station.name, at_ns)

    def send_frame(self, start_ns: SimTimeNs, frame: UartFrame) -> None:
        """Send a frame of the processor, which has its own times."""
        if self._power_up_baud is None:
            return
        self.baud, self._program_format = frame.baud, frame.line_format
        bits = frame.line_format.bits - frame.line_format.stop_bits + 1
        self.tx.free_ns = start_ns + character_ns(1, frame.baud, bits)
        data = bytes((frame.byte,))
        for delay_ns, piece in apply_all(self.tx.faults.values(), data) if self.tx.faults else ((0, data),):
            self.tx.send_at(SimTimeNs(start_ns + delay_ns), piece)

    def hear_characters(self, characters: Sequence[HeardCharacter]) -> None:
        if self.processor and self.processor.is_on:
            self.processor.hear_characters(characters, self.baud_now, self.format_now or self._line_format)
        elif characters:
            self.incoming.add(flight_of(tuple(characters)))

    def retract(self, after_ns: SimTimeNs) -> None:
        if self.processor and self.processor.is_on:
            line_format = self.format_now or self._line_format
            self.processor.retract(after_ns, character_ns(1, self.baud_now, line_format.bits))
        self.incoming.retract(after_ns)

    def hear(
        self, start_ns: SimTimeNs, data: bytes, baud: int, packets: Sequence[Item] | None = None
    ) -> None:
        if self.processor and self.processor.is_on:
            self.processor.hear(start_ns, data, baud, self._line_format)
        else:
            self.incoming.hear(start_ns, data, baud, self.baud, self._line_framing, packets)

    def take_arrivals(self) -> None:
        """Move characters complete by now into the receive buffer; those without room are overruns."""
        if self.incoming.flights:
            for flight in self.incoming.drain(self.now_ns):
                self.take_in(flight)

    def take_in(self, flight: Flight) -> None:
        """Move characters from the line into the receive buffer."""
        framing = self._framing
        at_once = framing is not None and flight.times_ns[0] >= self.polls_from_ns
        if at_once or len(flight.data) <= self._rx.room():
            self._rx.feed(flight.data, at_once=at_once)
            if framing is not None and framing.may_end(flight.data):
                self.incoming.is_woken = True
            return
        is_gapless = True
        for at_ns, byte in flight.characters():
            at_once = framing is not None and at_ns >= self.polls_from_ns
            data = bytes((byte,))
            if not self._rx.feed(data, at_once=at_once):
                self.overrun_bytes += 1
                is_gapless = False
            elif framing is not None and framing.may_end(data):
                self.incoming.is_woken = True
        if not is_gapless:
            self.incoming.note_gap()


def _bytes_of(data: object) -> bytes:
    """Bytes of what a firmware writes. Raises TypeError, in its turn: it writes something else."""
    if isinstance(data, bytearray | memoryview):
        return bytes(data)
    raise TypeError(f"write() of a UART takes bytes, as in b'ok', not {type(data).__name__}")


Written = tuple[DeviceUart, int | None, bytes]
"""Bytes that a sketch has written: to which UART, at which baud."""
