"""Files that an operator names: read only if they are files, so that nobody waits for a pipe's other end."""

import errno
import os
import stat
from pathlib import Path
from typing import BinaryIO

_KINDS = (
    (stat.S_ISCHR, "a character device"),
    (stat.S_ISBLK, "a block device"),
    (stat.S_ISFIFO, "a FIFO"),
    (stat.S_ISSOCK, "a socket"),
)


class NotRegularError(OSError):
    """What has the name is no regular file; ``strerror`` says what it is."""


def open_regular(path: Path) -> BinaryIO:
    """A regular file, or one that a symlink leads to, open for reading. Never waits for another program.

    Raises:
        NotRegularError: it is something else that is no directory.
        OSError: it cannot be read.
    """
    mode = path.stat().st_mode  # an open would already do something to a device
    _refuse(mode)
    file = open(os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_NOCTTY | os.O_CLOEXEC), "rb")  # noqa: SIM115
    try:
        _refuse(os.fstat(file.fileno()).st_mode)  # exchanged in between
    except OSError:
        file.close()
        raise
    return file


def read_regular(path: Path) -> bytes:
    """The bytes of a regular file; as ``open_regular``."""
    with open_regular(path) as file:
        return file.read()


def read_text(path: Path) -> str:
    """As ``read_regular``, as text with Unix's ends of lines.

    Raises:
        UnicodeDecodeError: it is not UTF-8.
    """
    return read_regular(path).decode().replace("\r\n", "\n").replace("\r", "\n")


def _refuse(mode: int) -> None:
    if stat.S_ISDIR(mode):
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR))
    if not stat.S_ISREG(mode):
        kind = next((text for test, text in _KINDS if test(mode)), "something else")
        raise NotRegularError(errno.EINVAL, f"it is {kind}, not a regular file")
