"""Symlink by which users know a terminal, whose own number changes from start to start."""

import os
import re
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

_TERMINALS = re.compile(r"/dev/(pts/|ttyACM)[0-9]+")
"""Targets of the names that hil makes."""

_made: set[Path] = set()
"""Folders that were made for names, and are removed with the last of them."""
_published: dict[Path, list[Path]] = {}
"""Targets of the names of this process's open ports, the newest last. A reload opens a port before
it closes another of the same name, or gives up and closes the new one."""


def publish(title: str, name: Path, terminal: Path, *, is_chosen: bool = False) -> None:
    """Point ``name`` at a terminal in one step, in place of a symlink that an earlier run has left.

    A freed number is soon another program's, so a symlink to a living terminal is no sign of an owner.
    ``is_chosen``: the name is outside the folder of this bench, and may be that of another bench's port.

    Raises:
        PortError: the name is something else, another bench's, or its directory cannot be written.
    """
    directory = name.parent
    try:
        _make(directory)
        _refuse_others(title, name)
        if is_chosen and name not in _published and name.is_symlink():
            _refuse_another_benches(title, name)
        _point(name, terminal)
    except PortError:
        _remove_made(directory)
        raise
    except OSError as error:
        _remove_made(directory)
        raise PortError(f"{title}: {_why(directory, name, error)} choose another path:") from error
    _published.setdefault(name, []).append(terminal)


def withdraw(name: Path, terminal: Path) -> None:
    """Withdraw ``name`` if it still points at this terminal: give it back to the open port that had it
    before, or remove it, with its folder where that was made for it and is empty; otherwise it is another's
    by now."""
    others = [other for other in _published.pop(name, []) if other != terminal]
    if others:
        _published[name] = others
    try:
        if name.readlink() != terminal:
            return
        if others:
            _point(name, others[-1])
        else:
            name.unlink()
    except OSError:
        pass  # gone, replaced by something else, or no longer ours to remove
    _remove_made(name.parent)


def _why(directory: Path, name: Path, error: OSError) -> str:
    if isinstance(error, FileExistsError | NotADirectoryError):
        return f"{error.filename} is not a directory;"
    if isinstance(error, PermissionError):
        return f"no permission to write in {directory}; give user {os.geteuid()} write permission, or"
    return f"cannot make the symlink {name}: {error.strerror};"


def _make(directory: Path) -> None:
    """Make a folder and those above it, and note which are new. Raises OSError: it cannot be made."""
    for folder in reversed((directory, *directory.parents)):
        if not folder.is_dir():
            folder.mkdir(exist_ok=True)
            _made.add(folder)


def _remove_made(directory: Path) -> None:
    """Remove a folder and those above it, as far as they were made here and are empty."""
    for folder in (directory, *directory.parents):
        if folder not in _made:
            if os.path.exists(folder):
                return
            continue
        try:
            folder.rmdir()
        except FileNotFoundError:
            pass
        except OSError:  # something else is in it
            return
        _made.discard(folder)


def _point(name: Path, terminal: Path) -> None:
    temporary = name.parent / f".{name.name}.{os.getpid()}-{terminal.name}"
    temporary.unlink(missing_ok=True)
    temporary.symlink_to(terminal)
    try:
        temporary.replace(name)
    except OSError:
        temporary.unlink()
        raise


def _refuse_another_benches(title: str, name: Path) -> None:
    from hil.net.name_holder import bench_with

    if bench := bench_with(str(name)):
        raise PortError(f"{title}: {name} is a port of the running bench {bench}; choose another path:")


def _refuse_others(title: str, name: Path) -> None:
    try:
        mode = name.lstat().st_mode
    except FileNotFoundError:
        return
    if stat.S_ISLNK(mode):
        target = name.readlink()
        if _TERMINALS.fullmatch(str(target)) or not name.exists():
            return
        kind = f"a symlink to {target}"
    else:
        kind = next((text for test, text in _KINDS if test(mode)), "something else")
    raise PortError(
        f"{title}: {name} is {kind}, not a symlink to a terminal; remove it or choose another path:"
    )
