"""Real time of the core's thread: what was asked for, what was granted, and how to get the rest."""

import errno
import os
import resource
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from hil.host.cpu_claim import CpuClaim, Holder, least_held
from hil.host.refusal import memory_refused, pin_refused, raise_rtprio, real_time_refused
from hil.host.system import System, read_system

if TYPE_CHECKING:
    from hil.core.abi import RtStats

WANTED_PRIORITY = 80
"""Wanted priority: above interrupt threads (50) of a real-time kernel, below its watchdogs (99)."""

UNASKED = "answers are right, and late when this computer is busy; `hil doctor` tells more"


@dataclass(frozen=True)
class Grant:
    """Rights granted to the thread. ``missing``: those that were not, and the remedy of each."""

    priority: int
    cpu: int
    missing: Mapping[str, str]
    more: str = ""
    """Remedy where a lower priority than wanted was granted."""
    is_asked: bool = True
    """True if the user asked for real time: who did not is spared the remedies."""
    claim: CpuClaim | None = None
    """CPU that this bench holds, which others may hold, too."""

    @property
    def state(self) -> str:
        """State of real time: ``ok``, or ``late`` where answers are late on a busy computer."""
        return "late" if self.missing else "ok"

    def line(self) -> str:
        lower = f", {WANTED_PRIORITY} was wanted: {self.more}" if self.more else ""
        pinned = f", CPU {self.cpu}" if self.cpu >= 0 else ""
        shares = f"; {text}" if (text := self.shares()) else ""
        if not self.missing:
            return f"rt: ok (SCHED_FIFO {self.priority}{pinned}, memory locked{lower}{shares})"
        cost = "; ".join(self.missing.values()) if self.is_asked else UNASKED
        return f"rt: late (no {' and no '.join(self.missing)}{shares}): {cost}"

    def shares(self) -> str:
        """Say with which other benches the thread shares its CPU now; empty if with none."""
        return self.claim.shares() if self.claim else ""


def wanted_priority() -> int:
    """Priority to ask for: what RLIMIT_RTPRIO allows, if it allows any."""
    soft, _ = resource.getrlimit(resource.RLIMIT_RTPRIO)
    return min(WANTED_PRIORITY, soft) if soft > 0 else WANTED_PRIORITY


def is_asked(configured_cpu: int | None, require_rt: bool) -> bool:
    """Answer whether the user asked for real time: by ``cpu:``, by ``--require-rt``, or by a limit that
    allows its priority."""
    return require_rt or configured_cpu is not None or resource.getrlimit(resource.RLIMIT_RTPRIO)[0] > 0


def wanted_cpu(held: Sequence[Holder]) -> int:
    """CPU that a bench without ``cpu:`` would be pinned to beside those that hold one; -1 where there is only
    one."""
    allowed = os.sched_getaffinity(0)
    return least_held(allowed, held) if len(allowed) > 1 else -1


def grant(
    stats: "RtStats",
    priority: int,
    cpu: int,
    system: System | None = None,
    *,
    asked: bool = True,
    claim: CpuClaim | None = None,
) -> Grant:
    """Describe the core's report in words. The system is read where something was refused. ``asked``: whether
    the user asked for real time; ``claim``: the CPU that is held, if others are to be told."""
    if not (stats["fifo_errno"] or stats["pin_errno"] or stats["lock_errno"]):
        more = raise_rtprio(system or read_system(), WANTED_PRIORITY) if priority < WANTED_PRIORITY else ""
        return Grant(priority, cpu, {}, more, asked, claim)
    system = system or read_system()
    missing = {}
    if stats["fifo_errno"]:
        missing["real-time priority"] = real_time_refused(system, priority).line()
    if stats["pin_errno"]:
        missing[f"CPU {cpu}"] = pin_refused(cpu).line()
    if stats["lock_errno"]:
        missing["locked memory"] = memory_refused(system).line()
    return Grant(priority, cpu, missing, is_asked=asked, claim=claim)


def refused(configured_cpu: int | None) -> str | None:
    """Reason why a configured CPU cannot be used at all, or None."""
    allowed = os.sched_getaffinity(0)
    if configured_cpu is None or configured_cpu in allowed:
        return None
    return (
        f"cpu: {configured_cpu} is not one that this process may use ({', '.join(map(str, sorted(allowed)))})"
    )


def error_name(number: int) -> str:
    """Name of an errno: EPERM and the like."""
    return errno.errorcode.get(number, str(number))
