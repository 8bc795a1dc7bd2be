"""Benches that run here, and the choice of one. Imports little, as ``control_client.py``."""

import os
import shlex
import time
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from hil.host.paths import SERVICES, closed_folders, control_sockets, runtime_bases
from hil.host.trust import distrust, user_name
from hil.net.control_client import listener
from hil.net.socket_owner import entry_remedy, others_sockets, owner_name
from hil.vocab.late_dataclass import dataclass

SERVICE = "service:"
"""Prefix of the name of a service's bench."""
_MOST_OTHERS = 3
"""Benches elsewhere that one line says."""


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
class ClosedPlace:
    """Place that is not looked into: why, and what helps."""

    why: str
    remedy: str

    def __str__(self) -> str:
        return f"{self.why}: {self.remedy}"


TRUST_REMEDY = "set XDG_RUNTIME_DIR, or name a folder of yours with --runtime-dir"


@dataclass(frozen=True)
class Found:
    """Control sockets that were found. ``left_out``: folders that are not looked into. ``named``: the folder
    that the user named, if he did. ``killed``: folders that killed benches left behind."""

    benches: list[Here]
    left_out: list[ClosedPlace]
    named: Path | None = None
    killed: Sequence[Path] = ()

    def running(self) -> "Found":
        """Leave out the sockets that killed benches left behind."""
        killed = [each.folder for each in self.benches if _is_left_behind(each.socket)]
        return replace(self, benches=[e for e in self.benches if e.folder not in killed], killed=killed)

    def not_running(self, said: str) -> str:
        """Say that this bench does not run here: it was killed, or others run."""
        names = ", ".join(map(self.called, self.benches))
        for folder in self.killed:
            if said in (folder.name, str(folder), SERVICE + folder.name):
                killed = f"bench {folder.name!r} was killed (folder {folder})"
                return f"{killed}: start it again, which cleans up; running: {names}"
        from hil.vocab.near_words import did_you_mean, nearest

        near = did_you_mean(nearest(Path(said).stem, [each.name for each in self.benches]))
        return " ".join(filter(None, [f"bench {said!r} is not running here;", near, f"running: {names}"]))

    def none_runs(self, asked: str | None = None) -> str:
        """Say that no bench runs here, and where one could be instead. ``asked``: the one that was asked for,
        which is named alone if it was killed."""
        said = "no bench is running here"
        if self.left_out:
            return f"{said}, but not all was seen: {'; '.join(map(str, self.left_out))}"
        if self.killed:
            meant = [each for each in self.killed if asked in (each.name, str(each), SERVICE + each.name)]
            killed = meant or self.killed
            remedy = "start it again, which cleans up, or remove the folder"
            if len(killed) > 1:
                folders, remedy = ", ".join(map(str, killed)), "start them again, which cleans up, or remove"
                return f"{said}; some were killed that had {folders}: {remedy} the folders"
            return f"{said}; one was killed that had {killed[0]}: {remedy}"
        if self.named:
            serves = f"`hil --runtime-dir {shlex.quote(str(self.named))} serve FILE` starts one"
            if self.named.is_dir():
                return f"{said}, below {self.named}; {serves}"
            return f"{said}: there is no folder {self.named}; {serves}"
        others = [f"{each.parent} of {owner_name(each)} ({_way_to(each)})" for each in others_sockets()]
        if others:
            return f"{said}; elsewhere there is {', '.join(others[:_MOST_OTHERS])}"
        return f"{said}; `hil serve FILE` starts one"

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
    left_out: list[ClosedPlace] = []
    for base in bases:
        # Who names a folder means its owner. /run is root's, who says whose /run/hil is, and what is in it.
        is_service = base.is_relative_to(SERVICES)
        owners = {_owner(base)} if is_named or is_service else set()
        if why := distrust(base, owners):
            left_out.append(ClosedPlace(why, TRUST_REMEDY))
            continue
        for folder in closed_folders(base):
            why = f"{folder} of {owner_name(folder)} is closed to you"
            left_out.append(ClosedPlace(why, entry_remedy(folder)))
        for socket in control_sockets(base):
            owner = _owner(socket.parent)
            # Root has given it to him, as the service manager does.
            given = {owner} if is_service and _owner(socket.parent.parent) == 0 else set()
            if why := distrust(socket.parent, owners | given):
                left_out.append(ClosedPlace(why, TRUST_REMEDY))
            else:
                benches.setdefault(socket, Here(socket, owner, socket.is_relative_to(SERVICES)))
    return Found(list(benches.values()), left_out, bases[0] if is_named else None)


def _way_to(socket: Path) -> str:
    """Word with which a command asks a bench that it does not find by itself."""
    if os.access(socket, os.W_OK):
        return f"--runtime-dir {socket.parent.parent}"
    return entry_remedy(socket)


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
