"""Vector's text logs, ``.asc``: as Vector's tools write them, and BUSMASTER, Kvaser's, can-utils, python-can.

A header says whether numbers are hexadecimal and whether times count from the beginning or from the line
before; BUSMASTER says both in one line with others, some say nothing. Every line of an event begins with its
time. Events that are no frames (states, statistics, comments) say nothing here. What the bus did not carry as
a frame of classic CAN, or a second time, is left out: CAN FD, other buses, requests to send (``TxRq``, whose
frame follows), messages of J1939's transport (whose frames are there).

Sources: can-utils' asc2log and its manual page; files in the tests of python-can, Wireshark and can-utils.
"""

import re
from collections.abc import Iterable, Iterator, Sequence

from bridges.can.frames.can_frame import DATA_MAX, EXTENDED_ID_MAX, STANDARD_ID_MAX, CanFrame
from bridges.can.frames.candump_log import LoggedFrame
from bridges.can.frames.socketcan import CanError
from hil.wire.outside_text import LeftOut

LONGEST_LINE = 4000
"""Characters; CANoe's of a frame of CAN FD has up to 400, with what it says behind the data."""
_EVENT = re.compile(r"([0-9]{1,9})[.,]([0-9]{1,9})\s+(\S.*)")
_HEADER = re.compile(r"(?:date|begin|end|(?:no\s+)?internal)\b|//|;|#", re.IGNORECASE)
_BASE = re.compile(r"base\s+(hex|dec)\b", re.IGNORECASE)
_TIMES = re.compile(r"timestamps\s+(absolute|relative)\b", re.IGNORECASE)
_NO_FRAME = re.compile(
    r"start of|end of|stop|log |comment|statistic|sv:|//|trigger|previous|"
    r"can\s+\d+\s+status|(?:can\s+)?\d+\s+(?:statistic|status|overloadframe)",
    re.IGNORECASE,
)
"""Events of the measurement and of the bus that are no frames."""
_IDENTIFIER = {
    16: re.compile("(?:0x(?=[0-9a-f]))?([0-9a-f]{1,8})(x?)", re.IGNORECASE),
    10: re.compile("([0-9]{1,10})(x?)", re.IGNORECASE),
}
_DIGITS = {16: re.compile("[0-9A-Fa-f]{1,8}"), 10: re.compile("[0-9]{1,10}")}
_ID_BEHIND = re.compile(r"\bID = ([0-9]{1,10})(x?)", re.IGNORECASE)
"""Identifier behind the data, always decimal; 0 where the program did not know it."""
_WAYS = ("rx", "tx", "txrq")
_REMOTE_FLAG, _FD_FLAG = 0x10, 0x1000
"""Flags of a line of a bus that has CAN FD, in hexadecimal: a remote frame, a frame of CAN FD."""
_BEHIND_DATA = 2
"""Numbers between the data and the flags: how long the frame took, and its bits."""
_CLASSIC_BYTES = {str(n): n for n in range(DATA_MAX + 1)}


def is_asc_header(line: str) -> bool:
    """True if a line looks like one of the first of such a file, or like an event."""
    line = line.strip()
    return bool(_HEADER.match(line) or _BASE.match(line) or _EVENT.fullmatch(line[:LONGEST_LINE]))


def read_asc(lines: Iterable[str], left_out: LeftOut) -> Iterator[LoggedFrame]:
    """Read the lines of a log; times count as the file's do."""
    base, is_relative, now_ns = 16, False, 0
    for number, line in enumerate(lines, 1):
        if not (line := line[: LONGEST_LINE + 1].strip()):
            continue
        if found := _BASE.match(line):
            base = 16 if found[1].lower() == "hex" else 10
            times = _TIMES.search(line)
            is_relative = times is not None and times[1].lower() == "relative"
            continue
        event = _EVENT.fullmatch(line) if len(line) <= LONGEST_LINE else None
        if not event:
            if not _HEADER.match(line):
                left_out.add(f"line {number}", "no line of such a log", line)
            continue
        at_ns = int(event[1]) * 10**9 + int(event[2].ljust(9, "0"))
        now_ns = now_ns + at_ns if is_relative else at_ns
        if _NO_FRAME.match(event[3]):
            continue
        try:
            bus, frame = _frame(event[3], base)
        except ValueError as error:
            left_out.add(f"line {number}", str(error))
            continue
        yield LoggedFrame(now_ns, bus, frame)


def _frame(text: str, base: int) -> tuple[str, CanFrame | CanError]:
    """Bus and frame of an event. Raises ValueError: it is none of classic CAN, or a second time."""
    words = text.split()
    if words[0].lower() == "canfd" and len(words) > 1:
        return _bus(words[1]), _of_fd_bus(words[2:], text, base)
    if words[0].lower() == "can" and len(words) > 1:
        words = words[1:]
    bus, kind = _bus(words[0]), words[1].lower() if len(words) > 1 else ""
    if kind == "errorframe":
        return bus, CanError("")
    if kind == "j1939tp":
        raise ValueError("a message of J1939's transport, whose frames are there")
    if len(words) < 4 or words[2].lower() not in _WAYS or words[3].lower() not in ("d", "r"):
        raise ValueError(f"{text[:40]!r} is no frame")
    _refuse_request(words[2])
    identifier, is_extended = _identifier(words[1], text, base)
    if words[3].lower() == "r":
        dlc = int(words[4], base) if len(words) > 4 and _DIGITS[base].fullmatch(words[4]) else 0
        return bus, CanFrame(identifier, b"", is_extended, True, min(dlc, DATA_MAX))
    size = min(_number(words[4] if len(words) > 4 else "", base), DATA_MAX)
    return bus, CanFrame(identifier, _data(words[5 : 5 + size], size, base), is_extended)


def _of_fd_bus(words: Sequence[str], text: str, base: int) -> CanFrame | CanError:
    """Frame of a bus that has CAN FD: way, identifier, perhaps its name, two bits, length code, number of
    bytes, these, and what is behind them, of which the flags say what it is."""
    if len(words) > 1 and "errorframe" in (words[0].lower(), words[1].lower()):
        return CanError("")
    if len(words) < 2 or words[0].lower() not in _WAYS:
        raise ValueError(f"{text[:40]!r} is no frame")
    _refuse_request(words[0])
    rest = words[2:] if words[2:3] and words[2] in ("0", "1") else words[3:]
    size = _CLASSIC_BYTES.get(rest[3]) if len(rest) > 3 else None
    if size is None:
        raise ValueError("a frame of CAN FD; this reads classic CAN")
    behind = rest[4 + size + _BEHIND_DATA :]
    flags = _number(behind[0], 16, 0xFFFF_FFFF) if behind else _FD_FLAG
    if flags & _FD_FLAG or rest[0] == "1":
        raise ValueError("a frame of CAN FD; this reads classic CAN")
    identifier, is_extended = _identifier(words[1], text, base)
    if flags & _REMOTE_FLAG:
        return CanFrame(identifier, b"", is_extended, True, min(_number(rest[2], 16), DATA_MAX))
    return CanFrame(identifier, _data(rest[4 : 4 + size], size, base), is_extended)


def _bus(channel: str) -> str:
    """Name of a channel; they count from 1."""
    digits = channel[3:] if channel.lower().startswith("can") else channel
    if not (digits.isascii() and digits.isdecimal() and len(digits) < 6):
        raise ValueError(f"an event of {channel[:20]!r}, which is no CAN bus")
    return f"can{max(int(digits) - 1, 0)}"


def _refuse_request(way: str) -> None:
    if way.lower() == "txrq":
        raise ValueError("a request to send (TxRq), whose frame follows")


def _identifier(word: str, text: str, base: int) -> tuple[int, bool]:
    """Identifier, and True if it has 29 bits; what stands behind the data counts where there is a name."""
    behind, own = _ID_BEHIND.search(text), _IDENTIFIER[base].fullmatch(word)
    if behind and (int(behind[1]) or not own):
        identifier, is_extended = int(behind[1]), bool(behind[2]) or bool(own and own[2])
    elif own:
        identifier, is_extended = int(own[1], base), bool(own[2])
    else:
        raise ValueError(f"{word[:40]!r} is no identifier: save the log with numbers in place of names")
    if identifier > EXTENDED_ID_MAX:
        raise ValueError(f"identifier {identifier:X} has more than 29 bits")
    return identifier, is_extended or identifier > STANDARD_ID_MAX


def _data(words: Sequence[str], size: int, base: int) -> bytes:
    if len(words) < size:
        raise ValueError(f"{len(words)} bytes of data, where the frame says {size}")
    return bytes(_number(word, base, 255) for word in words)


def _number(word: str, base: int, most: int = 15) -> int:
    """Number in a base. Raises ValueError."""
    if not _DIGITS[base].fullmatch(word) or (value := int(word, base)) > most:
        raise ValueError(f"{word[:20]!r} is no number of 0 to {most}")
    return value
