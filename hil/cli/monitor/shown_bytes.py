"""Views of the bytes that come at a port: as they are, with the simulated time of each line, or as hex. Pure.

A view takes pieces of any length and answers bytes for the standard output. ``is_raw``: the output is a
terminal in raw mode, where a line feed alone goes down and not to the line's beginning.
"""

import re
from typing import Protocol

_LONE_FEED = re.compile(rb"(?<!\r)\n")
_PREFIX = "{:12.6f} "
"""Simulated time of a line, in s to the microsecond: captures have no more of a byte at a port."""
_WIDTHS = (16, 8, 4)
_OFFSET = 10
"""Length of a row's number and the blanks behind it."""


class ByteView(Protocol):
    """View of what comes. ``has_time``: it needs the simulated time of each piece."""

    has_time: bool

    def came(self, data: bytes, at_ns: int = 0) -> bytes:
        """Show bytes that came, the first at this simulated time."""

    def echo(self, keys: bytes) -> bytes:
        """Show what was typed."""

    def pause(self) -> bytes:
        """Show what is held back: nothing comes for a while."""

    def is_holding(self) -> bool:
        """True if something is held back until a pause."""

    def fresh_line(self) -> bytes:
        """Answer what ends the line that is begun, if one is: something else stands below it."""


class PlainView:
    """Bytes as they are. ``feeds_return``: a line feed alone becomes a carriage return and a line feed."""

    has_time = False

    def __init__(self, *, is_raw: bool = False, feeds_return: bool = False) -> None:
        self._end = b"\r\n" if is_raw else b"\n"
        self._feeds_return = feeds_return
        self._last = b"\n"

    def came(self, data: bytes, at_ns: int = 0) -> bytes:
        shown = returned(self._last, data) if self._feeds_return else data
        self._last = data[-1:] or self._last
        return shown

    def echo(self, keys: bytes) -> bytes:
        return self._end.join(re.split(rb"\r\n|\r|\n", keys))

    def pause(self) -> bytes:
        return b""

    def is_holding(self) -> bool:
        return False

    def fresh_line(self) -> bytes:
        """End the line that is begun."""
        last, self._last = self._last, b"\n"
        return b"" if last == b"\n" else self._end


class TimedView:
    """Lines behind the simulated time at which the first byte of each came."""

    has_time = True

    def __init__(self, *, is_raw: bool = False, feeds_return: bool = False) -> None:
        self._end = b"\r\n" if is_raw else b"\n"
        self._feeds_return = feeds_return or is_raw
        self._last, self._is_echoed = b"\n", False

    def came(self, data: bytes, at_ns: int = 0) -> bytes:
        shown = bytearray()
        for line in _lines(data):
            if self._last == b"\n":
                if self._is_echoed:
                    shown += self._end
                shown += _PREFIX.format(at_ns * 1e-9).encode()
            shown += returned(self._last, line) if self._feeds_return else line
            self._last, self._is_echoed = line[-1:], False
        return bytes(shown)

    def echo(self, keys: bytes) -> bytes:
        shown = self._end.join(re.split(rb"\r\n|\r|\n", keys))
        self._is_echoed = not shown.endswith(self._end) if shown else self._is_echoed
        return shown

    def pause(self) -> bytes:
        return b""

    def is_holding(self) -> bool:
        return False

    def fresh_line(self) -> bytes:
        """End the line that is begun."""
        is_begun = self._last != b"\n" or self._is_echoed
        self._last, self._is_echoed = b"\n", False
        return self._end if is_begun else b""


class HexView:
    """Rows of bytes as hex with their characters beside, behind the number of the first byte. A row ends when
    it is full or after a pause. ``columns``: width of the terminal. ``has_time``: a row begins with the
    simulated time of its first byte."""

    def __init__(self, *, is_raw: bool = False, columns: int = 80, has_time: bool = False) -> None:
        self.has_time = has_time
        self._end = b"\r\n" if is_raw else b"\n"
        room = columns - (len(_PREFIX.format(0)) if has_time else 0)
        self._width = next((each for each in _WIDTHS if _row_length(each) < room), _WIDTHS[-1])
        self._row, self._at_ns, self._number = b"", 0, 0

    def came(self, data: bytes, at_ns: int = 0) -> bytes:
        shown = bytearray()
        while data:
            if not self._row:
                self._at_ns = at_ns
            room = self._width - len(self._row)
            self._row, data = self._row + data[:room], data[room:]
            if len(self._row) == self._width:
                shown += self.pause()
        return bytes(shown)

    def echo(self, keys: bytes) -> bytes:
        return b""

    def pause(self) -> bytes:
        if not self._row:
            return b""
        row, number, self._row = self._row, self._number, b""
        self._number += len(row)
        time = _PREFIX.format(self._at_ns * 1e-9) if self.has_time else ""
        pairs = f"{row.hex(' '):<{3 * self._width}}"
        text = "".join(chr(byte) if 0x20 <= byte < 0x7F else "." for byte in row)
        return f"{time}{number:08x}  {pairs} {text}".encode() + self._end

    def is_holding(self) -> bool:
        return bool(self._row)

    def fresh_line(self) -> bytes:
        return self.pause()


def _row_length(width: int) -> int:
    return _OFFSET + 3 * width + 1 + width


def _lines(data: bytes) -> list[bytes]:
    """Parts of a text that end behind its line feeds, and what stands behind the last."""
    return [line for line in re.split(rb"(?<=\n)", data) if line]


def returned(before: bytes, data: bytes) -> bytes:
    r"""Put a carriage return before each line feed that has none. ``before``: the byte before."""
    shown = _LONE_FEED.sub(b"\r\n", data)
    return shown[1:] if before == b"\r" and data.startswith(b"\n") else shown
