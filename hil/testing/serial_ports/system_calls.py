"""Calls of the system that pyserial makes, answered for terminals of a bench."""

import errno
import fcntl
import itertools
import math
import os
import select
import termios
from collections.abc import Mapping, Sequence
from typing import Any

from hil.testing.serial_ports.passing import Passing
from hil.testing.serial_ports.port_requests import UINT, answer_request
from hil.testing.serial_ports.port_terminal import XOFF, XON, PortTerminal
from hil.vocab.near_words import meant
from hil.vocab.time import FOREVER, NS_PER_S, SimTimeNs

_FIRST_FD = 1 << 20
"""First number of descriptors here, above all of Linux (fs.nr_open)."""
BREAK_NS = 250_000_000
"""Time that a break lasts which is sent by ``tcsendbreak`` (tty_io.c)."""
USB_FRAME_NS = 1_000_000
"""Interval at which a host gets what a serial adapter has read (USB 2.0, 8.4.3)."""
CLOCK_START_S = 1000.0
"""Reading of the monotonic clock at the start of a bench: some programs take 0 for "not yet"."""


class Abort:
    """Pipe by which pyserial ends a wait from another thread: only whether something is in it counts."""

    def __init__(self) -> None:
        self.held = b""

    def readable(self, now_ns: SimTimeNs) -> bool:
        """True if something is in it."""
        return bool(self.held)


class OpenTerminal:
    """Terminal as one ``open`` has it."""

    def __init__(self, terminal: PortTerminal) -> None:
        self.terminal = terminal

    def readable(self, now_ns: SimTimeNs) -> bool:
        """True if something has come."""
        return self.terminal.waiting(now_ns) > 0


def _error(number: int, words: str = "", path: str | None = None) -> OSError:
    return OSError(number, words or os.strerror(number), path)


class SystemCalls:
    """Calls for the terminals of one bench, by the paths at which programs open them.

    Long because each call that pyserial makes stands here, one short method each.
    """

    def __init__(
        self, passing: Passing, terminals: Mapping[str, PortTerminal], has_map: bool = False
    ) -> None:
        self.passing, self.terminals, self._has_map = passing, terminals, has_map
        self._files: dict[int, OpenTerminal | Abort] = {}
        self._numbers = itertools.count(_FIRST_FD)
        self._waited: tuple[Sequence[int], SimTimeNs] | None = None
        """Descriptors of the last ``select``, if it waited, and the end of its time-out."""

    def terminal(self, fd: Any) -> PortTerminal:
        """Terminal that is open under a number. Raises OSError EBADF, and TypeError as Python does."""
        if isinstance(file := self._files.get(fd), OpenTerminal):
            return file.terminal
        if fd is None:  # pyserial's of a port that is closed
            raise TypeError("argument must be an int, or have a fileno() method.")
        raise _error(errno.EBADF)

    # ---- os ----

    def open(self, path: str, flags: int) -> int:
        """Open a terminal. Raises OSError: there is none of this name."""
        if path not in self.terminals:
            also = f"; or give --map {path}={next(iter(self.terminals), 'PORT')}" if self._has_map else ""
            why = f"no such port in this bench; {meant(path, self.terminals)}{also}"
            raise _error(errno.ENOENT, why, path)
        terminal = self.terminals[path]
        with self.passing.inside():
            terminal.open(self.passing.now_ns)
        return self._add(OpenTerminal(terminal))

    def _add(self, file: OpenTerminal | Abort) -> int:
        self._files[number := next(self._numbers)] = file
        return number

    def pipe(self) -> tuple[int, int]:
        """Make a pipe, both ends of which are one here."""
        abort = Abort()
        return self._add(abort), self._add(abort)

    def close(self, fd: int) -> None:
        """Close a terminal or an end of a pipe."""
        file = self._files.pop(fd, None)
        if file is None:
            raise _error(errno.EBADF)
        if isinstance(file, OpenTerminal):
            self._unlock(file)
            with self.passing.inside():
                file.terminal.close(self.passing.now_ns)

    def read(self, fd: int, count: int) -> bytes:
        """Read what is there. Raises OSError EAGAIN: nothing is."""
        file = self._files.get(fd)
        if isinstance(file, Abort):
            data, file.held = file.held[:count], file.held[count:]
            return data
        terminal = self.terminal(fd)
        if self._waited and fd in self._waited[0]:
            self._let_come(terminal, fd, count, *self._waited)
        if data := terminal.read(count, self.passing.now_ns):
            self.passing.acted()
            return data
        raise _error(errno.EAGAIN)

    def _let_come(
        self, terminal: PortTerminal, fd: int, count: int, fds: Sequence[int], until_ns: SimTimeNs
    ) -> None:
        """Let bytes come that are on the line already, as long as the last ``select`` would have waited:
        pyserial would wait for each of them by itself."""
        now_ns = self.passing.now_ns
        if (missing := count - terminal.waiting(now_ns)) > 0:
            last_ns = terminal.end.time_of(missing)  # FOREVER: none is on the line
            until_ns = min(last_ns, until_ns)
            if now_ns < until_ns and last_ns < FOREVER:
                others = [each for each in fds if each != fd]
                self.passing.wait(lambda: bool(self._found(others)), until_ns, "bytes", None)

    def write(self, fd: int, data: bytes) -> int:
        """Send bytes: all are taken, and wait if the board does not take them. Raises OSError EAGAIN: the
        board, or the program, has stopped it."""
        file = self._files.get(fd)
        if isinstance(file, Abort):
            file.held += bytes(data)
        else:
            terminal = self.terminal(fd)
            terminal.waiting(self.passing.now_ns)
            if terminal.is_stopped:
                self.passing.look()  # pyserial tries again until its time-out
                raise _error(errno.EAGAIN)
            self.passing.acted()
            with self.passing.inside():
                terminal.write(bytes(data), self.passing.now_ns)
        return len(data)

    # ---- select ----

    def select(
        self,
        reads: Sequence[int],
        writes: Sequence[int],
        errors: Sequence[int],
        timeout_s: float | None = None,
    ) -> tuple[list[int], list[int], list[int]]:
        """Wait until something can be read; writing is possible always."""
        self._waited = None
        if (found := self._found(reads)) or writes:
            return found, [*writes], []
        until_ns = self.end_of(timeout_s)
        at = next((fd for fd in reads if isinstance(self._files[fd], OpenTerminal)), None)
        if until_ns > self.passing.now_ns:
            end = None if at is None else self.terminal(at).end
            what = "select" if at is None else f"read at {self.terminal(at).name}"

            def ready() -> bool:
                found[:] = self._found(reads)
                return bool(found)

            self.passing.wait(ready, until_ns, what, end)
            self._waited = reads, until_ns
        elif at is not None:
            self._poll(self.terminal(at))
        return found or self._found(reads), [], []

    def _found(self, fds: Sequence[int]) -> list[int]:
        """Descriptors of these of which something can be read at once."""
        now_ns, files = self.passing.now_ns, self._files
        try:
            return [fd for fd in fds if files[fd].readable(now_ns)]
        except KeyError:
            raise _error(errno.EBADF) from None

    def _poll(self, terminal: PortTerminal) -> int:
        """Number of bytes that a program sees which does not wait for them: it looks, and sees what follows
        each other at once, as a host has it from USB."""
        passing = self.passing
        if not terminal.waiting(passing.now_ns):
            passing.look()
        if terminal.waiting(passing.now_ns):
            frame_ns = passing.now_ns + USB_FRAME_NS
            if terminal.end.next_ns <= frame_ns:
                passing.wait(lambda: terminal.end.next_ns > frame_ns, frame_ns, "a frame", None)
        return terminal.waiting(passing.now_ns)

    def end_of(self, timeout_s: float | None) -> SimTimeNs:
        """Time at which a time-out is over, never before it."""
        if timeout_s is None:
            return FOREVER
        return SimTimeNs(min(self.passing.now_ns + math.ceil(timeout_s * NS_PER_S), FOREVER))

    # ---- fcntl and termios ----

    def flock(self, fd: int, operation: int) -> None:
        """Lock a terminal against others that lock it, or unlock it. Raises OSError EAGAIN."""
        terminal, file = self.terminal(fd), self._files[fd]
        if operation & fcntl.LOCK_UN:
            self._unlock(file)
        elif terminal.lock not in (None, file) or not terminal.lock_outside(True):
            raise _error(errno.EAGAIN)
        else:
            terminal.lock = file

    def _unlock(self, file: Any) -> None:
        if file.terminal.lock is file:
            file.terminal.lock = None
            file.terminal.lock_outside(False)

    def ioctl(self, fd: int, request: int, argument: Any = 0, mutate: bool = True) -> Any:
        """Answer the requests that pyserial makes. Raises OSError ENOTTY: as a terminal without them."""
        terminal = self.terminal(fd)
        if request == termios.FIONREAD:
            return UINT.pack(self._poll(terminal))
        with self.passing.inside():
            return answer_request(terminal, request, argument, self.passing.now_ns)

    def tcgetattr(self, fd: int) -> list[Any]:
        """Settings of a terminal."""
        settings = self.terminal(fd).settings
        return [*settings[:6], [*settings[6]]]

    def tcsetattr(self, fd: int, when: int, settings: list[Any]) -> None:
        """Set a terminal."""
        self.terminal(fd).set(settings, self.passing.now_ns)

    def tcflush(self, fd: int, queue: int) -> None:
        """Throw away what waits to be read, or to be sent."""
        terminal = self.terminal(fd)
        if queue in (termios.TCIFLUSH, termios.TCIOFLUSH):
            terminal.flush_input(self.passing.now_ns)
        if queue in (termios.TCOFLUSH, termios.TCIOFLUSH):
            terminal.flush_output()

    def tcdrain(self, fd: int) -> None:
        """Wait until all is sent."""
        terminal = self.terminal(fd)
        if terminal.unsent:
            self.passing.wait(lambda: not terminal.unsent, FOREVER, f"flush at {terminal.name}", terminal.end)

    def tcsendbreak(self, fd: int, duration: int) -> None:
        """Send a break, which takes its time where there is one. Raises OSError EBADF."""
        terminal = self.terminal(fd)
        if terminal.lines:
            terminal.lines.send_break(self.passing.now_ns)
            self.passing.wait(lambda: False, self.passing.now_ns + BREAK_NS, "a break", None)

    def tcflow(self, fd: int, action: int) -> None:
        """Stop what is sent, or let it go on; or tell the board to. Raises OSError EBADF."""
        terminal = self.terminal(fd)
        if action in (termios.TCOOFF, termios.TCOON):
            terminal.is_stopped = action == termios.TCOOFF
        else:
            with self.passing.inside():
                terminal.write(XOFF if action == termios.TCIOFF else XON, self.passing.now_ns)


class Replaced:
    """Module of which some names are ours."""

    def __init__(self, module: Any, **ours: Any) -> None:
        self._module = module
        self.__dict__.update(ours)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._module, name)


def modules_for(calls: SystemCalls) -> dict[str, Any]:
    """Modules by name, in place of those that pyserial imports."""
    return {
        "os": Replaced(
            os, open=calls.open, pipe=calls.pipe, close=calls.close, read=calls.read, write=calls.write
        ),
        "select": Replaced(select, select=calls.select),
        "fcntl": Replaced(
            fcntl, flock=calls.flock, ioctl=calls.ioctl, fcntl=lambda fd, request, argument=0: 0
        ),
        "termios": Replaced(
            termios,
            tcgetattr=calls.tcgetattr,
            tcsetattr=calls.tcsetattr,
            tcflush=calls.tcflush,
            tcdrain=calls.tcdrain,
            tcsendbreak=calls.tcsendbreak,
            tcflow=calls.tcflow,
        ),
    }
