"""The symlink by which users know a pts, whose own number changes from start to start."""

import os
import stat
from pathlib import Path

from hil.vocab.ports import PortError

_KINDS = (
    (stat.S_ISREG, "a regular file"),
    (stat.S_ISDIR, "a directory"),
    (stat.S_ISCHR, "a character device"),
    (stat.S_ISBLK, "a block device"),
    (stat.S_ISFIFO, "a fifo"),
    (stat.S_ISSOCK, "a socket"),
)


def publish(title: str, name: Path, pts: Path) -> None:
    """Point ``name`` at ``pts`` in one step, in place of a symlink that an earlier run has left.

    A freed pts number is soon another program's, so a symlink to a living pts is no sign of an owner.

    Raises:
        PortError: the name is something else, or its directory cannot be written.
    """
    directory = name.parent
    try:
        directory.mkdir(parents=True, exist_ok=True)
        _refuse_others(title, name)
        temporary = directory / f".{name.name}.{os.getpid()}-{pts.name}"
        temporary.unlink(missing_ok=True)
        temporary.symlink_to(pts)
        try:
            temporary.replace(name)
        except OSError:
            temporary.unlink()
            raise
    except (FileExistsError, NotADirectoryError) as error:
        raise PortError(f"{title}: {error.filename} is not a directory; choose another path:") from error
    except PermissionError as error:
        raise PortError(
            f"{title}: no permission to write in {directory}; give user {os.geteuid()} write permission, "
            "or choose another path:"
        ) from error
    except OSError as error:
        raise PortError(
            f"{title}: cannot make the symlink {name}: {error.strerror}; choose another path:"
        ) from error


def withdraw(name: Path, pts: Path) -> None:
    """Remove ``name`` if it still points at ``pts``; otherwise it is another's by now."""
    try:
        if name.readlink() == pts:
            name.unlink()
    except OSError:
        pass  # gone, replaced by something else, or no longer ours to remove


def _refuse_others(title: str, name: Path) -> None:
    try:
        mode = name.lstat().st_mode
    except FileNotFoundError:
        return
    if stat.S_ISLNK(mode):
        target = name.readlink()
        if target.parent == Path("/dev/pts") or not name.exists():
            return
        kind = f"a symlink to {target}"
    else:
        kind = next((text for test, text in _KINDS if test(mode)), "something else")
    raise PortError(f"{title}: {name} is {kind}, not a symlink to a pts; remove it or choose another path:")
