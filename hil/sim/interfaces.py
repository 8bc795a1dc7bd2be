"""Serial interfaces of a board together, before and after their firmware's turns."""

from collections.abc import Iterable, Mapping
from itertools import groupby
from operator import itemgetter
from types import MappingProxyType

from hil.sim.firmware_guard import Guard
from hil.sim.flight import Flight
from hil.sim.inputs import Words
from hil.sim.processor_line import LineProcessor, ProcessorLine
from hil.sim.uart import UART_BUFFER_BYTES, DeviceUart, Written
from hil.sim.uart_rx_line import DueChanged
from hil.vocab.address import DeviceParts
from hil.vocab.firmware import UartFrame
from hil.vocab.time import SimTimeNs

LAST_WORDS_BYTES = 128 * 1024
"""Maximum that is kept of a stopped firmware's output: more than the longest answer, a look-up table."""


class Interfaces:
    """Serial interfaces of a board. A turn only notes what the firmware writes; faults and the line's times
    are computed outside of it, where the guard cannot strike.

    ``bauds``: speed of each by its name; None where bytes take no time. All but the first are made in
    software, without a buffer, unless ``send_buffers`` has their bytes by name; ``receive_buffers`` has those
    of the buffers to receive. ``due_changed`` is called
    when a byte may arrive sooner than was known.
    """

    def __init__(
        self,
        bauds: Mapping[str, int | None],
        guard: Guard,
        due_changed: DueChanged,
        send_buffers: Mapping[str, int] = MappingProxyType({}),
        receive_buffers: Mapping[str, int] = MappingProxyType({}),
    ) -> None:
        self._guard = guard
        self.written: list[Written] = []
        """Bytes that the firmware has written in this turn."""
        self._put = 0
        """Number of these that are on the line."""
        self._sent: list[tuple[DeviceUart, SimTimeNs, bytes]] = []
        self._is_paced = any(bauds.values())
        self._busy_ns = 0
        """Time at which all that was written so far is out."""
        first = next(iter(bauds), "")
        self.by_name = DeviceParts(
            {
                name: self._make(
                    baud,
                    due_changed,
                    send_buffers.get(name, UART_BUFFER_BYTES * (name == first)),
                    receive_buffers.get(name, UART_BUFFER_BYTES),
                )
                for name, baud in bauds.items()
            }
        )
        self.all = tuple(self.by_name.values())
        self.rx_lines = tuple(uart.incoming for uart in self.all)
        self.now_ns = SimTimeNs(0)

    def _make(self, baud: int | None, due_changed: DueChanged, room: int, rx_room: int) -> DeviceUart:
        def sent(at_ns: SimTimeNs, data: bytes) -> None:
            self._sent.append((uart, at_ns, data))

        uart = DeviceUart(
            baud, sent, room, later=self.written, due_changed=due_changed, rx_buffer_bytes=rx_room
        )
        return uart

    def set_time(self, now_ns: SimTimeNs) -> None:
        self.now_ns = now_ns
        for uart in self.all:
            uart.now_ns = now_ns

    def clear(self) -> None:
        for uart in self.all:
            uart.clear()

    def join_processor(self, processor: LineProcessor) -> None:
        """Let the first interface be that of a processor, while it runs."""
        if self.all:
            self.all[0].processor = ProcessorLine(processor)

    def send_frame(self, at_ns: SimTimeNs, frame: UartFrame) -> None:
        """Send a frame that a processor's serial interface has begun."""
        if self.all:
            self.all[0].send_frame(at_ns, frame)
            self._hand_on()

    def switch_driver(self, at_ns: SimTimeNs, *, is_on: bool) -> None:
        """Switch the driver of the first interface's line, as a processor's output does."""
        if self.all:
            self.all[0].switch_driver(at_ns, is_on=is_on)

    # ---- a turn ----

    def begin(self, now_ns: SimTimeNs, polls_from_ns: SimTimeNs) -> None:
        """Bring what has arrived into the buffers, before the main program's turn."""
        self.now_ns = now_ns
        for uart in self.all:
            uart.now_ns = now_ns
            uart.polls_from_ns = polls_from_ns
            if uart.incoming.flights:  # asked here: it is a call less
                uart.take_arrivals()

    def take_in(self, now_ns: SimTimeNs, polls_from_ns: SimTimeNs, number: int, flight: Flight) -> None:
        """Bring what was taken off the line of a UART into its buffer, in the main program's turn."""
        self.set_time(now_ns)
        self.all[number].polls_from_ns = polls_from_ns
        self.all[number].take_in(flight)

    def has_input(self) -> bool:
        """True if a byte has come that the firmware is woken for."""
        for uart in self.all:  # noqa: SIM110  any() takes twice the time, and this is asked at every wake
            if uart.has_input:
                return True
        return False

    def print_returns(self, now_ns: SimTimeNs) -> SimTimeNs:
        """Time at which what was written so far lets the firmware go on."""
        if self._is_paced and (self._busy_ns > now_ns or self._put < len(self.written)):
            if self._put < len(self.written):
                with self._guard.aside():
                    self._put_written()
            for uart in self.all:
                if (
                    uart.tx.free_ns > now_ns
                ):  # asked here: most have nothing on the line, and it is a call less
                    now_ns = uart.tx.print_returns(now_ns, uart.baud)
        return now_ns

    def end(self) -> None:
        """Tell addresses, and hand on all that was written to the listeners, after a turn."""
        for uart in self.all:
            if uart.station and uart.address != uart.station.told_address:
                uart.station.tell_address(uart.address)
        if self.written or self._sent:
            with self._guard.aside():
                self._put_written()
                self.written.clear()
                self._put = 0
                self._hand_on()

    def note_polling(self, now_ns: SimTimeNs, *, is_polling: bool) -> None:
        """Note after the main program's turn whether it takes bytes as they come."""
        for uart in self.all:
            if not is_polling:
                if not uart.incoming.wakes.is_loose:
                    uart.incoming.loosen()
            elif uart.incoming.wakes.is_loose and self.print_returns(now_ns) <= now_ns:
                uart.incoming.wakes.tighten()
            if uart.station:
                uart.station.tell_polling(is_polling)

    def note_interrupt(self) -> None:
        """Note that an interrupt's turn is over: the next thing that wakes the main program lets it wait
        until what was written is out."""
        if self.written:
            for uart in self.all:
                uart.incoming.loosen()

    def _put_written(self) -> None:
        for uart, baud, data in self.written[self._put :]:
            uart.tx.put(uart.now_ns, baud, data)
            if uart.tx.free_ns > self._busy_ns:
                self._busy_ns = uart.tx.free_ns
        self._put = len(self.written)

    def _hand_on(self) -> None:
        """Hand on what was written; what went on the line at one time is one piece."""
        sent, self._sent = self._sent, []
        if len(sent) == 1:
            uart, at_ns, data = sent[0]
            for listener in uart.listeners:
                listener(at_ns, data)
            return
        for (uart, at_ns), pieces in groupby(sent, key=itemgetter(0, 1)):
            whole = b"".join(map(itemgetter(2), pieces))
            for listener in uart.listeners:
                listener(at_ns, whole)

    # ---- a turn that the firmware did not come through ----

    def cut(self) -> Words:
        """Cut the output of a firmware that printed forever to what a client may want to see. Returns it."""
        left, kept = LAST_WORDS_BYTES, self.written[: self._put]
        for uart, baud, data in self.written[self._put :]:
            kept.append((uart, baud, data[:left]))
            left -= len(data)
            if left <= 0:
                break
        self.written[:] = kept
        names = {uart: name for name, uart in self.by_name.items()}
        return tuple((names[uart], baud, data.hex()) for uart, baud, data in kept)

    def halt(self, words: Iterable[tuple[str, int | None, str]]) -> None:
        """Undo all of a stopped firmware's turn, except what it has written, which is ``words``."""
        for uart in self.all:
            uart.halt()
        self.written[:] = [(self.by_name[name], baud, bytes.fromhex(data)) for name, baud, data in words]
