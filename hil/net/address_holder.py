"""Holder of a TCP address on this computer: which program listens there, as far as this user may see it."""

import ipaddress
import os
import sys
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

from hil.host.trust import user_name
from hil.net.socket_owner import control_sockets

_TABLES = (Path("/proc/net/tcp"), Path("/proc/net/tcp6"))
_PROC = Path("/proc")
_LISTENS = "0A"
"""State TCP_LISTEN of a line of them: include/net/tcp_states.h."""
_BYTE_ORDER = sys.byteorder
_Address = ipaddress.IPv4Address | ipaddress.IPv6Address


class _Row(NamedTuple):
    host: _Address
    port: int
    is_listening: bool
    uid: int
    inode: str


def address_holder(host: str, port: int) -> str:
    """Words for who has an address: ``hil (process 1234, bench demo)``, ``a program of alice (1000)``; empty
    where nobody is seen. ``host``: an address, not a name."""
    try:
        wanted = ipaddress.ip_address(host)
    except ValueError:
        return ""
    rows = [row for row in _rows() if row.port == port and _overlap(row.host, wanted)]
    if row := min(rows, key=lambda row: not row.is_listening, default=None):
        if (pid := _process_with(f"socket:[{row.inode}]")) is None:
            is_own = row.uid == os.geteuid()
            whose = "this user that cannot be looked into" if is_own else "another user"
            return f"a program of {whose}, {user_name(row.uid)}"
        return _process(pid)
    return ""


def device_holder(path: str) -> str:
    """Words for who else has a device file open, as ``address_holder``; empty where nobody is seen."""
    pid = _process_with(os.path.realpath(path))
    return "" if pid in (None, os.getpid()) else _process(pid)


def _process(pid: int) -> str:
    bench = _bench_of(pid)
    return f"{_program(pid)} (process {pid}{f', bench {bench}' if bench else ''})"


def _rows() -> Iterator[_Row]:
    for table in _TABLES:
        try:
            lines = table.read_text().splitlines()[1:]
        except OSError:  # no /proc, or no IPv6
            continue
        for line in lines:
            words = line.split()
            if len(words) > 9 and words[9] != "0":
                host, _, port = words[1].partition(":")
                yield _Row(_read(host), int(port, 16), words[3] == _LISTENS, int(words[7]), words[9])


def _read(digits: str) -> _Address:
    """Read an address: each four bytes are a number of this processor's byte order."""
    numbers = (digits[at : at + 8] for at in range(0, len(digits), 8))
    return ipaddress.ip_address(b"".join(int(each, 16).to_bytes(4, _BYTE_ORDER) for each in numbers))


def _overlap(one: _Address, other: _Address) -> bool:
    one, other = (getattr(each, "ipv4_mapped", None) or each for each in (one, other))
    return one == other or one.is_unspecified or other.is_unspecified


def _process_with(wanted: str) -> int | None:
    """Find the process that has a file open, which is this one only if no other has; None: those of other
    users cannot be looked into."""
    for folder in _PROC.glob("[1-9]*"):
        if wanted in _open_files(folder):
            return int(folder.name)
    return None


def _open_files(process: Path) -> Iterator[str]:
    try:
        numbers = os.listdir(process / "fd")
    except OSError:  # another user's, or gone
        return
    for number in numbers:
        with suppress(OSError):  # closed meanwhile
            yield os.readlink(process / "fd" / number)


def _bench_of(pid: int) -> str:
    """Name of the bench that a process runs; empty: none."""
    found = control_sockets()
    for each in _open_files(_PROC / str(pid)):
        if path := found.get(each.removeprefix("socket:[").removesuffix("]")):
            return path.parent.name
    return ""


def _program(pid: int) -> str:
    """Name of a process's program: of a script, the script's."""
    try:
        words = (_PROC / str(pid) / "cmdline").read_bytes().decode(errors="replace").split("\0")
        name = (_PROC / str(pid) / "comm").read_text(errors="replace").strip()
    except OSError:
        return "a program"
    if name.startswith("python"):
        words = [word for word in words[1:] if word and word != "-m"]
        if words and not words[0].startswith("-"):
            name = os.path.basename(words[0])
    return name if name.isprintable() and name else "a program"
