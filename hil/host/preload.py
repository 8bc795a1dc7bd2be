"""Library with modem lines for ptys, which ``hil with-lines`` lets another program load; and programs that
load none.

Sources: ld.so(8), ``LD_PRELOAD`` and secure-execution mode; elf(5).
"""

import os
import shutil
import stat
import struct
from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

LIBRARY = Path(__file__).with_name("libhil_lines.so")
_SEPARATORS = " :\n\t"
"""Ends of a path in the variable: it has no way to quote them."""
_SCRIPTS = 4
"""Scripts whose interpreters are scripts: the kernel follows no more."""
_PT_INTERP = 3
_GROUP_MAY_RUN = stat.S_ISGID | stat.S_IXGRP


class PreloadRefused(Exception):
    """Error of a program that cannot be started with the library: ``str(error)`` says why."""


class _Elf(NamedTuple):
    """Target for which an ELF file is made. ``is_dynamic``: a loader starts it."""

    machine: tuple[int, int, int]
    is_dynamic: bool


def find_program(name: str, env: Mapping[str, str]) -> Path:
    """Find a program as a shell does.

    Raises:
        PreloadRefused: there is none, or the library cannot get into it.
    """
    found = shutil.which(name, path=env.get("PATH", os.defpath))
    if found is None:
        why = "you may not start it" if os.path.exists(name) else "No such file"
        raise PreloadRefused(
            f"{name}: {why}"
            if "/" in name
            else f"there is no program {name!r} in $PATH; install it, or write its whole path"
        )
    if why := _refuse(Path(found)):
        raise PreloadRefused(f"{found} gets no modem lines: {why}")
    return Path(found)


def with_library(env: Mapping[str, str]) -> dict[str, str]:
    """Environment with the library behind those that are loaded already.

    Raises:
        PreloadRefused: the library is not there, or in a folder that the variable cannot name.
    """
    if not LIBRARY.exists():
        raise PreloadRefused(f"{LIBRARY} is not there: install hil again")
    if any(each in str(LIBRARY) for each in _SEPARATORS):
        raise PreloadRefused(
            f"LD_PRELOAD cannot name {LIBRARY}, for its blanks or colons: install hil elsewhere"
        )
    loaded = env.get("LD_PRELOAD")
    return {**env, "LD_PRELOAD": f"{loaded}:{LIBRARY}" if loaded else str(LIBRARY)}


def _refuse(program: Path) -> str:
    """Reason why the loader does not load the library into a program, or empty."""
    for _ in range(_SCRIPTS):
        try:
            found, head = program.stat(), _head(program)
            if not head.startswith(b"#!"):
                return _refuse_started(program, found) or _refuse_file(program)
        except OSError:
            return ""  # a program that may not be read: its start says more
        words = head[2:].partition(b"\n")[0].split()
        if not words:
            return ""
        program = Path(os.fsdecode(words[0]))
    return ""


def _refuse_started(program: Path, found: os.stat_result) -> str:
    """Reason by the rights that a program gets when it starts."""
    wants_user = found.st_mode & stat.S_ISUID and found.st_uid != os.geteuid()
    wants_group = found.st_mode & _GROUP_MAY_RUN == _GROUP_MAY_RUN and found.st_gid != os.getegid()
    if wants_user or wants_group:
        return f"it runs with the rights of another {'user' if wants_user else 'group'} (set-id)"
    if os.geteuid() and "security.capability" in os.listxattr(program):
        return "it has capabilities of its own"
    return ""


def _refuse_file(program: Path) -> str:
    ours, its = _elf(LIBRARY), _elf(program)
    if its is None:
        return ""
    if not its.is_dynamic:
        return "it is linked statically"
    if ours is not None and its.machine != ours.machine:
        return "it is made for another kind of processor than hil, or for 32 bits"
    return ""


def _head(path: Path) -> bytes:
    with path.open("rb") as file:
        return file.read(4096)


def _elf(path: Path) -> _Elf | None:
    """Read what stands in the header of an ELF file; None for any other file."""
    data = _head(path)
    if len(data) < 64 or not data.startswith(b"\x7fELF") or data[4] not in (1, 2) or data[5] not in (1, 2):
        return None
    order = "<" if data[5] == 1 else ">"
    (machine,) = struct.unpack_from(f"{order}H", data, 18)
    wide = data[4] == 2
    (start,) = struct.unpack_from(f"{order}{'Q' if wide else 'I'}", data, 32 if wide else 28)
    size, count = struct.unpack_from(f"{order}HH", data, 54 if wide else 42)
    places = [start + index * size for index in range(count)]
    kinds = [struct.unpack_from(f"{order}I", data, place)[0] for place in places if place + 4 <= len(data)]
    return _Elf((data[4], data[5], machine), _PT_INTERP in kinds)
