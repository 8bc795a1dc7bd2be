"""Regular files that an operator names, and nothing else: nobody waits for a pipe's other end."""

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


MAX_BYTES = 16 << 20
"""Maximum length: a hundred times the longest configuration that anybody has shown."""


class NotRegularError(OSError):
    """Error of a name that is not a regular file's; ``strerror`` says what it is."""


def open_regular(path: Path, at_most_bytes: int | None = None) -> BinaryIO:
    """Open a regular file, or one that a symlink leads to, for reading. Never waits for another program.

    Raises:
        NotRegularError: it is something else that is no directory.
        OSError: it cannot be read, or is too large.
    """
    _refuse(path.stat(), at_most_bytes)  # an open would already do something to a device
    file = open(os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_NOCTTY | os.O_CLOEXEC), "rb")  # noqa: SIM115
    try:
        _refuse(os.fstat(file.fileno()), at_most_bytes)  # exchanged in between
    except OSError:
        file.close()
        raise
    return file


def read_regular(path: Path, at_most_bytes: int = MAX_BYTES) -> bytes:
    """Read the bytes of a regular file, as ``open_regular``: no more than its size says, and so nothing of
    those below /proc, which a read may change."""
    with open_regular(path, at_most_bytes) as file:
        return file.read(os.fstat(file.fileno()).st_size) or b""


def read_text(path: Path) -> str:
    """Read the text of a regular file, as ``read_regular``, with Unix's ends of lines.

    Raises:
        UnicodeDecodeError: it is not UTF-8.
    """
    return read_regular(path).decode("utf-8-sig").replace("\r\n", "\n").replace("\r", "\n")


def _refuse(state: os.stat_result, at_most_bytes: int | None) -> None:
    mode = state.st_mode
    if stat.S_ISDIR(mode):
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR))
    if stat.S_ISREG(mode) and at_most_bytes is not None and state.st_size > at_most_bytes:
        raise OSError(errno.EFBIG, f"it has {state.st_size:,} bytes, and {at_most_bytes:,} are the most")
    if not stat.S_ISREG(mode):
        kind = next((text for test, text in _KINDS if test(mode)), "something else")
        raise NotRegularError(errno.EINVAL, f"it is {kind}, not a regular file")
