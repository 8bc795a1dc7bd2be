"""Logs of can-utils' ``candump``: those of ``-L``, one frame a line, ``(1700000000.000123) can0 123#0011``,
and what it shows on a terminal, ``can0  123   [2]  00 11``, with any of its times or none.

An error frame has the eight digits of SocketCAN's identifier, with its flag. Those written here have the
class of a bus error too, by which python-can's reader knows them.

Source: the manual pages of candump and log2asc in can-utils, and what candump 2020.11 writes; for
-8 its source.
"""

import re
from collections.abc import Iterable, Iterator, Sequence
from typing import NamedTuple

from bridges.can.frames.can_frame import DATA_MAX, CanFrame, parse_data, parse_frame
from bridges.can.frames.socketcan import BUS_ERROR, ERROR, EXTENDED, REMOTE, CanError, error_parts, from_word
from hil.wire.outside_text import LeftOut

LONGEST_LINE = 1000
"""Characters; a frame of CAN FD on a terminal, with its letters, has up to 350."""
_TIME = r"\((?:(\d{4})-(\d\d)-(\d\d) (\d\d):(\d\d):(\d\d)|(\d{1,12}))\.(\d{1,9})\)"
_SHORT = re.compile(rf"(?:{_TIME} *)?(\S+) +([0-9A-Fa-f]+#\S*)(?: +[RT])?")
_LONG = re.compile(
    rf"(?:{_TIME} +)?(\S+) +(?:[RT]X +\S +\S +)?([0-9A-Fa-f]{{3}}|[0-9A-Fa-f]{{8}}) +"
    r"([\[{][0-9A-Fa-f]{1,2}[\]}])(?: +(.*))?"
)
_BYTES = re.compile(r"[0-9A-Fa-f]{2}(?: [0-9A-Fa-f]{2})*(?= {2}|$)")
_ERROR_FRAME = re.compile("([0-9A-Fa-f]{8})#([0-9A-Fa-f]{0,16})")
_RAW_DLC = re.compile("(.*#(?:[0-9A-Fa-f]{16}|R8?))_[9A-Fa-f]")
"""Frame with the length code that is more than 8, of 8 bytes (candump -8)."""
_COLOURS = re.compile(r"\x1b\[[0-9;]*m")
_COUNTED_FROM = re.compile(r"\(\d{3}\.")
"""Beginning of a time that does not count from 1970: since the first frame (-tz), or the one before (-td)."""
_OF_A_CYCLE = 2
"""Number of times in a log of differences that are all alike: that of the first frame is 0."""
_OF_FD = "a frame of CAN FD; this reads classic CAN"


class LoggedFrame(NamedTuple):
    """Line of a log. ``at_ns``: nanoseconds since 1970, or by the writer's clock; 0: it has no times."""

    at_ns: int
    bus: str
    frame: CanFrame | CanError


class _NoLineError(ValueError):
    """Error of a line that is none of candump's."""


def candump_line(logged: LoggedFrame) -> str:
    """Write a line, without its end; times are microseconds, cut off."""
    seconds, rest_ns = divmod(logged.at_ns, 10**9)
    text = str(logged.frame)
    if isinstance(logged.frame, CanError):
        error_class, data = error_parts(logged.frame)
        text = f"{ERROR | BUS_ERROR | error_class:08X}#{data.hex().upper()}"
    return f"({seconds}.{rest_ns // 1000:06}) {logged.bus} {text}"


def is_candump_line(line: str) -> bool:
    """True if a line looks like one of candump's."""
    line = _COLOURS.sub("", line[:LONGEST_LINE]).strip()
    return bool(_SHORT.fullmatch(line) or _LONG.fullmatch(line))


def read_candump(lines: Sequence[str], left_out: LeftOut) -> Iterator[LoggedFrame]:
    """Read a whole log, as ``read_candump_lines``; times that are differences are found and added up."""
    frames = read_candump_lines(lines, left_out)
    if not _has_differences(lines):
        return frames
    left_out.note("its times are differences (candump -td), and were added up")
    return _added_up(frames)


def read_candump_lines(lines: Iterable[str], left_out: LeftOut) -> Iterator[LoggedFrame]:
    """Read the lines of a log as they come; empty ones do not count, and those that are none are left out."""
    for number, line in enumerate(lines, 1):
        if line.startswith("\t"):  # words for the error frame before (candump -e)
            continue
        if line := _COLOURS.sub("", line[: LONGEST_LINE + 1]).strip():
            try:
                yield _parsed(line)
            except _NoLineError:
                left_out.add(f"line {number}", "no line of candump's, as in (1.000123) can0 123#0011", line)
            except ValueError as error:
                left_out.add(f"line {number}", str(error))


def _parsed(line: str) -> LoggedFrame:
    found = (_SHORT.fullmatch(line) or _LONG.fullmatch(line)) if len(line) <= LONGEST_LINE else None
    if not found:
        raise _NoLineError
    *time, bus, frame = found.groups()[:10]
    at_ns = _at_ns(time) if time[-1] else 0
    return LoggedFrame(at_ns, bus, _short(frame) if "#" in frame else _long(frame, *found.groups()[10:]))


def _at_ns(time: Sequence[str]) -> int:
    *date, seconds, fraction = time
    whole = int(seconds) if seconds else _since_1970_s(*map(int, date))
    return whole * 10**9 + int(fraction.ljust(9, "0"))


def _since_1970_s(year: int, month: int, day: int, hour: int, minute: int, second: int) -> int:
    """Seconds of a date of the Gregorian calendar, without leap seconds; of one before 1970, 0."""
    in_year = (month + 9) % 12  # from March on: the leap day is the last
    years = year - (month < 3)
    days = 365 * years + years // 4 - years // 100 + years // 400 + (153 * in_year + 2) // 5 + day - 719_469
    return max(days * 86_400 + hour * 3600 + minute * 60 + second, 0)


def _short(text: str) -> CanFrame | CanError:
    error = _ERROR_FRAME.fullmatch(text)
    if error and (word := int(error[1], 16)) & ERROR:
        data = parse_data(error[2])
        return from_word(word, data, len(data))
    raw = _RAW_DLC.fullmatch(text)
    return parse_frame(raw[1] if raw else text)


def _long(identifier: str, length: str, rest: str | None) -> CanFrame | CanError:
    """Frame as on a terminal: its length in brackets, of CAN FD with two digits; in braces the length code
    of 8 bytes that is more than 8."""
    if length.startswith("[") and len(length) > 3:
        raise ValueError(_OF_FD)
    size = min(int(length[1:-1], 16), DATA_MAX)
    word = int(identifier, 16)
    if len(identifier) == 8 and not word & ERROR:
        word |= EXTENDED
    if rest and rest.startswith("remote request"):
        return from_word(word | REMOTE, b"", size)
    found = _BYTES.match(rest or "")
    data = bytes.fromhex(found[0]) if found else b""
    if len(data) < size:
        raise ValueError(f"{len(data)} bytes of data, where the frame says {size}")
    return from_word(word, data[:size], size)


def _has_differences(lines: Iterable[str]) -> bool:
    """True if times cannot count from the first frame, as they go back on a bus, or are one cycle alone. Two
    frames of a bus at once say nothing: adapters give several a time together."""
    latest: dict[str, str] = {}
    times: set[str] = set()
    is_tied = False
    for line in lines:
        line = _COLOURS.sub("", line[:LONGEST_LINE]).strip()
        if not _COUNTED_FROM.match(line) or len(words := line.split(None, 2)) < 3:
            continue
        at, bus = words[:2]
        if at < latest.get(bus, ""):
            return True
        if len(times) <= _OF_A_CYCLE:
            times.add(at)
        is_tied |= at == latest.get(bus) and len(times) == _OF_A_CYCLE
        latest[bus] = at
    return is_tied and len(times) == _OF_A_CYCLE


def _added_up(frames: Iterable[LoggedFrame]) -> Iterator[LoggedFrame]:
    now_ns = 0
    for frame in frames:
        now_ns += frame.at_ns
        yield frame._replace(at_ns=now_ns)
