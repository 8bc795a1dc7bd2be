"""``hil monitor``: a serial monitor in the terminal, on a port's address as any other client."""

import os
import select
import sys
import termios
import tty
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress

from hil.host.journal import say
from hil.host.shown_stream import own
from hil.net.port_client import opened_port
from hil.vocab.shown_text import printable

QUIT = 0x1D  # Ctrl-]
_READ_BYTES = 4096


def monitor(address: str, seconds: float | None = None, hints: Sequence[str] = ()) -> None:
    """Copy the terminal to the port and the port to the terminal, until Ctrl-], the end of standard
    input (if it is not a terminal: and until ``seconds`` have passed without an answer), or the port's end.
    ``hints``: what somebody who types is told first.

    Raises:
        PortUnreachable: the address cannot be opened.
    """
    with opened_port(address) as port:
        with _raw_terminal(hints):
            is_gone = _copy(port, 1.0 if seconds is None else seconds)
        if is_gone:
            say("hil: the port has gone: its bench has ended, or has the device no more", sys.stderr)


@contextmanager
def _raw_terminal(hints: Sequence[str]) -> Iterator[None]:
    if not sys.stdin.isatty():
        yield
        return
    before = termios.tcgetattr(0)
    try:
        tty.setraw(0, termios.TCSADRAIN)  # what was typed already is for the board, too
        lines = ["Ctrl-] ends the monitor.", *hints]
        # Standard output has the board's bytes alone.
        say("\r\n".join(map(printable, lines)) + "\r", own(sys.stderr))
        yield
    finally:
        termios.tcsetattr(0, termios.TCSADRAIN, before)
        say("", sys.stderr)


def _copy(port: int, quiet_s: float) -> bool:
    """Copy until something ends; answers whether that was the port."""
    interactive = sys.stdin.isatty()
    ended, waiting = False, b""
    os.set_blocking(port, False)  # the board may hold up what is typed until its answers have been read
    while True:
        inputs = [port] if ended or (waiting and not interactive) else [port, 0]
        timeout_s = quiet_s if ended and not waiting else None
        ready, writable, _ = select.select(inputs, [port] if waiting else [], [], timeout_s)
        if not ready and not writable:
            return False
        data = b""
        try:
            with suppress(BlockingIOError):  # another client was quicker
                if port in ready and not (data := os.read(port, _READ_BYTES)):
                    return True
            with suppress(BlockingIOError):
                if writable:
                    waiting = waiting[os.write(port, waiting) :]
        except OSError:  # EIO of a terminal, or a reset: its bench has gone
            return True
        while data:
            data = data[os.write(1, data) :]
        if 0 in ready:
            typed = os.read(0, _READ_BYTES)
            if interactive and QUIT in typed:
                return False
            ended |= not typed
            waiting += typed
