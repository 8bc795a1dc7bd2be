"""The one way to write a file that somebody has named.

A path that exists and is no regular file (a device, a FIFO, ``/dev/stdout``) is written into. Otherwise a new
file with a name that nobody can guess is made beside it, and takes its place whole; a symlink stays, and what
it leads to is replaced. Permissions of what is replaced are kept.
"""

import errno
import os
import secrets
import stat
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import BinaryIO

_LINKS = 40
"""Maximum number of links in a row, as the kernel has it: more are a circle."""
_NEW = os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_NOFOLLOW | os.O_CLOEXEC


def write_file(path: Path, data: bytes) -> None:
    """Write all of a file, on the disk when this returns, or nothing of it.

    Raises:
        OSError: it cannot be written; a regular file is as it was.
    """
    with new_file(path) as file:
        file.write(data)


@contextmanager
def new_file(path: Path) -> Iterator[BinaryIO]:
    """Make a file whose content comes in pieces: whole in its place, and on the disk, when the block is over;
    nothing of it if the block fails.

    Raises:
        OSError: it cannot be written; a regular file is as it was.
    """
    target = _target(path)
    if isinstance(target, int):
        with open(target, "wb") as file:
            yield file
        return
    fd, new = _create(target)
    try:
        with open(fd, "wb") as file:
            yield file
            file.flush()
            os.fsync(fd)
        os.rename(new, target)
    except BaseException:
        new.unlink(missing_ok=True)
        raise


def begin_file(path: Path, head: bytes = b"") -> BinaryIO:
    """Begin a file to which more is written for as long as it is open. It is in its place, with ``head``,
    when this returns.

    Raises:
        OSError: it cannot be written.
    """
    target = _target(path)
    if isinstance(target, int):
        file = open(target, "wb")  # noqa: SIM115 - the caller's
        file.write(head)
        return file
    fd, new = _create(target)
    file = open(fd, "wb")  # noqa: SIM115 - the caller's
    try:
        file.write(head)
        file.flush()
        os.rename(new, target)
    except BaseException:
        new.unlink(missing_ok=True)
        with suppress(OSError):
            file.close()
        raise
    return file


def _target(path: Path) -> Path | int:
    """Path at the end of all links, of a regular file or of nothing; or what is there, opened."""
    for _ in range(_LINKS):
        if not path.is_symlink():
            break
        folder = Path(os.path.realpath(path.parent))
        if folder == Path(f"/proc/{os.getpid()}/fd"):
            return os.dup(int(path.name))  # a duplicate keeps the offset, as a shell's `>>` wants it
        if folder.is_relative_to("/proc"):
            return os.open(path, os.O_WRONLY | os.O_CLOEXEC)
        _refuse_planted(path)
        path = folder / path.readlink()
    else:
        raise OSError(errno.ELOOP, os.strerror(errno.ELOOP), str(path))
    with suppress(FileNotFoundError):
        mode = path.lstat().st_mode
        if stat.S_ISDIR(mode):
            raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), str(path))
        if not stat.S_ISREG(mode):
            return os.open(path, os.O_WRONLY | os.O_NOFOLLOW | os.O_NOCTTY | os.O_CLOEXEC)
    return path


def _refuse_planted(link: Path) -> None:
    """Refuse links as ``fs.protected_symlinks`` does, which a path followed by hand gets round."""
    folder, owner = link.parent.stat(), link.lstat().st_uid
    is_anybodys = folder.st_mode & stat.S_ISVTX and folder.st_mode & stat.S_IWOTH
    if is_anybodys and owner not in (os.geteuid(), folder.st_uid):
        raise PermissionError(errno.EACCES, "it is a symlink of another user", str(link))


def _refused(target: Path, number: int) -> OSError:
    """Error of a file that cannot be made in its folder, in words about the folder where that is it."""
    folder = target.parent
    if number == errno.ENOENT and not folder.is_dir():
        return FileNotFoundError(number, f"there is no folder {folder}", str(target))
    if number in (errno.ENOENT, errno.EACCES, errno.EPERM):
        return PermissionError(errno.EACCES, f"the folder {folder} cannot be written to", str(target))
    return OSError(number, os.strerror(number), str(target))


def _create(target: Path) -> tuple[int, Path]:
    """Create a new file beside the target, with the permissions of what is there."""
    try:
        old = target.stat()
    except FileNotFoundError:
        old = None
    if old and not os.access(target, os.W_OK):
        raise PermissionError(errno.EACCES, os.strerror(errno.EACCES), str(target))
    new = target.with_name(f".hil-{secrets.token_hex(8)}")
    try:
        fd = os.open(new, _NEW, 0o600 if old else 0o666)
    except OSError as error:  # whose file name is the new one's, which nobody has given
        raise _refused(target, error.errno or errno.EIO) from None
    if old:
        mode = stat.S_IMODE(old.st_mode) & 0o777
        try:
            os.fchown(fd, -1, old.st_gid)
        except PermissionError:
            mode &= ~0o070  # rights of the old file's group are not for this one
        with suppress(PermissionError):
            os.fchown(fd, old.st_uid, -1)
        os.fchmod(fd, mode)
    return fd, new
