"""Function of a CDC-ACM device: line coding, control lines, break, serial state and the bytes. Pure.

Sources: PSTN 1.2, chapter 6; Linux 6.1, drivers/usb/class/cdc-acm.c, which is the host here.
"""

import struct
from collections.abc import Callable
from dataclasses import dataclass
from enum import IntEnum

from hil.vocab.line_format import LineFormat, format_named
from hil.vocab.ports import TOUCH_BAUD
from virtual_ports.usb.descriptors import BULK_IN, BULK_OUT, COMMUNICATION, NOTIFY, Descriptors
from virtual_ports.usb.endpoints import Endpoint, InEndpoint, MessageEndpoint, OutEndpoint
from virtual_ports.usb.urb import CommandReader, Unlink
from virtual_ports.usb.usb_device import TO_HOST, Setup, UsbDevice

_CODING = struct.Struct("<IBBB")
_DTR, _RTS = 1, 2
CARRIER, DSR, BREAK, RING, FRAMING, PARITY, OVERRUN = 1, 2, 4, 8, 16, 32, 64
"""Bits of the serial state; those from ``BREAK`` on are events."""
_HERE = CARRIER | DSR
_SERIAL_STATE = struct.Struct("<BBHHHH")
_NOTIFICATION, _SERIAL_STATE_CODE = 0xA1, 0x20
_PARITIES = "NOEMS"
_MOST_STOP = 2


class _Request(IntEnum):
    SET_LINE_CODING = 0x20
    GET_LINE_CODING = 0x21
    SET_CONTROL_LINE_STATE = 0x22
    SEND_BREAK = 0x23


@dataclass(frozen=True)
class LineCoding:
    """Speed and format of the characters. ``stop``: 0 for 1 stop bit, 1 for 1.5, 2 for 2; ``parity``: 0 none,
    1 odd, 2 even, 3 mark, 4 space."""

    baud: int = 9600
    stop: int = 0
    parity: int = 0
    data_bits: int = 8

    @property
    def line_format(self) -> LineFormat | None:
        """Format of the characters; None: there is no such one. 1.5 stop bits count as 2."""
        if self.stop > _MOST_STOP or self.parity >= len(_PARITIES):
            return None
        return format_named(f"{self.data_bits}{_PARITIES[self.parity]}{2 if self.stop else 1}")


class CdcAcm:
    """CDC-ACM device, the commands of its host, and the answers.

    A native one (``UsbIdentity``) sends only while DTR or RTS is on, and knows no break. An adapter sends
    while its host reads, and a break is a 0, as a UART reads it. ``left`` is called when the program that had
    the device open has closed it.
    """

    def __init__(self, descriptors: Descriptors, left: Callable[[], None] = lambda: None) -> None:
        self.coding = LineCoding()
        self.dtr = self.rts = False
        self.is_open = False
        """True while a program of the host has the device open."""
        self.opens = 0
        """Number of times that it was opened."""
        self.rises = 0
        """Number of times that DTR was switched on."""
        self.dropped_bytes = 0
        """Number of bytes of the board that waited for a program that has left."""
        self.is_native = descriptors.identity.is_native
        self._left = left
        self._answers = bytearray()
        self._reader = CommandReader()
        answer = self._answers.extend
        self.to_host = InEndpoint(answer)
        self.from_host = OutEndpoint(answer)
        self._notify = MessageEndpoint(answer)
        self._endpoints: dict[int, Endpoint] = {
            BULK_IN | TO_HOST: self.to_host,
            BULK_OUT: self.from_host,
            NOTIFY | TO_HOST: self._notify,
        }
        self._device = UsbDevice(descriptors, self, self._endpoints, answer)

    # ---- for the port ----

    def receive(self, data: bytes) -> None:
        """Take bytes of the host controller.

        Raises:
            ProtocolError: no host controller sends this.
        """
        for command in self._reader.read(data):
            self._device.handle(command)
            # That a program opens or closes the tty is told by nothing else: the kernel asks for data
            # meanwhile, and takes its requests back.
            is_polled = bool(self._notify.pending or self.to_host.pending)
            if isinstance(command, Unlink):
                if self.is_open and not is_polled:
                    self.close()
            elif is_polled and not self.is_open:
                self._open()

    def take_answers(self) -> bytes:
        """Take what goes to the host controller."""
        answers = bytes(self._answers)
        self._answers.clear()
        return answers

    @property
    def is_configured(self) -> bool:
        return self._device.configuration != 0

    @property
    def is_heard(self) -> bool:
        """True if somebody gets what the board sends."""
        return self.is_open and (not self.is_native or self.dtr or self.rts)

    @property
    def is_touched(self) -> bool:
        """True while the host asks for a reset: it has chosen 1200 baud, and DTR is off. Source: CDC.cpp,
        Arduino SAMD core."""
        return self.is_native and self.coding.baud == TOUCH_BAUD and not self.dtr

    def tell(self, events: int) -> None:
        """Tell the host of events on the line: bits of the serial state."""
        if self.is_open:
            state = _SERIAL_STATE.pack(_NOTIFICATION, _SERIAL_STATE_CODE, 0, COMMUNICATION, 2, _HERE | events)
            self._notify.send(state)

    # ---- UsbFunction ----

    def configured(self, *, is_configured: bool) -> None:
        self.coding = LineCoding()
        self.dtr = self.rts = False
        self.close()

    def request(self, setup: Setup, data: bytes) -> bytes | None:
        if setup.where != COMMUNICATION:
            return None
        match setup.request, setup.is_to_host:
            case (_Request.SET_LINE_CODING, False):
                return self._set_line_coding(data)
            case (_Request.GET_LINE_CODING, True):
                coding = self.coding
                return _CODING.pack(coding.baud, coding.stop, coding.parity, coding.data_bits)
            case (_Request.SET_CONTROL_LINE_STATE, False):
                was_on, self.dtr, self.rts = self.dtr, bool(setup.value & _DTR), bool(setup.value & _RTS)
                self.rises += self.dtr and not was_on
                if not (self.dtr or self.rts or self._notify.pending or self.to_host.pending):
                    self.close()
                return b""
            case (_Request.SEND_BREAK, False):
                if setup.value and not self.is_native:
                    self.from_host.insert(b"\x00")
                return b""
        return None

    def _set_line_coding(self, data: bytes) -> bytes | None:
        if len(data) != _CODING.size:
            return None
        coding = LineCoding(*_CODING.unpack(data))
        if not coding.baud or coding.line_format is None:
            return None
        self.coding = coding
        return b""

    def _open(self) -> None:
        self.is_open = True
        self.opens += 1
        self.tell(0)

    def close(self) -> None:
        """End what the host's program has with the device: forget what it has not read."""
        was_open, self.is_open = self.is_open, False
        self.dropped_bytes += len(self.to_host.queue)
        self.to_host.queue.clear()
        self._notify.messages.clear()
        if was_open:
            self._left()
