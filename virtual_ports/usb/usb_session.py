"""Time for which a device is plugged in: bytes between its host controller and the board."""

import asyncio
from collections.abc import Callable

from hil.net.acceptor import abort
from hil.net.line_openings import tell_opened
from hil.net.traffic import QUEUE_BYTES, Traffic
from hil.vocab.ports import TOUCH_S, PortHost
from virtual_ports.usb.cdc_acm import CdcAcm
from virtual_ports.usb.descriptors import Descriptors
from virtual_ports.usb.urb import ProtocolError

_PIECES = 64
"""Maximum number of pieces that the board takes in one turn of the event loop."""


class UsbSession(asyncio.Protocol):
    """Device that is plugged in, from the connection with its host controller to ``end``. It adds to
    ``traffic``. ``lost`` is called once, with the reason, when the connection has ended by itself."""

    def __init__(
        self, descriptors: Descriptors, host: PortHost, traffic: Traffic, lost: Callable[[str], None]
    ) -> None:
        self.device = CdcAcm(descriptors, self._left)
        self._host = host
        self._traffic = traffic
        self._lost = lost
        self._loop = asyncio.get_running_loop()
        self._transport: asyncio.WriteTransport | None = None
        self._sent_bytes = 0
        """Number of bytes of the device that are in ``traffic``."""
        self._has_backlog = False
        """True if bytes of the board waited after the last time that something was handed on."""
        self._is_moving = False
        """True while the board gets bytes, or soon will."""
        self._touch: asyncio.TimerHandle | None = None
        self._has_ended = False

    # ---- asyncio.Protocol ----

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        assert isinstance(transport, asyncio.WriteTransport)
        self._transport = transport

    def data_received(self, data: bytes) -> None:
        device = self.device
        opens, rises = device.opens, device.rises
        problem = None
        try:
            device.receive(data)
        except ProtocolError as error:
            problem = f"its host controller sends what it must not: {error}"
        self._traffic.connects += device.opens - opens
        if device.rises != rises:
            tell_opened(self._host)
        self._watch_touch()
        self._move()
        self._flush()
        # What came before the mistake has counted, and is answered.
        if problem:
            self._die(problem)

    def connection_lost(self, error: Exception | None) -> None:
        self._die(f"it was pulled out{f': {error}' if error else ''}")

    def _die(self, reason: str) -> None:
        if not self._has_ended:
            self.end()
            self._lost(reason)

    # ---- the port's ----

    @property
    def backlog_bytes(self) -> int:
        return len(self.device.to_host.queue)

    def write(self, data: bytes) -> None:
        """Send bytes of the board: they wait for the host's transfers."""
        if self._has_ended or not self.device.is_heard:
            self._traffic.unheard_bytes += len(data)
            return
        fits = data[: max(0, QUEUE_BYTES - self.backlog_bytes)]
        self._traffic.dropped_bytes += len(data) - len(fits)
        self.device.to_host.send(fits)
        self._flush()

    def tell(self, events: int) -> None:
        """Tell the host of events on the line."""
        self.device.tell(events)
        self._flush()

    def resume(self) -> None:
        """Let the board take more, soon: this may be called in the middle of what it takes."""
        if not self._is_moving and self.device.from_host.is_waiting:
            self._is_moving = True
            self._loop.call_soon(self._move_on)

    def end(self, *, tells: bool = True) -> None:
        """Pull the device out. What nobody has taken is lost. ``tells``: the board hears of it."""
        if self._has_ended:
            return
        self._has_ended = True
        if self._touch:
            self._touch.cancel()
        if self._transport:
            abort(self._transport)
        # Before the device forgets both.
        was_open, had_backlog = self.device.is_open, self.backlog_bytes > 0
        self.device.close()
        self._count()
        if was_open and tells:
            self._loop.call_soon(self._host.client_left, None)
        if had_backlog and tells:
            self._loop.call_soon(self._host.drained)

    # ---- bytes ----

    def _move(self) -> None:
        """Let the board take what the host has sent, as much as it has room for."""
        if self._is_moving or self._has_ended:
            return
        from_host = self.device.from_host
        self._is_moving = True
        for _ in range(_PIECES):
            if not from_host.is_waiting or (room := self._host.room()) <= 0:
                self._is_moving = False
                return
            if data := from_host.drain(room):
                self._traffic.rx_bytes += len(data)
                self._host.received(data)
        self._loop.call_soon(self._move_on)

    def _move_on(self) -> None:
        self._is_moving = False
        if not self._has_ended:
            self._move()
            self._flush()

    def _flush(self) -> None:
        """Hand on what is for the host controller."""
        if self._transport and (answers := self.device.take_answers()):
            self._transport.write(answers)
        self._count()
        had_backlog, self._has_backlog = self._has_backlog, self.backlog_bytes > 0
        if had_backlog and not self._has_backlog:
            # Later, because the host may answer with a write, and this may be in the middle of one.
            self._loop.call_soon(self._drained)

    def _count(self) -> None:
        """Count what has gone since the last time."""
        device = self.device
        sent = device.to_host.sent_bytes - self._sent_bytes
        dropped, device.dropped_bytes = device.dropped_bytes, 0
        self._sent_bytes += sent
        self._traffic.tx_bytes += sent
        self._traffic.dropped_bytes += dropped

    def _drained(self) -> None:
        if not (self._has_ended or self.backlog_bytes):
            self._host.drained()

    # ---- the host's programs ----

    def _left(self) -> None:
        # The baud that a native board is left at is told by its touch alone.
        self._loop.call_soon(self._tell_left, None if self.device.is_native else self.device.coding.baud)

    def _tell_left(self, baud: int | None) -> None:
        if not self._has_ended:
            self._host.client_left(baud)

    def _watch_touch(self) -> None:
        if not self.device.is_touched:
            if self._touch:
                self._touch.cancel()
                self._touch = None
        elif self._touch is None:
            self._touch = self._loop.call_later(TOUCH_S, self._tell_left, self.device.coding.baud)
