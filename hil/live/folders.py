"""Folders of a bench: its state, which no other daemon may have, and its runtime directory."""

import errno
import fcntl
import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from hil.host.paths import make_folder
from hil.host.trust import distrust
from hil.live.refusals import StartError
from hil.net.control_client import already_running, listener
from hil.vocab.address import CONTROL_SOCKET


@contextmanager
def folders(bench: str, state: Path, runtime: Path) -> Iterator[None]:
    """Make both folders, and keep other daemons away from the state. At the end the runtime directory is
    removed if it is empty, and the folder that it is in, unless somebody else has made that; and those above
    it that were not there.

    Raises:
        StartError: one cannot be had.
    """
    lock, keeps_parent = _lock(bench, state, runtime), False
    new_above = [folder for folder in runtime.parent.parents if not folder.exists()]
    try:
        try:
            # The folder was there and is empty: somebody made it.
            keeps_parent = runtime.parent.exists() and not any(runtime.parent.iterdir())
            _make_runtime(runtime)
        except OSError as error:
            raise StartError(
                f"runtime directory {runtime}: {error.strerror}; choose another with --runtime-dir"
            ) from error
        yield
    finally:
        with suppress(OSError):
            runtime.rmdir()
            if not keeps_parent:
                runtime.parent.rmdir()
                for folder in new_above:
                    folder.rmdir()
        os.close(lock)


def _lock(bench: str, state: Path, runtime: Path) -> int:
    """Lock the state directory: it is ours for as long as the file descriptor is open."""
    try:
        make_folder(state)
        lock = os.open(state, os.O_RDONLY | os.O_DIRECTORY | os.O_CLOEXEC)
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        return lock
    except BlockingIOError as error:
        with suppress(OSError):
            if pid := listener(runtime / CONTROL_SOCKET):
                raise StartError(already_running(bench, pid)) from error
        raise StartError(
            f"state directory {state}: another daemon has it; choose another with --state-dir"
        ) from error
    except OSError as error:
        raise StartError(
            f"state directory {state}: {error.strerror}; choose another with --state-dir"
        ) from error


def _make_runtime(runtime: Path) -> None:
    parent = runtime.parent
    if not parent.exists() or parent.stat().st_uid != 0:  # root's is the service manager's
        make_folder(parent)
    make_folder(runtime, 0o755)  # ports and socket have modes of their own
    if why := distrust(runtime):
        raise PermissionError(errno.EACCES, why)
