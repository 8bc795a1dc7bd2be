"""Logs of can-utils' ``candump -L``, one frame a line: ``(1700000000.000123) can0 123#0011``.

An error frame has the eight digits of SocketCAN's identifier, with its flag. Those written here have the
class of a bus error too, by which python-can's reader knows them.

Source: the manual pages of candump and log2asc in can-utils, and what candump 2020.11 writes.
"""

import re
from collections.abc import Iterable, Iterator
from typing import NamedTuple

from hil.wire.can.can_frame import CanFrame
from hil.wire.can.frame_text import parse_data, parse_frame
from hil.wire.can.socketcan import BUS_ERROR, ERROR, CanError, error_parts, from_word

LONGEST_LINE = 400
"""Characters; a frame of CAN FD has up to 200."""
_LINE = re.compile(r"\((\d{1,12})\.(\d{1,9})\) +(\S+) +(\S+)(?: +[RT])?")
_ERROR_FRAME = re.compile("([0-9A-Fa-f]{8})#([0-9A-Fa-f]{0,16})")


class LoggedFrame(NamedTuple):
    """Line of a log. ``at_ns``: nanoseconds since 1970, or by the writer's clock."""

    at_ns: int
    bus: str
    frame: CanFrame | CanError


class CandumpLogError(ValueError):
    """Error of a line that is none of such a log: ``str(error)`` has its number."""


def candump_line(logged: LoggedFrame) -> str:
    """Write a line, without its end; times are microseconds, cut off."""
    seconds, rest_ns = divmod(logged.at_ns, 10**9)
    text = str(logged.frame)
    if isinstance(logged.frame, CanError):
        error_class, data = error_parts(logged.frame)
        text = f"{ERROR | BUS_ERROR | error_class:08X}#{data.hex().upper()}"
    return f"({seconds}.{rest_ns // 1000:06}) {logged.bus} {text}"


def read_candump_log(text: str) -> Iterator[LoggedFrame]:
    """Read a log, as ``read_candump_lines``."""
    return read_candump_lines(text.split("\n"))


def read_candump_lines(lines: Iterable[str]) -> Iterator[LoggedFrame]:
    """Read the lines of a log as they come; empty ones do not count.

    Raises:
        CandumpLogError: after all lines before, at the first that cannot be read.
    """
    for number, line in enumerate(lines, 1):
        if line := line.strip():
            try:
                yield _parsed(line)
            except ValueError as error:
                raise CandumpLogError(f"line {number}: {error}") from None


def _parsed(line: str) -> LoggedFrame:
    found = _LINE.fullmatch(line) if len(line) <= LONGEST_LINE else None
    if not found:
        raise ValueError(f"{line[:60]!r} is no line as candump -L writes it, (1.000123) can0 123#0011")
    seconds, fraction, bus, frame = found.groups()
    return LoggedFrame(int(seconds) * 10**9 + int(fraction.ljust(9, "0")), bus, _frame(frame))


def _frame(text: str) -> CanFrame | CanError:
    error = _ERROR_FRAME.fullmatch(text)
    if error and (word := int(error[1], 16)) & ERROR:
        data = parse_data(error[2])
        return from_word(word, data, len(data))
    return parse_frame(text)
