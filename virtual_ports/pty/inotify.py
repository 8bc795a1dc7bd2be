"""Opens and closes of a pts: one inotify instance for each event loop, shared by its pty ports.

Shared, because the kernel gives a user only 128 instances (fs.inotify.max_user_instances) and a
bench may have hundreds of ports.

The kernel merges an event with the one queued before it if both are equal, so that two opens in a row
would be seen as one. Therefore the directory is watched as well: its event comes before each event
of a pts and keeps two of them apart. Two processors in the same microsecond can still merge theirs:
a caller that must be sure has to check (``PtyPort`` does).
"""

import ctypes
import os
import select
import struct
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING
from weakref import WeakKeyDictionary

Listener = Callable[[list[int], bool], None]
"""Called with +1 for each open, -1 for each close, in order, and whether any were lost. Must not drain."""

if TYPE_CHECKING:
    import asyncio

_IN_CLOSE = 0x08 | 0x10  # IN_CLOSE_WRITE | IN_CLOSE_NOWRITE, linux/inotify.h
_IN_OPEN = 0x20
_IN_Q_OVERFLOW = 0x4000
_EVENT = struct.Struct("iIII")  # wd, mask, cookie, length of the name that follows
_READ_BYTES = 16384
_LONGEST_EVENT_BYTES = _EVENT.size + 256

_libc = ctypes.CDLL(None, use_errno=True)


def _checked(result: int, what: str) -> int:
    if result < 0:
        number = ctypes.get_errno()
        raise OSError(number, f"{what}: {os.strerror(number)}")
    return result


class _Inotify:
    def __init__(self, loop: "asyncio.AbstractEventLoop", directory: Path) -> None:
        self._loop = loop
        self._listeners: dict[int, Listener] = {}
        self._untold: dict[int, list[int]] = {}
        self._events_lost = False
        self._fd = _checked(_libc.inotify_init1(os.O_NONBLOCK | os.O_CLOEXEC), "inotify_init1")
        try:
            self._watch(directory)
        except OSError:
            os.close(self._fd)
            raise
        self._poll = select.poll()
        self._poll.register(self._fd, select.POLLIN)
        loop.add_reader(self._fd, self.drain)

    def _watch(self, path: Path) -> int:
        added = _libc.inotify_add_watch(self._fd, os.fsencode(path), _IN_OPEN | _IN_CLOSE)
        return _checked(added, f"inotify_add_watch {path}")

    def add(self, path: Path, listener: Listener) -> int:
        wd = self._watch(path)
        self._listeners[wd] = listener
        return wd

    def remove(self, wd: int) -> None:
        del self._listeners[wd]
        self._untold.pop(wd, None)
        _libc.inotify_rm_watch(self._fd, wd)

    def close_if_unused(self) -> bool:
        if self._listeners:
            return False
        self._loop.remove_reader(self._fd)
        os.close(self._fd)
        return True

    def pending(self, wd: int) -> bool:
        """True if something has happened to this pts that ``drain`` has not told."""
        self._read()
        if self._untold or self._events_lost:
            self._loop.call_soon(self.drain)  # the loop sees no more what was read here
        return self._events_lost or wd in self._untold

    def drain(self) -> None:
        if not self._listeners:
            return  # closed meanwhile
        if self._poll.poll(0):  # asked here too: mostly nothing has come, and it is a call less
            self._read()
        if not self._untold and not self._events_lost:
            return
        steps, self._untold = self._untold, {}
        lost, self._events_lost = self._events_lost, False
        for wd in list(self._listeners) if lost else steps:
            if wd in self._listeners:
                self._listeners[wd](steps.get(wd, []), lost)

    def _read(self) -> None:
        more = True
        while more and self._poll.poll(0):  # cheaper than to read and to fail, which is the rule
            chunk = os.read(self._fd, _READ_BYTES)
            more = len(chunk) > _READ_BYTES - _LONGEST_EVENT_BYTES
            at = 0
            while at < len(chunk):
                wd, mask, _, name_bytes = _EVENT.unpack_from(chunk, at)
                at += _EVENT.size + name_bytes
                self._events_lost |= bool(mask & _IN_Q_OVERFLOW)
                if wd in self._listeners and mask & (_IN_OPEN | _IN_CLOSE):
                    self._untold.setdefault(wd, []).append(1 if mask & _IN_OPEN else -1)


_of_loop: "WeakKeyDictionary[asyncio.AbstractEventLoop, _Inotify]" = WeakKeyDictionary()


class ClientWatch:
    """Watch on the opens and closes of one pts, from now on, told to ``listener`` on the running loop.

    Raises:
        OSError: no inotify instance or watch is left for this user.
    """

    def __init__(self, pts: Path, listener: Listener) -> None:
        import asyncio

        self._loop = asyncio.get_running_loop()
        shared = _of_loop.get(self._loop)
        if shared is None:
            shared = _of_loop[self._loop] = _Inotify(self._loop, pts.parent)
        self._shared = shared
        self.drain = shared.drain
        """Tells all that has happened so far, now: to this watch's listener and to the others'."""
        try:
            self._wd = shared.add(pts, listener)
        except OSError:
            self._leave()
            raise

    def pending(self) -> bool:
        """True if something has happened to this pts that ``drain`` has not told."""
        return self._shared.pending(self._wd)

    def close(self) -> None:
        """End the watch. Call it once."""
        self._shared.remove(self._wd)
        self._leave()

    def _leave(self) -> None:
        if self._shared.close_if_unused():
            del _of_loop[self._loop]
