"""Owners of control sockets, and what lets others in: for messages to those who are refused."""

import os
import stat
from collections.abc import Iterator
from pathlib import Path

from hil.host.trust import user_name
from hil.vocab.address import CONTROL_SOCKET

_UNIX_SOCKETS = Path("/proc/net/unix")
_LISTENS = "00010000"
"""Flag __SO_ACCEPTCON of a line of it: proc_pid_net(5)."""


def owner_name(path: Path) -> str:
    """Name and number of the user whose a path is; of the folder that hides it, where it is not seen."""
    return user_name(seen.st_uid) if (seen := _seen(path)) else "an unknown user"


def entry_remedy(path: Path) -> str:
    """Remedy for a user whom a control socket, or a folder on the way to it, refuses."""
    import grp
    import pwd

    if not (seen := _seen(path)):
        return "ask as root"
    try:
        owner = pwd.getpwuid(seen.st_uid).pw_name
    except KeyError:
        owner = f"'#{seen.st_uid}'"
    remedy = "ask as root, with `sudo`" if not seen.st_uid else f"ask as its owner, with `sudo -u {owner}`"
    if not stat.S_ISSOCK(seen.st_mode) or not seen.st_mode & stat.S_IWGRP or not seen.st_gid:
        return remedy
    try:
        group = grp.getgrgid(seen.st_gid).gr_name
    except KeyError:
        return remedy
    # A group of the owner's name is his own: who joins it gets more than a bench.
    if group == owner or seen.st_gid in os.getgroups():
        return remedy
    return f"{remedy}; or join its group: as root `usermod -aG {group} USER`, then log in again"


def others_sockets() -> Iterator[Path]:
    """Control sockets of the benches that run on this computer, wherever they are and whose ever they are: in
    folders called after hil, or this user's own."""
    return (path for path in control_sockets().values() if "/hil" in str(path) or _is_own(path))


def control_sockets() -> dict[str, Path]:
    """Sockets with the name of a control socket at which a program of this computer listens, by their
    inodes."""
    try:
        lines = _UNIX_SOCKETS.read_text(errors="replace").splitlines()
    except OSError:  # no /proc: nothing is known of others
        return {}
    found: dict[str, Path] = {}
    for line in lines:
        words = line.split(maxsplit=7)
        if len(words) < 8 or words[3] != _LISTENS or not words[7].isprintable():
            continue
        path = Path(words[7])
        if path.is_absolute() and path.name == CONTROL_SOCKET:
            found[words[6]] = path
    return found


def _is_own(path: Path) -> bool:
    try:
        return path.stat().st_uid == os.geteuid()
    except OSError:  # hidden: another user's
        return False


def _seen(path: Path) -> os.stat_result | None:
    """State of a path, or of the nearest folder above it that can be seen."""
    for each in (path, *path.parents):
        try:
            return each.stat()
        except OSError:  # hidden by a folder above, or gone
            continue
    return None
