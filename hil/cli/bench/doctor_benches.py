"""Findings of ``hil doctor`` about benches that run or ran here: each is asked from outside its sandbox,
where limits are its own."""

import os
import time
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

from hil.firmware.nvm import NvmError, decode
from hil.host.doctor import NO_START, Diagnosis
from hil.host.paths import SERVICES, STARTING
from hil.host.regular_file import NotRegularError, read_regular
from hil.net.benches_here import find_in
from hil.net.control_client import BenchLate, ControlError, ask, listener
from hil.net.socket_owner import entry_remedy
from hil.vocab.address import CONTROL_SOCKET
from hil.vocab.monitoring import LATE_KINDS

PATIENCE_S = 3.0
_OWN_REMEDY = "mend what else is listed here; `hil docs real-time` says what helps"
START_S = 60.0
"""Maximum time of a start, when nobody is served. A real board that cannot be reached takes 5 s of it."""


def judge_benches(runtime_dir: Path, is_named: bool = False) -> Iterator[Diagnosis]:
    """Make findings about the benches below the user's runtime directory, which he has named or not, and
    about the services': one for each that is well, else one for each thing that is wrong with it; before them
    one for each folder that commands do not look into."""
    found = find_in((runtime_dir, SERVICES), is_named)
    cost = "commands do not look into it, and `hil serve` refuses it"
    for left_out in found.left_out:
        yield Diagnosis("bench folders", "problem", left_out.why, cost, left_out.remedy)
    for folder in sorted(here.folder for here in found.benches):
        yield from _judge(f"bench {folder.name}", folder)


def _judge(name: str, folder: Path) -> Iterator[Diagnosis]:
    socket = folder / CONTROL_SOCKET
    try:
        pid = listener(socket)
    except OSError as error:
        found = f"its control socket refuses you: {os.strerror(error.errno or 0)}"
        cost = "`hil status` and all commands that ask it fail"
        yield Diagnosis(name, "problem", found, cost, entry_remedy(socket))
        return
    if not pid:
        remedy = f"start it again, which cleans up, or `rm -r {folder}`"
        yield Diagnosis(
            name, "note", f"no daemon runs: {folder} was left behind", "its ports are dead", remedy
        )
        return
    try:
        status = ask(socket, "status", timeout_s=PATIENCE_S)
    except BenchLate:
        if (age_s := _starting_s(socket)) is not None:
            found = f"process {pid} has been starting for {age_s:.0f} s"
            cost = "its ports and commands wait until it serves: for a real board that does not answer, 5 s"
            yield Diagnosis(name, "note", found, cost, "wait; `hil serve` says what it cannot have")
            return
        remedy = f"`systemctl restart hil`, or `kill -9 {pid}`, and start it again"
        found = f"process {pid} does not answer within {PATIENCE_S:g} s"
        yield Diagnosis(name, "problem", found, "its boards are dead", remedy)
    except ControlError as error:
        cost = "`hil status` and all commands that ask it fail"
        remedy = f"ask with the hil that runs it, or end process {pid} and start it again"
        yield Diagnosis(name, "problem", str(error), cost, remedy)
    else:
        yield from _judge_running(name, pid, status)


def _starting_s(socket: Path) -> float | None:
    """Time for which a bench has been starting; None: it has served, or hangs."""
    with suppress(OSError):
        found = socket.stat()
        age_s = max(time.time() - found.st_mtime, 0.0)
        return age_s if found.st_mode & STARTING and age_s < START_S else None
    return None


def _judge_running(name: str, pid: int, status: dict[str, Any]) -> Iterator[Diagnosis]:
    problems = status["health"]["problems"]
    for problem in problems:
        is_late = problem["kind"] in LATE_KINDS
        found = f"{problem['about']}: {problem['what']}" if problem["about"] else problem["what"]
        remedy = problem["remedy"] if "hil doctor" not in problem["remedy"] else _OWN_REMEDY
        cost = "its answers are right, and come late" if is_late else "it runs, and this does not work"
        yield Diagnosis(name, "note" if is_late else "problem", found, cost, remedy)
    paths = [row["address"] for row in status["devices"] if (row["address"] or "").startswith("/")]
    lost = [path for path in paths if not os.path.exists(path)]
    closed = [path for path in paths if path not in lost and not os.access(path, os.R_OK | os.W_OK)]
    if closed:
        found = f"{len(closed)} of its ports refuse you, {closed[0]} first"
        remedy = "as root `usermod -aG dialout USER`, then log in again; or another `group:` of its ports"
        yield Diagnosis(name, "problem", found, "programs that you start cannot open them", remedy)
    if lost:
        found = f"the names of {len(lost)} of its ports are gone, {lost[0]} first"
        yield Diagnosis(name, "problem", found, "programs cannot open them any more", "restart the bench")
    if not problems and not closed and not lost:
        yield Diagnosis(name, "ok", f"process {pid}, {status['rt_line']}")


def judge_memories(state_dir: Path) -> list[Diagnosis]:
    """Make findings about boards' memories that a start would not take as they are."""
    findings = []
    for path in sorted(state_dir.glob("*/*.nvm")):
        name = f"memory {path.parent.name}/{path.stem}"
        try:
            version = decode(read_regular(path)).migrated_from
        except (NotRegularError, IsADirectoryError) as error:
            remedy = f"`mv {path}` away, and put a copy back"
            findings.append(Diagnosis(name, "problem", str(error.strerror), NO_START, remedy))
        except OSError as error:
            remedy = f"as root `chown -R USER {path.parent}`, or choose another with --state-dir"
            findings.append(Diagnosis(name, "problem", os.strerror(error.errno or 0), NO_START, remedy))
        except NvmError as error:
            cost = "at the next start it is kept aside, and the board has an empty memory"
            remedy = f"`mv {path}` away, and put a copy back; or install the hil that wrote it"
            findings.append(Diagnosis(name, "problem", str(error), cost, remedy))
        else:
            if version is not None:
                findings.append(
                    Diagnosis(name, "ok", f"format version {version}, migrated at the next start")
                )
    return findings
