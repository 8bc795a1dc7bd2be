"""A CAN adapter as its serial line sees it: Lawicel's commands in, answers and frames out."""

from enum import IntFlag
from typing import Protocol

from hil.wire.can.can_frame import CanFrame
from hil.wire.can.slcan import (
    ACCEPT_ALL,
    BIT_RATES,
    ERROR,
    OK,
    SlcanCommand,
    SlcanSplitter,
    accepts,
    bit_rate_of,
    encode,
)

VERSION = b"V1013"
"""Hardware 1.0 and software 1.3, the adapters that the manual is for."""
SERIAL_NUMBER = b"NH001"


class SlcanStatus(IntFlag):
    """Flags of the command ``F``."""

    RECEIVE_FULL = 1
    SEND_FULL = 2
    ERROR_WARNING = 4
    OVERRUN = 8
    ERROR_PASSIVE = 32
    ARBITRATION_LOST = 64
    BUS_ERROR = 128


class SlcanChannel(Protocol):
    """Bus behind an adapter."""

    def open(self, bit_rate: int, *, is_listening: bool) -> bool:
        """Go on the bus, in bits per second; False if that cannot be."""

    def close(self) -> None:
        """Leave the bus."""

    def send(self, frame: CanFrame) -> bool:
        """Send a frame; False if no mailbox is free."""

    def status(self) -> SlcanStatus:
        """Answer the flags, and clear those that are of the past."""


class SlcanAdapter:
    """Adapter at the end of a serial line. It is closed at first, without a bit rate.

    ``feed`` takes what the client sends, in any pieces, and answers what it gets back, ``received`` what it
    gets for a frame of the bus. A command is answered by CR, with z or Z before it for a frame, or by BEL if
    it is none, or none for now: the rate, the filters and time stamps are set while it is closed.
    """

    def __init__(self, channel: SlcanChannel) -> None:
        self._channel = channel
        self._splitter = SlcanSplitter()
        self._bit_rate = 0
        self._code, self._mask = ACCEPT_ALL
        self._has_stamps = False
        self.is_open = False
        self._is_listening = False

    def feed(self, data: bytes) -> bytes:
        return b"".join([self._answer(command) for command in self._splitter.feed(data)])

    def received(self, frame: CanFrame, at_ns: int) -> bytes:
        """Encode a frame of the bus for the client; nothing if it is closed or does not want it."""
        if not self.is_open or not accepts(self._code, self._mask, frame):
            return b""
        return encode(frame, at_ns if self._has_stamps else None)

    def close(self) -> None:
        """Leave the bus, as when the client hangs up."""
        if self.is_open:
            self.is_open = False
            self._channel.close()

    def _answer(self, command: SlcanCommand) -> bytes:
        letter = command.letter
        if command.frame:
            return self._send(command.frame)
        if letter == "\r":
            return OK
        if letter == "V":
            return VERSION + OK
        if letter == "N":
            return SERIAL_NUMBER + OK
        if not letter:
            return ERROR
        if self.is_open:
            return self._answer_open(letter)
        return OK if self._do_closed(letter, command.text) else ERROR

    def _answer_open(self, letter: str) -> bytes:
        if letter == "F":
            return b"F%02X" % self._channel.status() + OK
        if letter == "C":
            self.close()
            return OK
        return ERROR

    def _do_closed(self, letter: str, text: bytes) -> bool:
        """Do what is done while the channel is closed; False if it cannot be."""
        if letter in "OL":
            self._is_listening = letter == "L"
            self.is_open = bool(self._bit_rate) and self._channel.open(
                self._bit_rate, is_listening=self._is_listening
            )
            return self.is_open
        if letter == "S":
            self._bit_rate = BIT_RATES[int(text)]
        elif letter == "s":
            bit_rate = bit_rate_of(bytes.fromhex(text.decode()))
            if not BIT_RATES[0] <= bit_rate <= BIT_RATES[-1]:
                return False
            self._bit_rate = bit_rate
        elif letter == "Z":
            self._has_stamps = text == b"1"
        elif letter == "M":
            self._code = bytes.fromhex(text.decode())
        elif letter == "m":
            self._mask = bytes.fromhex(text.decode())
        else:
            return False
        return True

    def _send(self, frame: CanFrame) -> bytes:
        if not self.is_open or self._is_listening or not self._channel.send(frame):
            return ERROR
        return (b"Z" if frame.is_extended else b"z") + OK
