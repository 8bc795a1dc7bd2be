"""Lawicel's ASCII protocol of CAN adapters ("slcan"): lines of a client in, commands out; frames to lines;
and the adapter that carries them out.

Source: Lawicel AB, CANUSB manual 1.0D and CAN232 manual V3, the chapters of their commands. Each command ends
with CR and is answered by CR, or by BEL where it cannot be done.
"""

import re
from collections.abc import Sequence
from enum import IntFlag
from typing import NamedTuple, Protocol

from bridges.can.frames.can_frame import CanFrame

OK, ERROR = b"\r", b"\a"
BIT_RATES = (10_000, 20_000, 50_000, 100_000, 125_000, 250_000, 500_000, 800_000, 1_000_000)
"""Bits per second of S0 to S8."""
LINE_MAX = 26
"""Characters of the longest command, an extended frame with 8 bytes."""
ACCEPT_ALL = bytes(4), b"\xff" * 4
"""Acceptance code and mask of an adapter that was just switched on."""
_QUARTZ_HZ = 16_000_000
"""Clock of the SJA1000, which the two bytes of the command ``s`` are for."""
_STAMP_MS = 60_000
_HEX = "[0-9A-Fa-f]"
_FORMS = {
    "S": "[0-8]",
    "s": _HEX + "{4}",
    "M": _HEX + "{8}",
    "m": _HEX + "{8}",
    "Z": "[01]",
    "t": f"[0-7]{_HEX}{{2}}(?:[0-8])(?:{_HEX}{{2}})*",
    "T": f"[01]{_HEX}{{7}}(?:[0-8])(?:{_HEX}{{2}})*",
    "r": f"[0-7]{_HEX}{{2}}[0-8]",
    "R": f"[01]{_HEX}{{7}}[0-8]",
    **dict.fromkeys("OLCFVN", ""),
}
"""Forms of the text behind the letter of each command."""
_COMMAND = re.compile("|".join(f"{letter}{form}" for letter, form in _FORMS.items()).encode())


class SlcanCommand(NamedTuple):
    """Line of a client. ``letter`` is empty for a line that is no command, and CR for an empty line."""

    letter: str
    text: bytes = b""
    """The text behind the letter."""
    frame: CanFrame | None = None


_NONE, _EMPTY = SlcanCommand(""), SlcanCommand("\r")


class SlcanSplitter:
    """Splits what a client sends. It holds less than a line."""

    def __init__(self) -> None:
        self._held = b""
        self._is_long = False
        """True if what is held has lost its beginning, as it is too long for a command."""

    def feed(self, data: bytes) -> Sequence[SlcanCommand]:
        """Take bytes; gives the commands that they complete, one for each line."""
        *lines, rest = (self._held + data).split(b"\r")
        commands = [parse(line) for line in lines]
        if self._is_long and lines:
            commands[0] = _NONE
            self._is_long = False
        if len(rest) > LINE_MAX + 1:  # a line feed may come before
            self._is_long = True
        self._held = rest[: LINE_MAX + 2]
        return commands


def parse(line: bytes) -> SlcanCommand:
    """Parse a line without its CR. Line feeds around it, as of terminals, do not count."""
    if len(line) > LINE_MAX + 1:
        return _NONE
    line = line.strip(b"\n")
    if not line:
        return _EMPTY
    if not _COMMAND.fullmatch(line):
        return _NONE
    letter = chr(line[0])
    if letter not in "tTrR":
        return SlcanCommand(letter, line[1:])
    digits = 8 if letter in "TR" else 3
    dlc = line[1 + digits] - ord("0")
    data = line[2 + digits :]
    is_remote = letter in "rR"
    if not is_remote and len(data) != 2 * dlc:
        return _NONE
    frame = CanFrame(
        int(line[1 : 1 + digits], 16),
        bytes.fromhex(data.decode()),
        digits == 8,
        is_remote,
        dlc if is_remote else 0,
    )
    return SlcanCommand(letter, line[1:], frame)


def encode(frame: CanFrame, stamp_ns: int | None = None) -> bytes:
    """Encode a frame as adapter and client send it, with the milliseconds of a minute if a time is given."""
    stamp = b"" if stamp_ns is None else b"%04X" % (stamp_ns // 1_000_000 % _STAMP_MS)
    if frame.is_extended:
        head = b"%c%08X%d" % (b"R" if frame.is_remote else b"T", frame.id, frame.dlc)
    else:
        head = b"%c%03X%d" % (b"r" if frame.is_remote else b"t", frame.id, frame.dlc)
    return head + frame.data.hex().upper().encode() + stamp + OK


def bit_rate_of(registers: bytes) -> int:
    """Bit rate of the command ``s``: the registers BTR0 and BTR1 of an SJA1000 at 16 MHz (its data sheet,
    6.5.1 and 6.5.2), rounded down."""
    prescaler = (registers[0] & 0x3F) + 1
    quanta = 3 + (registers[1] & 0x0F) + (registers[1] >> 4 & 0x07)
    return _QUARTZ_HZ // (2 * prescaler * quanta)


def accepts(code: bytes, mask: bytes, frame: CanFrame) -> bool:
    """True if a frame passes one of the two filters of an SJA1000 (its data sheet, 6.4.15): the first two
    bytes of code and mask, or the other two. Bits where the mask has ones do not count."""
    if frame.is_extended:
        head, counted = frame.id >> 13, 0xFFFF
    else:
        # Below the identifier stand RTR and the first byte, in two halves; the second filter is without it.
        head, counted = frame.id << 5 | frame.is_remote << 4, 0xFFF0
    for at in (0, 2):
        wrong = (head ^ int.from_bytes(code[at : at + 2])) & ~int.from_bytes(mask[at : at + 2]) & counted
        if not wrong and (at or frame.is_extended or _first_byte_passes(code, mask, frame)):
            return True
    return False


def _first_byte_passes(code: bytes, mask: bytes, frame: CanFrame) -> bool:
    if not frame.data:
        return True
    wanted, free = ((each[1] & 0x0F) << 4 | each[3] & 0x0F for each in (code, mask))
    return not (frame.data[0] ^ wanted) & ~free


ADAPTER_VERSION = b"V1013"
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
            return ADAPTER_VERSION + OK
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
