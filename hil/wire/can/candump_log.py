"""Logs of can-utils' ``candump -L``, one frame a line: ``(1700000000.000123) can0 123#0011``.

Source: the manual pages of candump and log2asc in can-utils, and what candump 2020.11 writes.
"""

import re
from collections.abc import Iterator
from typing import NamedTuple

from hil.wire.can.can_frame import DATA_MAX, CanFrame
from hil.wire.can.socketcan import ERROR, EXTENDED, CanError, SocketCanError, from_word

LONGEST_LINE = 400
"""Characters; a frame of CAN FD has up to 200."""
_LINE = re.compile(
    r"\((?P<seconds>\d{1,12})\.(?P<fraction>\d{1,9})\) +(?P<bus>\S+) +"
    r"(?P<id>[0-9A-Fa-f]{3}|[0-9A-Fa-f]{8})#(?P<rest>[0-9A-Fa-f#R]*)(?: +[RT])?"
)
_REMOTE = re.compile("R[0-8]?")


class LoggedFrame(NamedTuple):
    """Line of a log. ``at_ns``: nanoseconds since 1970, or as whoever wrote it counted."""

    at_ns: int
    bus: str
    frame: CanFrame | CanError


class CandumpLogError(ValueError):
    """Error of a line that is none of such a log: ``str(error)`` has its number."""


def read_candump_log(text: str) -> Iterator[LoggedFrame]:
    """Read a log; empty lines do not count.

    Raises:
        CandumpLogError: after all lines before, at the first that cannot be read.
    """
    for number, line in enumerate(text.split("\n"), 1):
        if line := line.strip():
            try:
                yield _parsed(line)
            except ValueError as error:
                raise CandumpLogError(f"line {number}: {error}") from None


def _parsed(line: str) -> LoggedFrame:
    found = _LINE.fullmatch(line) if len(line) <= LONGEST_LINE else None
    if not found:
        raise ValueError(f"{line[:60]!r} is no line as candump -L writes it, (1.000123) can0 123#0011")
    at_ns = int(found["seconds"]) * 10**9 + int(found["fraction"].ljust(9, "0"))
    return LoggedFrame(at_ns, found["bus"], _frame(int(found["id"], 16), len(found["id"]), found["rest"]))


def _frame(word: int, digits: int, rest: str) -> CanFrame | CanError:
    if rest.startswith("#"):
        raise SocketCanError("a frame of CAN FD; this reads classic CAN")
    if digits == 8 and not word & ERROR:
        if word >> 29:
            raise SocketCanError(f"identifier {word:X} has more than 29 bits")
        word |= EXTENDED
    elif digits == 3 and word > 0x7FF:
        raise SocketCanError(f"identifier {word:X} has more than 11 bits; write 8 digits for 29 bits")
    if "R" in rest:
        if not _REMOTE.fullmatch(rest):
            raise SocketCanError(f"{rest!r} is no remote frame, R or R0 to R8")
        frame = from_word(word, b"", 0)
        dlc = int(rest[1:] or 0)
        return frame._replace(is_remote=True, remote_dlc=dlc) if isinstance(frame, CanFrame) else frame
    if "#" in rest or len(rest) % 2 or len(rest) > 2 * DATA_MAX:
        raise SocketCanError(f"{rest!r} is no data, two digits for each of 0 to {DATA_MAX} bytes")
    return from_word(word, bytes.fromhex(rest), len(rest) // 2)
