"""Lawicel's ASCII protocol of CAN adapters ("slcan"): lines of a client in, commands out; frames to lines.

Source: Lawicel AB, CANUSB manual 1.0D and CAN232 manual V3, the chapters of their commands. Each command ends
with CR and is answered by CR, or by BEL where it cannot be done.
"""

import re
from collections.abc import Sequence
from typing import NamedTuple

from hil.wire.can.can_frame import CanFrame

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
"""What stands behind the letter of each command."""
_COMMAND = re.compile("|".join(f"{letter}{form}" for letter, form in _FORMS.items()).encode())


class SlcanCommand(NamedTuple):
    """Line of a client. ``letter`` is empty for a line that is no command, and CR for an empty line."""

    letter: str
    text: bytes = b""
    """What stands behind the letter."""
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
