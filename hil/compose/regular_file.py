"""Files that an operator names: read only if they are files, so that nobody waits for a pipe's other end."""

import errno
import os
import stat
from pathlib import Path

_KINDS = (
    (stat.S_ISCHR, "a character device"),
    (stat.S_ISBLK, "a block device"),
    (stat.S_ISFIFO, "a FIFO"),
    (stat.S_ISSOCK, "a socket"),
)


class NotRegularError(OSError):
    """What has the name is no regular file; ``strerror`` says what it is."""


def read_regular(path: Path) -> bytes:
    """The bytes of a regular file, or of one that a symlink leads to. Never waits for another program.

    Raises:
        NotRegularError: it is something else that is no directory.
        OSError: it cannot be read.
    """
    mode = path.stat().st_mode  # an open would already do something to a device
    _refuse(mode)
    with open(os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_NOCTTY | os.O_CLOEXEC), "rb") as file:
        _refuse(os.fstat(file.fileno()).st_mode)  # exchanged in between
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
