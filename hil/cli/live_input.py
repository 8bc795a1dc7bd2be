"""Input that comes while somebody watches: bytes as they come, and a sign where none do."""

import os
import select

_GONE = select.POLLERR | select.POLLHUP | select.POLLNVAL


class LiveInput:
    """Receiver of bytes of a file descriptor. ``idle_s``: pause after which it says that nothing has come;
    None: never. ``out``: file descriptor of who takes what is made of it; it awaits nothing without him."""

    def __init__(self, fd: int, idle_s: float | None = None, out: int | None = None) -> None:
        self._fd = fd
        self._pause_ms = None if idle_s is None else round(1000 * idle_s)
        self._poll = select.poll()
        self._poll.register(fd, select.POLLIN)
        self.watch(out)

    def watch(self, out: int | None) -> None:
        """Watch whether somebody takes what is made of it, as ``out`` does."""
        self._out = out
        if out is not None:
            self._poll.register(out, 0)

    def __call__(self, size: int) -> bytes | None:
        """Receive at most so many bytes; none at the end, None after a pause.

        Raises:
            BrokenPipeError: nobody takes anything any more.
        """
        ready = dict(self._poll.poll(self._pause_ms))
        if self._out is not None and ready.get(self._out, 0) & _GONE:
            raise BrokenPipeError
        return os.read(self._fd, size) if ready else None
