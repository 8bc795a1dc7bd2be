"""Benches that run here, and the choice of one. Imports little, as ``control_client.py``."""

import os
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from hil.host.paths import SERVICES, control_sockets, runtime_bases
from hil.host.trust import distrust, user_name
from hil.net.control_client import listener

SERVICE = "service:"
"""Prefix of the name of a service's bench."""


@dataclass(frozen=True)
class Here:
    """Control socket of a bench. ``owner``: whose folder it is in."""

    socket: Path
    owner: int
    is_service: bool

    @property
    def name(self) -> str:
        return self.socket.parent.name

    @property
    def folder(self) -> Path:
        return self.socket.parent

    def line(self) -> str:
        """Description that tells it from others of its name."""
        try:
            pid, since_s = listener(self.socket), self.socket.stat().st_mtime
        except OSError:
            pid, since_s = 0, 0.0
        since = time.strftime("%Y-%m-%d %H:%M:%S", time.localtime(since_s))
        return f"{self.folder}, of {user_name(self.owner)}, process {pid}, since {since}"


@dataclass(frozen=True)
class Found:
    """Control sockets that were found. ``left_out``: folders that are not looked into, and why."""

    benches: list[Here]
    left_out: list[str]

    def running(self) -> "Found":
        """Leave out the sockets that killed benches left behind."""
        return Found([each for each in self.benches if not _is_left_behind(each.socket)], self.left_out)

    def meant(self, said: str | None) -> list[Here]:
        """Benches that ``--bench`` can mean: a name, ``service:NAME`` or a folder; None: all."""
        if said is None:
            return self.benches
        if "/" in said:
            folder = Path(said).resolve()
            return [each for each in self.benches if each.folder.resolve() == folder]
        if said.startswith(SERVICE):
            name = said.removeprefix(SERVICE)
            return [each for each in self.benches if each.is_service and each.name == name]
        return [each for each in self.benches if each.name == said]

    def called(self, bench: Here) -> str:
        """Shortest text with which ``--bench`` means this one alone."""
        for said in (bench.name, SERVICE + bench.name):
            if self.meant(said) == [bench]:
                return said
        return str(bench.folder)

    def options(self, folder: Path, runtime_dir: Path | None, env: Mapping[str, str]) -> list[str]:
        """Options with which a command that is typed now asks the bench of this folder; ``runtime_dir``: the
        option with which these were found."""
        words = ["--runtime-dir", str(runtime_dir)] if runtime_dir else []
        if [each.folder for each in self.meant(env.get("HIL_BENCH") or None)] == [folder]:
            return words
        called = [self.called(each) for each in self.benches if each.folder == folder]
        return [*words, "-b", *(called or [str(folder)])]


def find(option: Path | None, env: Mapping[str, str]) -> Found:
    """Find the control sockets below the folder of ``--runtime-dir``, or the user's and the services'."""
    return find_in(runtime_bases(option, env), option is not None)


def find_in(bases: Sequence[Path], is_named: bool) -> Found:
    """Find as ``find``, below these folders; ``is_named``: the user said so."""
    benches: dict[Path, Here] = {}
    left_out: list[str] = []
    for base in bases:
        # Who names a folder means its owner. /run is root's, who says whose /run/hil is, and what is in it.
        is_service = base.is_relative_to(SERVICES)
        owners = {_owner(base)} if is_named or is_service else set()
        if why := distrust(base, owners):
            left_out.append(why)
            continue
        for socket in control_sockets(base):
            owner = _owner(socket.parent)
            # Root has given it to him, as the service manager does.
            given = {owner} if is_service and _owner(socket.parent.parent) == 0 else set()
            if why := distrust(socket.parent, owners | given):
                left_out.append(why)
            else:
                benches.setdefault(socket, Here(socket, owner, socket.is_relative_to(SERVICES)))
    return Found(list(benches.values()), left_out)


def _owner(folder: Path) -> int:
    try:
        return folder.stat().st_uid
    except OSError:
        return os.geteuid()


def _is_left_behind(socket: Path) -> bool:
    try:
        return not listener(socket)
    except OSError:
        return False  # `ask` says what is wrong with it
