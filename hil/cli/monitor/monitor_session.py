"""Session of ``hil monitor``: bytes between the terminal and a port, which may go and come again."""

import math
import os
import select
import sys
import termios
import time
import tty
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager, nullcontext, suppress
from dataclasses import dataclass
from enum import Enum
from pathlib import Path
from typing import TYPE_CHECKING, BinaryIO

from hil.cli.boards.board_access import SHARED
from hil.cli.monitor.port_look import PortWatch, SeenPort
from hil.cli.monitor.shown_bytes import ByteView
from hil.cli.monitor.typed_keys import KeyReader
from hil.host.journal import say
from hil.host.new_file import begin_file
from hil.host.shown_stream import own
from hil.net.control_client import ControlError
from hil.net.port_client import PortUnreachable, opened_port
from hil.vocab.shown_text import printable

if TYPE_CHECKING:
    from hil.cli.monitor.timed_bytes import TimedBytes

_READ_BYTES = 4096
_PAUSE_S = 0.1
"""Pause after which a row that is not full is shown."""
QUIET_S = 1.0
"""Time without an answer after which the end of the standard input ends the session."""
MOST_S = 5.0
"""Time after which that end ends it, whatever a board says without being asked."""
_GONE = "the port has gone: its bench has ended, or has the device no more"
ONE_OF = "each byte that the device says goes to one of you"
BOTH = "both get all that the device says, and it gets what both type"


class _End(Enum):
    LEFT = 0
    """By a key, or by the end of the standard input."""
    PORT_GONE = 1


class ReceivedLog:
    """File with all bytes that came, exactly. It takes the place of what was there.

    Raises:
        OSError: it cannot be written.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._file: BinaryIO | None = begin_file(path)
        self.failure = ""

    def write(self, data: bytes) -> str:
        """Write bytes; answers why that failed, once: the file ends there."""
        if self._file is None:
            return ""
        try:
            self._file.write(data)
            self._file.flush()
        except OSError as error:
            self.failure = f"{self.path}: {error.strerror}"
            self.close()
            return self.failure
        return ""

    def close(self) -> None:
        """Close it; what could not be written is given up."""
        file, self._file = self._file, None
        if file is not None:
            with suppress(OSError):
                file.close()


@dataclass
class MonitorSession:
    """Session at the port of this name. ``is_typed``: somebody types at the standard input, a terminal.
    ``waits``: the port is waited for, at the beginning and whenever it has gone; then the end of the standard
    input ends nothing. ``echoes``: what is typed is shown."""

    name: str
    keys: KeyReader
    view: ByteView
    is_typed: bool
    waits: bool
    echoes: bool = False
    log: ReceivedLog | None = None
    watch: PortWatch | None = None
    quiet_s: float = QUIET_S
    most_s: float = MOST_S
    keyboard: int = 0
    out: int = 1
    """File descriptors: standard input and output."""

    def __post_init__(self) -> None:
        self._has_input = True
        self._ended_s = math.inf
        """Time at which the standard input was at its end, and all of it was with the board."""
        self._clients = 0
        self._awaited_why = ""
        """Reason why the port is away, as it was said; empty: it is not."""

    def run(self, seen: SeenPort | None, hints: Sequence[str] = ()) -> None:
        """Carry bytes until somebody ends it. ``seen``: the port; None: it is still away. ``hints``: what
        somebody who types is told first.

        Raises:
            PortUnreachable: the address cannot be opened, and was not away before.
            ControlError: the bench does not tell times, likewise.
        """
        with _raw_terminal(self.keyboard, hints) if self.is_typed else nullcontext():
            while True:
                why = self._at_port(seen) if seen else f"{self.name} is not there"
                if why and not self.waits:
                    self._tell(why)
                if not why or not self.waits:
                    return
                if why != self._awaited_why:
                    way_out = "Ctrl-]" if self.is_typed else "Ctrl-C"
                    self._tell(f"{why}; waiting until it is there ({way_out} ends the monitor)")
                self._awaited_why = why
                if (seen := self._wait()) is None:
                    return

    def _tell(self, *lines: str, head: str = "hil: ") -> None:
        """Say something below what is shown."""
        self._show(self.view.fresh_line())
        for line in lines:
            say(f"{head}{printable(line)}" + ("\r" if self.is_typed else ""), own(sys.stderr))

    def _show(self, data: bytes) -> None:
        while data:
            data = data[os.write(self.out, data) :]

    # ---- while the port is away ----

    def _wait(self) -> SeenPort | None:
        """Wait until the port is there; None: somebody has ended the session. Other keys are nobody's."""
        assert self.watch
        self.watch.away(True)
        while True:
            inputs = [self.watch.fd] + [self.keyboard] * (self.is_typed and self._has_input)
            ready = select.select(inputs, [], [])[0]
            if self.keyboard in ready:
                typed = self._typed()
                if typed is None:
                    return None
            if self.watch.fd in ready and (seen := self.watch.take_news()):
                self.watch.away(False)
                return seen

    def _typed(self) -> bytes | None:
        """Read what is typed: bytes for the board; None: the session ends."""
        given = os.read(self.keyboard, _READ_BYTES)
        self._has_input &= bool(given)
        if not self.is_typed:
            return given
        came = self.keys.read(given)
        if came.is_end or not given:
            return None
        if came.asks_help:
            self._tell(*self.keys.help_lines(), head="  ")
        if came.unknown:
            self._tell(f"Ctrl-T {came.unknown} types nothing; Ctrl-T ? lists what does")
        return came.data

    # ---- at the port ----

    def _at_port(self, seen: SeenPort) -> str:
        """Carry bytes until something ends; answers why the port has gone, empty if it has not."""
        with ExitStack() as resources:
            try:
                timed = self._timed(seen)
                if timed:
                    resources.callback(timed.close)
                port = resources.enter_context(opened_port(seen.address))
            except (PortUnreachable, ControlError) as error:
                if not self._awaited_why:
                    raise
                return str(error)
            if self._awaited_why:
                self._tell(f"{self.name} is there, at {seen.address}")
                if seen.clients:
                    self._tell(shared_words(seen.address))
            self._awaited_why, self._clients = "", seen.clients
            return "" if self._carry(port, timed, seen.address) is _End.LEFT else _GONE

    def _timed(self, seen: SeenPort) -> "TimedBytes | None":
        if not self.view.has_time:
            return None
        from hil.cli.monitor.timed_bytes import TimedBytes

        return TimedBytes(seen.socket, self.name)

    def _carry(self, port: int, timed: "TimedBytes | None", address: str) -> _End:
        waiting = b""
        os.set_blocking(port, False)  # the board may hold up what is typed until its answers have been read
        while True:
            is_read = self._has_input and (self.is_typed or not waiting)
            if not (self._has_input or waiting or self.waits):
                self._ended_s = min(self._ended_s, time.monotonic())
                if time.monotonic() >= self._ended_s + self.most_s:
                    what = f"the standard input is at its end, and {self.name} says more"
                    self._tell(f"{what}; --wait listens on, until Ctrl-C")
                    return _End.LEFT
            inputs = [port, *([self.keyboard] if is_read else []), *([timed.fd] if timed else [])]
            inputs += [self.watch.fd] if self.watch else []
            ready, writable, _ = select.select(
                inputs, [port] if waiting else [], [], self._patience_s(bool(waiting))
            )
            if not ready and not writable:
                if not self.view.is_holding():
                    return _End.LEFT
                self._show(self.view.pause())
                continue
            data = b""
            try:
                with suppress(BlockingIOError):  # another client was quicker
                    if port in ready and not (data := os.read(port, _READ_BYTES)):
                        return _End.PORT_GONE
                with suppress(BlockingIOError):
                    if writable:
                        waiting = waiting[os.write(port, waiting) :]
            except OSError:  # EIO of a terminal, or a reset: its bench has gone
                return _End.PORT_GONE
            if timed is None:
                self._came(data)
            elif timed.fd in ready and not self._came_at(timed):
                return _End.PORT_GONE
            if self.watch and self.watch.fd in ready:
                self._heed(self.watch.take_news(), address)
            if self.keyboard in ready:
                if (typed := self._typed()) is None:
                    return _End.LEFT
                if self.echoes:
                    self._show(self.view.echo(typed))
                waiting += typed

    def _patience_s(self, is_waiting: bool) -> float | None:
        """Time after which silence means something; None: never."""
        if self.view.is_holding():
            return _PAUSE_S
        return None if self._has_input or is_waiting or self.waits else min(self.quiet_s, self.most_s)

    def _came(self, data: bytes, at_ns: int = 0) -> None:
        if not data:
            return
        self._show(self.view.came(data, at_ns))
        if self.log and (why := self.log.write(data)):
            self._tell(f"{why}; the log ends here, the monitor goes on")

    def _came_at(self, timed: "TimedBytes") -> bool:
        """Show what came, with its times; false if the bench has ended."""
        if (pieces := timed.read()) is None:
            return False
        for at_ns, data in pieces:
            self._came(data, at_ns)
        if timed.lost:
            self._tell(f"the bench could not hand over all: {timed.lost} pieces are missing here")
            timed.lost = 0
        return True

    def _heed(self, seen: SeenPort | None, address: str) -> None:
        """Say it when other programs come to the port, or have left it."""
        if seen is None or seen.address != address:
            return
        before, self._clients = self._clients, max(seen.clients - 1, 0)
        if self._clients > before:
            self._tell(shared_words(address))
        elif before and not self._clients:
            self._tell("the port is yours alone again")


def shared_words(address: str) -> str:
    """Say that another program has the port, too, and what comes of it."""
    who = "another program has this port open, too"
    return f"{who}: {BOTH if address.startswith(SHARED) else ONE_OF}"


@contextmanager
def _raw_terminal(keyboard: int, hints: Sequence[str]) -> Iterator[None]:
    before = termios.tcgetattr(keyboard)
    try:
        tty.setraw(keyboard, termios.TCSADRAIN)  # what was typed already is for the board, too
        # Standard output has the board's bytes alone.
        say("\r\n".join(map(printable, hints)) + "\r", own(sys.stderr))
        yield
    finally:
        termios.tcsetattr(keyboard, termios.TCSADRAIN, before)
        say("", sys.stderr)
