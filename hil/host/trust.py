"""Trust in a runtime folder and in what is in it, by their owners: where all may write it can be anybody's.

Imports little: completion in a shell waits for it.
"""

import errno
import os
import stat
from collections.abc import Collection
from pathlib import Path

_LINKS = 40
_PTY_MAJORS = range(136, 144)
"""Device numbers of pty slaves: the kernel's Documentation/admin-guide/devices.txt."""
_SYSFS = Path("/sys/dev/char")


def distrust(folder: Path, owners: Collection[int] = ()) -> str:
    """Reason why what is in a folder is not to be believed, empty if it is.

    The folder, and every folder and link on the way to it, have to belong to this user, to root or to one of
    ``owners``, and nobody else may write there. On the way, a folder in which all may write will do if they
    can remove only what is theirs (/tmp). A folder that is not there is believed.
    """
    believed = {0, os.geteuid(), *owners}
    at, left, links = Path("/"), list(reversed(Path(os.path.abspath(folder)).parts[1:])), 0
    while True:
        try:
            found = at.lstat()
        except FileNotFoundError:
            return ""
        except OSError as error:
            return f"{at}: {error.strerror}"
        if found.st_uid not in believed:
            return f"{at} belongs to another user, {user_name(found.st_uid)}"
        if stat.S_ISLNK(found.st_mode):
            if (links := links + 1) > _LINKS:
                return f"{at}: {os.strerror(errno.ELOOP)}"
            target = at.readlink()
            left += reversed(target.parts[1:] if target.is_absolute() else target.parts)
            at = Path("/") if target.is_absolute() else at.parent
        elif not stat.S_ISDIR(found.st_mode):
            return f"{at} is no folder"
        elif why := _writers(found, bool(left)):
            return f"{at} may be written by {why}"
        if not left:
            return ""
        word = left.pop()
        at = at.parent if word == ".." else at / word


def _writers(found: os.stat_result, is_on_the_way: bool) -> str:
    """Other users who may write into a folder, if that matters."""
    if is_on_the_way and found.st_mode & stat.S_ISVTX:
        return ""
    if found.st_mode & stat.S_IWOTH:
        return "everybody"
    if found.st_mode & stat.S_IWGRP and found.st_gid and not _is_private(found.st_gid, found.st_uid):
        return f"a group, {found.st_gid}"
    return ""


def _is_private(group: int, user: int) -> bool:
    """True if a group is a user's own, of his name and with nobody else in it."""
    import grp
    import pwd

    try:
        name, of_group = pwd.getpwuid(user).pw_name, grp.getgrgid(group)
    except KeyError:
        return False
    return of_group.gr_name == name and set(of_group.gr_mem) <= {name}


def user_name(uid: int) -> str:
    """Name and number of a user."""
    import pwd

    try:
        return f"{pwd.getpwuid(uid).pw_name} ({uid})"
    except KeyError:
        return str(uid)


def refuse_address(address: str, owner: int) -> str:
    """Reason why a bench's text is no port's address, empty if it is one: a pseudo-terminal of its owner's, a
    device at a virtual USB controller, which has no owner, or what the network reaches."""
    if address.startswith(("socket://", "rfc2217://")):
        return ""
    if not address.startswith("/") or "\0" in address:
        return "it is no path, socket:// or rfc2217://"
    try:
        found = os.stat(address)
    except OSError as error:
        return error.strerror or str(error)
    if stat.S_ISCHR(found.st_mode) and _is_virtual_usb(found.st_rdev):
        return ""
    if not stat.S_ISCHR(found.st_mode) or os.major(found.st_rdev) not in _PTY_MAJORS:
        return "it is neither a pseudo-terminal nor a virtual USB device"
    if found.st_uid != owner:
        return f"it is a terminal of another user, {user_name(found.st_uid)}"
    return ""


def _is_virtual_usb(number: int) -> bool:
    """True for a character device behind the kernel's virtual USB controller, so that it is no real board."""
    link = _SYSFS / f"{os.major(number)}:{os.minor(number)}"
    return any(part.startswith("vhci_hcd") for part in Path(os.path.realpath(link)).parts)
