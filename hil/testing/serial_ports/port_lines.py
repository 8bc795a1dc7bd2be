"""Modem lines and breaks of a port that has them, as of a USB or RFC 2217."""

import termios
from collections.abc import Callable

from hil.testing.serial_ports.line_ends import LineEnd
from hil.vocab.ports import TOUCH_BAUD, TOUCH_S
from hil.vocab.time import FOREVER, NS_PER_S, SimTimeNs

AT_OPENING = termios.TIOCM_DTR | termios.TIOCM_RTS
"""Lines that Linux switches on when a port is opened (tty_port.c)."""
_OF_BOARD = termios.TIOCM_CTS | termios.TIOCM_DSR | termios.TIOCM_CD
"""Lines that the board's side has on: a board is there and ready."""


class PortLines:
    """Lines of a port. ``touched``: resets the board whose own processor is on this USB, and which sends only
    while DTR or RTS is on; None: there is an adapter, which makes a 0 of a break."""

    def __init__(self, end: LineEnd, touched: Callable[[], object] | None) -> None:
        self._end, self._touched = end, touched
        self.on = 0
        """Lines of the client that are on, as bits of TIOCM."""
        self._baud = 0
        self.due_ns = FOREVER
        """Time at which the board resets, because it was touched."""

    @property
    def shown(self) -> int:
        """All lines that are on, as bits of TIOCM."""
        return self.on | _OF_BOARD

    def set(self, lines_on: int, now_ns: SimTimeNs) -> None:
        """Set the client's lines."""
        was_on, self.on = self.on, lines_on
        if lines_on & ~was_on & termios.TIOCM_DTR:
            self._end.opened()
        if self._touched:
            self._end.is_heard = bool(lines_on & AT_OPENING)
            self._watch_touch(now_ns)

    def set_baud(self, baud: int, now_ns: SimTimeNs) -> None:
        """Note the client's speed."""
        self._baud = baud
        if self._touched:
            self._watch_touch(now_ns)

    def _watch_touch(self, now_ns: SimTimeNs) -> None:
        if self._baud != TOUCH_BAUD or self.on & termios.TIOCM_DTR:
            self.due_ns = FOREVER
        elif self.due_ns == FOREVER:
            self.due_ns = SimTimeNs(now_ns + round(TOUCH_S * NS_PER_S))

    def passed(self, now_ns: SimTimeNs) -> None:
        """Note that time has passed."""
        if self._touched and self.due_ns <= now_ns:
            self.due_ns = FOREVER
            self._baud = 0  # one touch resets it once
            self._touched()

    def send_break(self, now_ns: SimTimeNs) -> None:
        """Send a break."""
        if not self._touched and self._end.room(now_ns):
            self._end.feed(b"\0")
