"""One thread of another process that stands still, as one that hangs does."""

import ctypes
import os
import re
from collections import Counter
from contextlib import suppress
from pathlib import Path

PTRACE_SEIZE, PTRACE_INTERRUPT, PTRACE_DETACH = 0x4206, 0x4207, 17  # linux/ptrace.h
WALL = 0x40000000  # wait(2), __WALL: it is no child of ours
CLOCK_NANOSLEEP = "230"  # x86-64
LOOKS = 200


def core_thread(pid: int) -> int:
    """Number of the thread that is mostly found asleep until its next wake."""
    seen: Counter[int] = Counter()
    for _ in range(LOOKS):
        for task in Path(f"/proc/{pid}/task").iterdir():
            with suppress(OSError):
                seen[int(task.name)] += (task / "syscall").read_text().split()[0] == CLOCK_NANOSLEEP
    thread, times = seen.most_common(1)[0]
    assert times > LOOKS // 4, seen
    return thread


class Frozen:
    """Thread that does not run until the process dies or the block is left."""

    def __init__(self, thread: int) -> None:
        self._thread = thread
        self._ptrace = ctypes.CDLL(None, use_errno=True).ptrace
        self._ptrace.argtypes = (ctypes.c_long, ctypes.c_int, ctypes.c_void_p, ctypes.c_void_p)

    def __enter__(self) -> "Frozen":
        for request in (PTRACE_SEIZE, PTRACE_INTERRUPT):
            if self._ptrace(request, self._thread, None, None):
                raise OSError(ctypes.get_errno(), "ptrace")
        return self

    def reap(self) -> None:
        """Take notice of the thread's end, without waiting: its tracer must, or it stays as a zombie."""
        with suppress(ChildProcessError):
            os.waitpid(self._thread, os.WNOHANG | WALL)

    def __exit__(self, *_: object) -> None:
        self.reap()
        self._ptrace(PTRACE_DETACH, self._thread, None, None)


def host_pid(leader: int, inner: int) -> int:
    """Number of the process that is ``inner`` to the container of ``leader``."""
    namespace = os.readlink(f"/proc/{leader}/ns/pid")
    for status in Path("/proc").glob("[0-9]*/status"):
        with suppress(OSError):
            found = re.search(r"^NSpid:.*\t(\d+)$", status.read_text(), re.M)
            if found and int(found[1]) == inner and os.readlink(status.parent / "ns/pid") == namespace:
                return int(status.parent.name)
    raise ProcessLookupError(inner)
