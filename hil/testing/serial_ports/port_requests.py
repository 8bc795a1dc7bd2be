"""Requests (ioctl) that pyserial makes of a terminal."""

import errno
import os
import struct
import termios
from typing import Any

from hil.testing.serial_ports.port_terminal import PortTerminal
from hil.vocab.time import SimTimeNs

UINT = struct.Struct("I")
_SET_BREAK, _CLEAR_BREAK = 0x5427, 0x5428  # TIOCSBRK, TIOCCBRK of asm-generic/ioctls.h
_GET_SETTINGS_2, _SET_SETTINGS_2 = 0x802C542A, 0x402C542B  # TCGETS2, TCSETS2
_OUTPUT_SPEED = 10
"""Place of the speed in struct termios2, in ints."""


def answer_request(terminal: PortTerminal, request: int, argument: Any, now_ns: SimTimeNs) -> Any:
    """Answer a request. Raises OSError ENOTTY: as a terminal that does not know it."""
    lines = terminal.lines
    if request == termios.TIOCOUTQ:
        return UINT.pack(0)  # all that a pty has taken is at the other end
    if request == _GET_SETTINGS_2:
        return 0
    if request == _SET_SETTINGS_2:
        terminal.set_custom_baud(argument[_OUTPUT_SPEED], now_ns)
        return 0
    if request in (_SET_BREAK, _CLEAR_BREAK):
        if lines and request == _SET_BREAK:
            lines.send_break(now_ns)
        return argument
    if lines and request == termios.TIOCMGET:
        return UINT.pack(lines.shown)
    if lines and request in (termios.TIOCMBIS, termios.TIOCMBIC):
        bits = UINT.unpack(argument)[0]
        lines.set(lines.on | bits if request == termios.TIOCMBIS else lines.on & ~bits, now_ns)
        return argument
    raise OSError(errno.ENOTTY, os.strerror(errno.ENOTTY))
