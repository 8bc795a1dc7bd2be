"""Runs a firmware's main program: gives it what it waits for, at the simulated time it is due.

Pure: time comes in as an argument, what the board sends goes out through its UART, and a request to
store is handed to the caller.
"""

from collections.abc import Callable, Sequence
from typing import Any

from hil.vocab.firmware import Board, ByteAvailable, Commit, CoreEvent, Delay, EventAvailable, Main, Request
from hil.vocab.framing import Item
from hil.vocab.time import FOREVER, SimTimeNs


class RxBuffer:
    """Received bytes that the sketch has not read: at most ``capacity``, and the one held by ``peek``.

    ``peek`` takes its byte out of the buffer, as the SAMD core's USB serial does up to 1.6.21: the
    byte is neither counted by ``available`` nor does it take room.
    """

    def __init__(self, capacity: int) -> None:
        self._capacity = capacity
        self.unread = bytearray()
        """Bytes in the buffer, the held one not among them; to be looked at only."""
        self._held = -1

    def feed(self, data: bytes, *, at_once: bool = False) -> int:
        """Take bytes from the line; answers how many found room. ``at_once``: all do, read as they come."""
        taken = data if at_once else data[: self._capacity - len(self.unread)]
        self.unread.extend(taken)
        return len(taken)

    def room(self) -> int:
        """Number of bytes that ``feed`` would take now."""
        return self._capacity - len(self.unread)

    def available(self) -> int:
        """Unread bytes in the buffer, the held one not counted."""
        return len(self.unread)

    def read_all(self) -> bytes:
        data = bytes(self.unread)
        self.unread.clear()
        return data

    def read(self) -> int:
        """Take the next byte, the held one first; -1 if there is none."""
        if self._held < 0:
            return self.unread.pop(0) if self.unread else -1
        byte, self._held = self._held, -1
        return byte

    def peek(self) -> int:
        """Answer the next byte and hold it until ``read``; -1 if there is none."""
        if self._held < 0 and self.unread:
            self._held = self.unread[0]
            del self.unread[:1]
        return self._held


class Idle:
    """Program that does nothing: it drops what comes. ``hil.vocab.firmware.Firmware``."""

    def __init__(self, board: Board) -> None:
        self._uarts = board.uarts

    def main(self) -> Main:
        while True:
            yield ByteAvailable()
            for uart in self._uarts.values():
                uart.read_all()

    def interrupt(self, event: CoreEvent) -> None:
        return


STEPS_WITHOUT_TIME = 1_000_000
"""Number of resumes at one instant from which on a main program is in an endless loop: a board's would have
used up time. Far above what a full receive buffer can cause."""


class FirmwareStuck(Exception):
    """Error of a main program that loops without letting simulated time pass, or returned."""


def _at(main: Main) -> str:
    """File and line of the ``yield`` at which a main program stands, as " (firmware.py:31)"."""
    inner: Any = main
    while hasattr(within := inner.gi_yieldfrom, "gi_yieldfrom"):
        inner = within
    frame = inner.gi_frame
    return f" ({frame.f_code.co_filename.rpartition('/')[2]}:{frame.f_lineno})" if frame else ""


class Runtime:
    """One power-up of a board's main program.

    ``has_input()`` tells whether a byte has come that it would be woken for. ``due_ns`` is the next time at
    which ``resume`` has to be called; it may be called earlier, when a byte has arrived.
    ``print_returns(now_ns)`` says when what has been printed so far lets the program go on: at once, unless
    a slow line's transmit buffer is full.
    """

    def __init__(
        self,
        main: Main,
        has_input: Callable[[], bool],
        commit: Callable[[Commit], None],
        print_returns: Callable[[SimTimeNs], SimTimeNs],
    ) -> None:
        self._main = main
        self._has_input = has_input
        self._commit = commit
        self._print_returns = print_returns
        self._waiting: Request | None = None
        self._answer: object = None
        self._committing = self._is_interrupted = False
        self._ready_ns = SimTimeNs(0)
        self._deadline_ns = SimTimeNs(0)
        self.polls_from_ns = FOREVER
        """Time from which the program reads bytes as they come."""
        self.due_ns = SimTimeNs(0)
        self.takes: Callable[[Sequence[Item]], bool] | None = None
        """Taker of packets for what the program waits for: ``ByteAvailable.takes``."""

    def resume(self, now_ns: SimTimeNs) -> None:
        """Let the program run as far as it gets at ``now_ns``.

        Raises:
            FirmwareStuck: it loops forever at one instant.
            Exception: whatever the program raised.
        """
        for _ in range(STEPS_WITHOUT_TIME):
            if not self._met(now_ns):
                self.due_ns = self._ready_ns if now_ns < self._ready_ns else self._deadline_ns
                return
            try:
                self._waiting = self._main.send(self._answer)
            except StopIteration:
                raise FirmwareStuck("the main program returned") from None
            self._begin(self._print_returns(now_ns))
        raise FirmwareStuck(
            f"resumed {STEPS_WITHOUT_TIME} times without waiting for anything{_at(self._main)}"
        )

    def go_on_waiting(self, now_ns: SimTimeNs, start_ns: SimTimeNs) -> None:
        """Note that ``takes`` has spared the program the turn in which it would have begun to wait again:
        from ``start_ns`` on, when what was printed lets it."""
        self._ready_ns = self.polls_from_ns = start_ns
        self.due_ns = start_ns if now_ns < start_ns else FOREVER

    def commit_done(self, durable: bool) -> None:
        """Take the store's answer to a commit; call ``resume`` next."""
        self._committing = False
        self._answer = durable

    def interrupted(self, at_ns: SimTimeNs) -> None:
        """Note that an interrupt has come; a program that waits for one is due then."""
        if isinstance(self._waiting, EventAvailable):
            self._is_interrupted = True
            self.due_ns = max(at_ns, self._ready_ns)

    def close(self) -> None:
        """Cut the power."""
        self._main.close()
        self.due_ns = FOREVER

    def _begin(self, start_ns: SimTimeNs) -> None:
        request = self._waiting
        self._answer = None
        self._ready_ns = start_ns
        self._deadline_ns = FOREVER
        self.polls_from_ns = FOREVER
        self.takes = None
        if isinstance(request, Delay):
            self._deadline_ns = SimTimeNs(start_ns + request.duration_ns)
        elif isinstance(request, ByteAvailable):
            self.polls_from_ns = start_ns
            if request.timeout_ns is not None:
                self._deadline_ns = SimTimeNs(start_ns + request.timeout_ns)
            else:
                self.takes = request.takes
        elif isinstance(request, Commit):
            self._committing = True
            self._commit(request)
        elif isinstance(request, EventAvailable):
            self._is_interrupted = False
        else:
            raise FirmwareStuck(f"the main program yielded {request!r}, which is no request{_at(self._main)}")

    def _met(self, now_ns: SimTimeNs) -> bool:
        if now_ns < self._ready_ns:
            return False
        if isinstance(self._waiting, ByteAvailable):
            # The time-out comes first: a byte that arrives at its very end is too late.
            if now_ns >= self._deadline_ns:
                self._answer = False
                return True
            self._answer = self._has_input()
            return self._answer is True
        if isinstance(self._waiting, Commit):
            return not self._committing
        if isinstance(self._waiting, EventAvailable):
            return self._is_interrupted
        return self._waiting is None or now_ns >= self._deadline_ns
