"""Store of boards' non-volatile memories: one file for each device, written by a thread.

A commit writes a new file, syncs it, renames it over the old one and syncs the directory; only then is it
acknowledged. The file is whole and not older than the last acknowledgement, whatever dies in between. A
failed sync is never retried: the kernel may have dropped the data, and a second try would succeed without it.
"""

import contextlib
import logging
import os
import threading
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from queue import SimpleQueue

from hil.firmware.nvm import FORMAT_VERSION, Content, NvmError, NvmNewer, decode, encode
from hil.host.regular_file import read_regular

Done = Callable[[bool, str], None]

_log = logging.getLogger(__name__)


@dataclass(frozen=True)
class Loaded:
    """Memory of a device, and what the operator should know about it, in one line."""

    content: Content
    note: str | None
    unfit: str | None = None
    """Reason why the file cannot be this device's, and has to be kept aside before its first commit."""


@dataclass(frozen=True)
class Kept:
    """File that got another name, and what the operator should know about it, in one line."""

    path: Path
    aside: Path
    note: str


class StoreError(Exception):
    """Error of a store that cannot be used: ``str(error)`` says what to look at, in one line."""


class StoreCalls:
    """Calls to the operating system that the store makes. Each raises OSError."""

    def read(self, path: Path) -> bytes:
        return read_regular(path)

    def create(self, path: Path) -> int:
        with contextlib.suppress(FileNotFoundError):  # of a process that was killed
            os.unlink(path)
        return os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_NOFOLLOW | os.O_CLOEXEC, 0o600)

    def open_directory(self, path: Path) -> int:
        return os.open(path, os.O_RDONLY | os.O_DIRECTORY | os.O_CLOEXEC)

    write = staticmethod(os.write)
    fsync = staticmethod(os.fsync)
    close = staticmethod(os.close)
    link = staticmethod(os.link)
    rename = staticmethod(os.rename)
    unlink = staticmethod(os.unlink)


class NvmStore:
    """Directory of ``<device>.nvm`` files. One process at a time may use a directory."""

    def __init__(self, directory: Path, files: StoreCalls | None = None) -> None:
        """Open the store in ``directory``, which exists and is on a file system that has hard links.

        Raises:
            StoreError: it does not exist.
        """
        if not directory.is_dir():
            raise StoreError(f"{directory} is not a directory: create it, writable for the daemon")
        self._directory = directory
        self._files = files or StoreCalls()
        self._queue: SimpleQueue[tuple[str, bytes, Done] | None] = SimpleQueue()
        self._closed = False
        self._worker = threading.Thread(target=self._work, name="nvm-store", daemon=True)
        self._worker.start()

    def look(self, device: str, profile: str) -> Loaded:
        """Look up the device's memory as it was last stored; empty if there is none, or ``unfit`` says why
        the file cannot be used.

        Raises:
            StoreError: the file is newer, and for the newer program, or cannot be read.
        """
        path = self._path(device)
        empty = Content(profile=profile, counter=0, sections={})
        try:
            decoded = decode(self._files.read(path))
        except FileNotFoundError:
            return Loaded(empty, None)
        except NvmNewer as error:
            raise StoreError(
                f"{path}: {error}; start the newer program, or move the file away for an empty memory"
            ) from error
        except NvmError as error:
            return Loaded(empty, None, str(error))
        except OSError as error:
            raise StoreError(f"{path} cannot be read: {_why(error)}") from error
        if decoded.migrated_from is not None:
            note = f"{path.name}: format version {decoded.migrated_from} was migrated to {FORMAT_VERSION}"
            return Loaded(replace(decoded.content, profile=profile), note)
        if decoded.content.profile != profile:
            return Loaded(empty, None, belongs_to(decoded.content.profile, profile))
        return Loaded(decoded.content, None)

    def keep_aside(self, device: str, reason: str) -> Kept | None:
        """Give the device's file another name; None if there is no file.

        No commit of this device may be under way.

        Raises:
            StoreError: it cannot be done. The file is where it was.
        """
        path = self._path(device)
        number = 1
        while (aside := path.with_name(f"{path.name}.damaged-{number}")).exists():
            number += 1
        try:
            self._files.rename(path, aside)
        except FileNotFoundError:
            return None
        except OSError as error:
            # Going on would let the next commit overwrite what may be the only copy.
            raise StoreError(f"{path}: {reason}; it cannot be kept as {aside.name}: {_why(error)}") from error
        note = f"{path.name}: {reason}; it was kept as {aside.name}, and the memory starts empty"
        return Kept(path, aside, note)

    def put_back(self, kept: Kept) -> None:
        """Undo ``keep_aside``."""
        try:
            self._files.rename(kept.aside, kept.path)
        except OSError as error:
            _log.error("%s, and cannot be put back: %s", kept.note, _why(error))

    def commit(self, device: str, content: Content, done: Done) -> None:
        """Store ``content`` as it is now; commits are carried out in the order of the calls.

        ``done(True, "")`` says that it is durable; ``done(False, reason)`` that it is not, and that the
        old content is still there. It is called in the worker thread and must not block.

        Raises:
            ValueError: the content is too large for the format, or the device's name is not a file name.
            RuntimeError: the store is closed.
        """
        if self._closed:
            raise RuntimeError("the store is closed")
        self._path(device)
        self._queue.put((device, encode(content), done))

    def close(self) -> None:
        """Wait until all commits have been answered. Safe to call twice."""
        if not self._closed:
            self._closed = True
            self._queue.put(None)
        self._worker.join()

    def _path(self, device: str) -> Path:
        if not device or Path(device).name != device:
            raise ValueError(f"{device!r} is not a file name")
        return self._directory / f"{device}.nvm"

    def _work(self) -> None:
        while (job := self._queue.get()) is not None:
            device, data, done = job
            failure = self._store(self._path(device), data)
            try:
                done(not failure, failure)
            except Exception:
                # Such as an event loop that is gone. The commits behind this one still count.
                _log.exception("%s: the end of a commit could not be reported", device)

    def _store(self, path: Path, data: bytes) -> str:
        """Store the data; answers why it failed, or "" if it is durable."""
        new = path.with_name(f"{path.name}.new")
        old = path.with_name(f"{path.name}.old")
        try:
            self._write(new, data)
            had_old = self._keep(path, old)
            self._files.rename(new, path)
        except OSError as error:
            self._remove(new)
            self._remove(old)
            return f"{path.name} was not written: {_why(error)}"
        try:
            self._sync_directory()
        except OSError as error:
            return f"{path.name} was not written: {_why(error)}" + self._take_back(path, old, had_old)
        self._remove(old)
        return ""

    def _write(self, path: Path, data: bytes) -> None:
        fd = self._files.create(path)
        try:
            rest = memoryview(data)
            while rest:
                rest = rest[self._files.write(fd, rest) :]
            self._files.fsync(fd)
        finally:
            self._files.close(fd)

    def _keep(self, path: Path, old: Path) -> bool:
        """Give the present file a second name, for ``_take_back``; False if there is none yet."""
        with contextlib.suppress(FileNotFoundError):
            self._files.unlink(old)  # of a process that was killed
        try:
            self._files.link(path, old)
        except FileNotFoundError:
            return False
        return True

    def _sync_directory(self) -> None:
        fd = self._files.open_directory(self._directory)
        try:
            self._files.fsync(fd)
        finally:
            self._files.close(fd)

    def _take_back(self, path: Path, old: Path, had_old: bool) -> str:
        try:
            if had_old:
                self._files.rename(old, path)
            else:
                self._files.unlink(path)
        except OSError as error:
            return f"; nor could the old content be put back: {_why(error)}"
        return ""

    def _remove(self, path: Path) -> None:
        with contextlib.suppress(OSError):  # it is in nobody's way: the next commit replaces it
            self._files.unlink(path)


def belongs_to(owner: str, profile: str) -> str:
    """Reason why a file of one profile is no memory of another's board."""
    return f"it belongs to a {owner!r}, not to a {profile!r}"


def _why(error: OSError) -> str:
    return error.strerror or str(error)
