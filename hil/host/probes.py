"""Trial runs of what a bench needs: the core's thread, ptys, inotify, folders. They leave nothing behind."""

import ctypes
import os
import tempfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from hil.host.cpu_claim import by_cpu, holders
from hil.host.real_time import wanted_cpu, wanted_priority
from hil.host.system import Files

PERIOD_NS = 1_000_000


@dataclass(frozen=True)
class Tried:
    """Results of the trial runs; an errno of 0 is success, an empty text no failure."""

    priority: int
    cpu: int
    """CPU to pin to; -1: none was asked for."""
    core_failure: str
    fifo_errno: int
    pin_errno: int
    lock_errno: int
    locked_kB: int
    pty_errno: int
    inotify_errno: int
    runtime_dir: Path
    runtime_failure: str
    state_dir: Path
    state_failure: str
    held: Mapping[int, Sequence[str]] = field(default_factory=dict)
    """Benches whose real-time threads hold a CPU, for each such CPU."""


def try_all(devices: int, runtime_dir: Path, state_dir: Path) -> Tried:
    """Try everything that a bench of so many devices needs."""
    held = holders()
    priority, cpu = wanted_priority(), wanted_cpu(held)
    failure, fifo_errno, pin_errno, lock_errno, locked_kB = _try_core(devices, priority, cpu)
    return Tried(
        priority=priority,
        cpu=cpu,
        core_failure=failure,
        fifo_errno=fifo_errno,
        pin_errno=pin_errno,
        lock_errno=lock_errno,
        locked_kB=locked_kB,
        pty_errno=_errno_of(_open_pty),
        inotify_errno=_errno_of(_open_inotify),
        runtime_dir=runtime_dir,
        runtime_failure=_try_folder(runtime_dir, own=True),
        state_dir=state_dir,
        state_failure=_try_folder(state_dir, own=False),
        held=by_cpu(held),
    )


def _try_core(devices: int, priority: int, cpu: int) -> tuple[str, int, int, int, int]:
    """Try the core's thread: the failure, what was refused (fifo, pin, lock), and the locked memory in kB."""
    from hil.core import Core

    try:
        native = Core(2 * devices).native
        native.rt_start(PERIOD_NS, 1.0, priority, cpu)
    except MemoryError:  # the core calls the lack of descriptors so, too
        return "no memory or no file descriptor for it", 0, 0, 0, 0
    except OSError as error:
        return os.strerror(error.errno or 0), 0, 0, 0, 0
    try:
        stats = native.rt_stats()
        status = Files(Path("/")).text("/proc/self/status") or ""
    finally:
        native.rt_stop()
    locked = [line.split()[1] for line in status.splitlines() if line.startswith("VmLck:")]
    locked_kB = int(locked[0]) if locked else 0
    return "", stats["fifo_errno"], stats["pin_errno"], stats["lock_errno"], locked_kB


def _open_pty() -> None:
    for fd in os.openpty():
        os.close(fd)


def _open_inotify() -> None:
    libc = ctypes.CDLL(None, use_errno=True)
    fd = libc.inotify_init1(os.O_CLOEXEC)
    if fd < 0:
        raise OSError(ctypes.get_errno(), "inotify_init1")
    os.close(fd)


def _errno_of(attempt: Callable[[], None]) -> int:
    try:
        attempt()
    except OSError as error:
        return error.errno or 0
    return 0


def _try_folder(folder: Path, own: bool) -> str:
    """Reason why the daemon cannot make the folder, or files in it; ``own``: it must be the user's."""
    there = next(each for each in (folder, *folder.parents) if os.path.lexists(each))
    try:
        if own and there == folder and there.stat().st_uid != os.getuid():
            return "it belongs to another user"
        with tempfile.TemporaryDirectory(prefix=".hil-doctor-", dir=there):
            return ""
    except OSError as error:
        return f"{there}: {error.strerror}"
