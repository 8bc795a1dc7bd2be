"""Reasons why Linux refused the core's thread something, each with the line that mends it.

The one place for these texts: ``hil serve``, ``hil status`` and ``hil doctor`` say the same.
"""

from dataclasses import dataclass

from hil.host.system import CAP_IPC_LOCK, CAP_SYS_NICE, UNLIMITED, ResourceLimit, System

MEMLOCK_MB = 45
"""Locked memory that the remedies grant: the code, the stack and hundreds of axes, with room."""
BUDGET_US = 500_000
"""Budget in the usual period of a second: the core uses a few percent of a CPU, and more to catch up."""
DEFAULT_RT_RUNTIME_US = 950_000
ALLOW_SECCOMP = (
    "in a unit no RestrictRealtime=yes and no SystemCallFilter= without {calls}; in a container a profile "
    "with {calls} (--security-opt seccomp=)"
)


@dataclass(frozen=True)
class SystemRefusal:
    cause: str
    remedy: str

    def line(self) -> str:
        return f"{self.cause}: {self.remedy}"


def real_time_refused(system: System, priority: int) -> SystemRefusal:
    if not system.may(CAP_SYS_NICE) and not (system.rtprio and system.rtprio.allows(priority)):
        return SystemRefusal(
            f"RLIMIT_RTPRIO is {rtprio_words(system.rtprio)}", raise_rtprio(system, priority)
        )
    if starved := [group.file for group in system.rt_groups if group.budget_us == 0]:
        return SystemRefusal(
            "this control group has no real-time budget",
            # Top down: a group cannot have more than its parent.
            f"as root `echo {BUDGET_US} | tee {' '.join(reversed(starved))}`",
        )
    if system.rt_groups_without_budgets:
        return SystemRefusal(
            "this kernel has CONFIG_RT_GROUP_SCHED, and control groups of version 2 get no real-time budget",
            "`rt_group_sched=0` on the kernel's command line (Linux 6.16), or a kernel without it",
        )
    if system.rt_runtime_us == 0:
        return SystemRefusal("kernel.sched_rt_runtime_us is 0", restore_rt_runtime())
    if system.seccomp:
        return SystemRefusal("a seccomp filter refuses it", ALLOW_SECCOMP.format(calls="sched_setscheduler"))
    return SystemRefusal(
        "the limits allow it, the kernel does not", "see `dmesg` for a security module that says why"
    )


def memory_refused(system: System) -> SystemRefusal:
    limited = not (system.memlock and system.memlock.soft == UNLIMITED)
    if not limited or system.may(CAP_IPC_LOCK):
        if system.seccomp:
            return SystemRefusal("a seccomp filter refuses mlock", ALLOW_SECCOMP.format(calls="mlock"))
        return SystemRefusal(
            "the limits allow it, the kernel does not",
            "free some memory, or raise the control group's memory.max",
        )
    return SystemRefusal(f"RLIMIT_MEMLOCK is {_kilobytes(system.memlock)}", raise_memlock(system))


def pin_refused(cpu: int) -> SystemRefusal:
    return SystemRefusal(f"CPU {cpu} is not allowed", "choose a cpu: that `taskset -p $$` allows")


def rtprio_words(limit: ResourceLimit | None) -> str:
    if limit is None:
        return "not known"
    soft, hard = ("unlimited" if n == UNLIMITED else n for n in (limit.soft, limit.hard))
    return f"{soft}, at most {hard}"


def raise_rtprio(system: System, priority: int) -> str:
    if system.rtprio and system.rtprio.may_allow(priority):
        return f"`ulimit -r {priority}`"
    remedy = f"LimitRTPRIO={priority}, or `rtprio {priority}` for you in /etc/security/limits.conf"
    return f"{remedy}, or --ulimit rtprio={priority} for this container" if system.container else remedy


def raise_memlock(system: System) -> str:
    if system.memlock and system.memlock.may_allow(MEMLOCK_MB << 20):
        return f"`ulimit -l {MEMLOCK_MB << 10}`"
    remedy = (
        f"LimitMEMLOCK={MEMLOCK_MB}M, or `memlock {MEMLOCK_MB << 10}` for you in /etc/security/limits.conf"
    )
    return (
        f"{remedy}, or --ulimit memlock={MEMLOCK_MB << 20} for this container" if system.container else remedy
    )


def restore_rt_runtime() -> str:
    return f"as root `sysctl -w kernel.sched_rt_runtime_us={DEFAULT_RT_RUNTIME_US}`"


def _kilobytes(limit: ResourceLimit | None) -> str:
    return "not known" if limit is None else f"{limit.soft // 1024} kB"
