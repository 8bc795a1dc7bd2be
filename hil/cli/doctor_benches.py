"""Findings of ``hil doctor`` about benches that run or ran here: each is asked from outside its sandbox,
where limits are its own."""

import os
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from hil.firmware.nvm import NvmError, decode
from hil.host.doctor import NO_START, Finding
from hil.host.paths import CONTROL_SOCKET, SERVICES
from hil.host.regular_file import NotRegularError, read_regular
from hil.net.benches_here import find_in
from hil.net.control_client import ControlError, ask, listener

PATIENCE_S = 3.0
START_S = 60.0
"""Nobody is served before a bench has started. Each real board that cannot be reached takes 5 s of it."""


@dataclass(frozen=True)
class Seen:
    """A bench's control socket. ``pid`` 0: nobody listens. ``failure``: why it did not answer. ``age_s``: how
    long it has been there."""

    folder: Path
    pid: int
    failure: str
    status: dict[str, Any] | None
    closed_ports: tuple[str, ...]
    """Ports that this user may not open."""
    lost_ports: tuple[str, ...] = ()
    """Ports whose names are gone from the folder."""
    age_s: float = START_S


def look(runtime_dir: Path, is_named: bool = False) -> list[Seen]:
    """All benches below the user's runtime directory, which he has named or not, and the services'."""
    found = find_in((runtime_dir, SERVICES), is_named)
    return [_look_at(here.folder) for here in sorted(found.benches, key=lambda here: here.folder)]


def judge_folders(runtime_dir: Path, is_named: bool = False) -> list[Finding]:
    """One for each folder that commands do not look into."""
    cost = "commands do not look into it, and `hil serve` refuses it"
    remedy = "name a folder of yours with --runtime-dir, or set XDG_RUNTIME_DIR"
    return [
        Finding("bench folders", "problem", why, cost, remedy)
        for why in find_in((runtime_dir, SERVICES), is_named).left_out
    ]


def _look_at(folder: Path) -> Seen:
    socket, pid, failure, status = folder / CONTROL_SOCKET, 0, "", None
    try:
        pid = listener(socket)
        if pid:
            status = ask(socket, "status", timeout_s=PATIENCE_S)
    except OSError as error:
        failure = os.strerror(error.errno or 0)
    except ControlError as error:
        failure = str(error)
    rows = status["devices"] if status else []
    paths = [row["address"] for row in rows if row["address"].startswith("/")]
    lost = tuple(path for path in paths if not os.path.exists(path))
    closed = tuple(path for path in paths if path not in lost and not os.access(path, os.R_OK | os.W_OK))
    return Seen(folder, pid, failure, status, closed, lost, _age_s(socket))


def _age_s(socket: Path) -> float:
    try:
        return max(time.time() - socket.stat().st_mtime, 0.0)
    except OSError:
        return START_S


def judge_benches(seen: list[Seen]) -> list[Finding]:
    """One finding for each bench that is well, else one for each thing that is wrong with it."""
    return [finding for bench in seen for finding in _judge(bench)]


def _judge(bench: Seen) -> Iterator[Finding]:
    name = f"bench {bench.folder.name}"
    if bench.failure and not bench.pid:
        cost = "`hil status` and all commands that ask it fail"
        remedy = "ask as root, or as the user that runs it"
        yield Finding(name, "problem", f"its control socket refuses you: {bench.failure}", cost, remedy)
    elif not bench.pid:
        remedy = f"start it again, which cleans up, or `rm -r {bench.folder}`"
        found = f"no daemon runs: {bench.folder} was left behind"
        yield Finding(name, "note", found, "its ports are dead", remedy)
    elif bench.status is None and bench.age_s < START_S:
        found = f"process {bench.pid} has been starting for {bench.age_s:.0f} s"
        cost = "its ports and commands wait until it serves: for a real board that does not answer, 5 s"
        yield Finding(name, "note", found, cost, "wait; `hil serve` says what it cannot have")
    elif bench.status is None:
        remedy = f"`systemctl restart hil`, or `kill -9 {bench.pid}`, and start it again"
        found = f"process {bench.pid} does not answer within {PATIENCE_S:g} s"
        yield Finding(name, "problem", found, "its boards are dead", remedy)
    else:
        yield from _judge_running(name, bench, bench.status)


def _judge_running(name: str, bench: Seen, status: dict[str, Any]) -> Iterator[Finding]:
    problems = status["health"]["problems"]
    for problem in problems:
        found = f"{problem['about']}: {problem['what']}" if problem["about"] else problem["what"]
        yield Finding(name, "problem", found, "it runs degraded", problem["remedy"])
    if bench.closed_ports:
        found = f"{len(bench.closed_ports)} of its ports refuse you, {bench.closed_ports[0]} first"
        remedy = "as root `usermod -aG dialout USER`, then log in again; or another `group:` of its ports"
        yield Finding(name, "problem", found, "programs that you start cannot open them", remedy)
    if bench.lost_ports:
        found = f"the names of {len(bench.lost_ports)} of its ports are gone, {bench.lost_ports[0]} first"
        yield Finding(name, "problem", found, "programs cannot open them any more", "restart the bench")
    if not problems and not bench.closed_ports and not bench.lost_ports:
        yield Finding(name, "ok", f"process {bench.pid}, {status['rt_line']}")


def judge_memories(state_dir: Path) -> list[Finding]:
    """The boards' memories that a start would not take as they are."""
    findings = []
    for path in sorted(state_dir.glob("*/*.nvm")):
        name = f"memory {path.parent.name}/{path.stem}"
        try:
            version = decode(read_regular(path)).migrated_from
        except (NotRegularError, IsADirectoryError) as error:
            remedy = f"`mv {path}` away, and put a copy back"
            findings.append(Finding(name, "problem", str(error.strerror), NO_START, remedy))
        except OSError as error:
            remedy = f"as root `chown -R USER {path.parent}`, or choose another with --state-dir"
            findings.append(Finding(name, "problem", os.strerror(error.errno or 0), NO_START, remedy))
        except NvmError as error:
            cost = "at the next start it is kept aside, and the board has an empty memory"
            remedy = f"`mv {path}` away, and put a copy back; or install the hil that wrote it"
            findings.append(Finding(name, "problem", str(error), cost, remedy))
        else:
            if version is not None:
                findings.append(Finding(name, "ok", f"format version {version}, migrated at the next start"))
    return findings
