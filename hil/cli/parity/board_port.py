"""Port of a real board: whether it can be had, and by whom it is held."""

import errno
import os
import stat
from collections.abc import Iterator
from contextlib import suppress
from itertools import islice
from pathlib import Path

from hil.cli.framework.ask import fail
from hil.cli.framework.exit_codes import Exit

_MASTER = "/dev/ptmx", "/dev/pts/ptmx"
_PSEUDO_TERMINALS = range(136, 144)
"""Major numbers of devices in /dev/pts. Source: Linux, Documentation/admin-guide/devices.txt."""
_NAMED = 3
"""Maximum number of programs that are named."""
_BUSY = {os.strerror(number) for number in (errno.EBUSY, errno.EAGAIN)}


def is_url(at: str) -> bool:
    return "://" in at


def refuse_port(at: str) -> None:
    """End the command if a path is no serial port that this user may open alone."""
    if is_url(at):
        return
    path = Path(at)
    try:
        mode = path.stat().st_mode
    except OSError as error:
        raise fail(f"hil: {at}: {error.strerror}; {_there()}", Exit.MISTAKE) from None
    if not stat.S_ISCHR(mode) or not _is_terminal(path):
        raise fail(f"hil: {at} is no serial port; {_there()}", Exit.MISTAKE)
    if not os.access(path, os.R_OK | os.W_OK):
        raise fail(f"hil: {at}: you may not open it; it belongs to {_owners(path)}", Exit.MISTAKE)
    if held := list(islice(_holders(path), _NAMED)):
        raise fail(
            f"hil: {at}: {' and '.join(held)} has it open, and would get a part of the answers; close it",
            Exit.MISTAKE,
        )


def opening_words(at: str, error: str) -> str:
    """Say why a port cannot be opened. ``error``: as ``SerialTalk`` has it."""
    if error.removeprefix(f"{at}: ") in _BUSY:
        return f"{at}: another program has it open; close it"
    return error


def _there() -> str:
    from serial.tools.list_ports import comports

    ports = sorted(comports())
    found = [
        each.device if each.description == "n/a" else f"{each.device} ({each.description})" for each in ports
    ]
    return f"there are {', '.join(found)}" if found else "this computer has no serial port"


def _owners(path: Path) -> str:
    try:
        owner, group = path.owner(), path.group()
    except KeyError:
        return "others"
    if path.stat().st_mode & stat.S_IRGRP:
        return f"{owner} and the group {group}: `usermod -aG {group} USER` adds a user to it"
    return owner


def _is_terminal(path: Path) -> bool:
    """True if a device is a terminal, or nothing tells. It is not opened: that starts some boards."""
    device = path.stat().st_rdev
    if os.major(device) in _PSEUDO_TERMINALS:
        return True
    kind = Path(f"/sys/dev/char/{os.major(device)}:{os.minor(device)}/subsystem")
    return not kind.exists() or kind.resolve().name == "tty"


def _holders(path: Path) -> Iterator[str]:
    """Programs that have a device open, as far as this user may look. What has a pseudo-terminal's other end
    holds this one too, and is none of them."""
    device = path.stat().st_rdev
    for process in Path("/proc").glob("[0-9]*"):
        if process.name == str(os.getpid()):
            continue
        with suppress(OSError):
            links = list((process / "fd").iterdir())
            if any(str(link.readlink()) in _MASTER for link in links):
                continue
            if any(_device(link) == device for link in links):
                yield f"{(process / 'comm').read_text().strip()} (process {process.name})"


def _device(link: Path) -> int | None:
    """Device that a descriptor of a process is of."""
    with suppress(OSError):
        if str(link.readlink()).startswith("/dev/") and stat.S_ISCHR((status := link.stat()).st_mode):
            return status.st_rdev
    return None
