"""The core's real-time thread: what was asked for, what was granted, and how to get the rest."""

import errno
import os
import resource
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from hil.core._native import RtStats

WANTED_PRIORITY = 80
"""Above interrupt threads (50) of a real-time kernel, below its watchdogs (99)."""


@dataclass(frozen=True)
class Grant:
    """What the thread got. ``missing`` and ``remedies`` are of the same length."""

    priority: int
    cpu: int
    missing: tuple[str, ...]
    remedies: tuple[str, ...]

    @property
    def state(self) -> str:
        """``ok`` or ``degraded``."""
        return "degraded" if self.missing else "ok"

    def line(self) -> str:
        """One line for people."""
        pinned = f", CPU {self.cpu}" if self.cpu >= 0 else ""
        if not self.missing:
            return f"rt: ok (SCHED_FIFO {self.priority}{pinned}, memory locked)"
        return f"rt: degraded (no {' and no '.join(self.missing)}): {'; '.join(self.remedies)}"


def wanted_priority() -> int:
    """The priority to ask for: what RLIMIT_RTPRIO allows, if it allows any."""
    soft, _ = resource.getrlimit(resource.RLIMIT_RTPRIO)
    return min(WANTED_PRIORITY, soft) if soft > 0 else WANTED_PRIORITY


def wanted_cpu(configured: int | None) -> int:
    """The CPU to pin to: the configured one, else the last that is allowed, -1 where there is only one."""
    if configured is not None:
        return configured
    allowed = sorted(os.sched_getaffinity(0))
    return allowed[-1] if len(allowed) > 1 else -1


def grant(stats: "RtStats", priority: int, cpu: int) -> Grant:
    """What the core reports, in words."""
    missing, remedies = [], []
    if stats["fifo_errno"]:
        missing.append("real-time priority")
        remedies.append(_fifo_remedy(priority))
    if stats["pin_errno"]:
        missing.append(f"CPU {cpu}")
        remedies.append("choose a cpu: that `taskset -p $$` allows")
    if stats["lock_errno"]:
        missing.append("locked memory")
        remedies.append(f"raise RLIMIT_MEMLOCK ({_memlock()}): LimitMEMLOCK=256M, or `ulimit -l unlimited`")
    return Grant(priority, cpu, tuple(missing), tuple(remedies))


def refused(configured_cpu: int | None) -> str | None:
    """Why a configured CPU cannot be used at all, or None."""
    allowed = os.sched_getaffinity(0)
    if configured_cpu is None or configured_cpu in allowed:
        return None
    return (
        f"cpu: {configured_cpu} is not one that this process may use ({', '.join(map(str, sorted(allowed)))})"
    )


def _fifo_remedy(priority: int) -> str:
    soft, hard = resource.getrlimit(resource.RLIMIT_RTPRIO)
    if os.geteuid() == 0 and _in_rt_group_without_budget():
        return "this control group has no real-time budget: write one to its cpu.rt_runtime_us"
    limits = f"RLIMIT_RTPRIO is {soft}, at most {hard}"
    return f"{limits}: LimitRTPRIO={priority}, or `rtprio {priority}` for you in /etc/security/limits.conf"


def _in_rt_group_without_budget() -> bool:
    for line in Path("/proc/self/cgroup").read_text().splitlines():
        budget = Path(f"/sys/fs/cgroup/cpu{line.rsplit(':', 1)[1]}/cpu.rt_runtime_us")
        if budget.exists() and budget.read_text().strip() == "0":
            return True
    return False


def _memlock() -> str:
    soft, _ = resource.getrlimit(resource.RLIMIT_MEMLOCK)
    return "unlimited" if soft == resource.RLIM_INFINITY else f"now {soft // 1024} kB"


def error_name(number: int) -> str:
    """EPERM and the like."""
    return errno.errorcode.get(number, str(number))
