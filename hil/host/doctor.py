"""``hil doctor``: checks that this system is fit for real time and for ports, and gives the line that makes
it so.

Judgement alone: what the system says comes from ``system.py``, what was tried from ``probes.py``.
"""

import re
from dataclasses import dataclass, replace
from errno import EACCES, ENOENT, ENOSPC, EPERM
from pathlib import Path
from typing import Literal

from hil.host.probes import Tried
from hil.host.real_time import WANTED_PRIORITY, error_name
from hil.host.refusal import (
    memory_refused,
    pin_refused,
    raise_rtprio,
    real_time_refused,
    restore_rt_runtime,
    rtprio_words,
)
from hil.host.system import CAP_DAC_OVERRIDE, CAP_SYS_NICE, UNLIMITED, System

Verdict = Literal["ok", "note", "problem"]
WORST_FIRST: tuple[Verdict, ...] = ("problem", "note", "ok")

LATE = "on a busy machine answers come late; what they say and their simulated times stay right"
STALLS = "the motor stands still, and answers wait, for up to"
NO_START = "`hil serve` does not start"
FAST_CLOCKS = ("tsc", "kvm-clock", "hyperv_clocksource_tsc_page", "arch_sys_counter", "riscv_clocksource")
"""Clock sources that are read without entering the kernel."""
DEVPTS = "gid=5,mode=620,ptmxmode=666"
"""Mount options of distributions; 5 is the group tty."""
DESCRIPTORS = 24
"""Number of descriptors of a daemon without devices, with a few commands that talk to it."""
DESCRIPTORS_PER_DEVICE = 3
"""Number of descriptors of a device: both ends of a pty, or a listening socket and two clients."""


_Judgement = tuple[Verdict, *tuple[str, ...]]
"""A verdict, what was found, and where that is not ok, cost and remedy."""


@dataclass(frozen=True)
class Diagnosis:
    """The result of one check. ``problem``: something a bench needs is refused; ``note``: it runs, and could
    run better. A result that is ok has no cost and no remedy."""

    name: str
    verdict: Verdict
    found: str
    cost: str = ""
    remedy: str = ""


def judge(system: System, tried: Tried, devices: int) -> list[Diagnosis]:
    """Judge a system for a bench of so many devices; answers all findings, the worst first."""
    judgements: dict[str, _Judgement] = {
        "real-time priority": _real_time(system, tried),
        "locked memory": _locked_memory(system, tried),
        "RLIMIT_RTPRIO": _rtprio(system, tried),
        "real-time group": _rt_group(system, tried),
        "real-time throttling": _throttling(system),
        "seccomp": _seccomp(system, tried),
        "CPUs": _cpus(system, tried),
        "isolated CPU": _isolation(system),
        "CPU quota": _quota(system),
        "kernel": _kernel(system),
        "CPU frequency": _governor(system),
        "clock source": _clock(system),
        "container": _container(system),
        "virtual machine": _virtual(system),
        "ptys": _ptys(system, tried, devices),
        "group dialout": _group(system),
        "inotify": _inotify(system, tried),
        "RLIMIT_NOFILE": _descriptors(system, devices),
        "runtime directory": _folder(tried.runtime_dir, tried.runtime_failure, "--runtime-dir"),
        "state directory": _folder(tried.state_dir, tried.state_failure, "--state-dir"),
    }
    return worst_first([Diagnosis(name, *judgement) for name, judgement in judgements.items()])


def worst_first(findings: list[Diagnosis]) -> list[Diagnosis]:
    """Sort findings by verdict, the worst first; those of one verdict stay in their order."""
    return sorted(findings, key=lambda finding: WORST_FIRST.index(finding.verdict))


def healthy(findings: list[Diagnosis]) -> bool:
    return all(finding.verdict != "problem" for finding in findings)


def _real_time(system: System, tried: Tried) -> _Judgement:
    if tried.core_failure:
        remedy = "see RLIMIT_NOFILE below, and `ulimit -u` and `ulimit -v`"
        return "problem", f"the core's thread did not start: {tried.core_failure}", NO_START, remedy
    if not tried.fifo_errno:
        return "ok", f"tried: SCHED_FIFO {tried.priority}"
    why = real_time_refused(system, tried.priority)
    found = f"tried, refused ({error_name(tried.fifo_errno)}): {why.cause}"
    return "problem", found, LATE, why.remedy


def _locked_memory(system: System, tried: Tried) -> _Judgement:
    if tried.core_failure:
        return "note", "not tried: the core's thread did not start", NO_START
    if not tried.lock_errno:
        return "ok", f"tried: {tried.locked_kB} kB"
    why = memory_refused(system)
    found = f"tried, refused ({error_name(tried.lock_errno)}): {why.cause}"
    return "problem", found, "where memory is short, a wake waits for the disk", why.remedy


def _rtprio(system: System, tried: Tried) -> _Judgement:
    found = rtprio_words(system.rtprio)
    if system.rtprio and system.rtprio.allows(WANTED_PRIORITY):
        return "ok", found
    if system.rtprio and system.rtprio.soft > 0:
        cost = f"the thread has priority {tried.priority}; above it run others"
        return "note", found, cost, raise_rtprio(system, WANTED_PRIORITY)
    if system.may(CAP_SYS_NICE):
        return "ok", f"{found}; CAP_SYS_NICE makes up for it"
    return "note", found, "no real-time priority", raise_rtprio(system, WANTED_PRIORITY)


def _rt_group(system: System, tried: Tried) -> _Judgement:
    starved = any(group.budget_us == 0 for group in system.rt_groups)
    if starved or system.rt_groups_without_budgets:
        if not tried.fifo_errno:
            return "ok", "no budget, but real-time priority was given"
        # Other refusals are part of the finding on the priority itself.
        allowed = replace(system, capabilities=system.capabilities | {CAP_SYS_NICE})
        why = real_time_refused(allowed, tried.priority)
        return "problem", why.cause, "no real-time priority, whatever the limits say", why.remedy
    if not system.rt_groups:
        return "ok", "control groups have no real-time budgets here"
    own = min(system.rt_groups, key=lambda group: group.budget_us / group.period_us)
    return "ok", f"{own.budget_us} of {own.period_us} us"


def _throttling(system: System) -> _Judgement:
    runtime_us, period_us = system.rt_runtime_us, system.rt_period_us
    if runtime_us is None or not period_us:
        return "ok", "not known"
    if runtime_us < 0:
        return "ok", "off"
    found = f"real-time threads may use {runtime_us} of {period_us} us"
    if runtime_us * 2 < period_us:
        cost = f"{STALLS} {(period_us - runtime_us) / 1000:.0f} ms in each {period_us / 1000:.0f}"
        return "problem" if runtime_us == 0 else "note", found, cost, restore_rt_runtime()
    return "ok", found


def _seccomp(system: System, tried: Tried) -> _Judgement:
    if not system.seccomp:
        return "ok", "no filter"
    if tried.fifo_errno or tried.lock_errno or tried.pin_errno:
        cost = "it may be what refuses, or refuse next what limits refuse now"
        return "note", "a filter is installed", cost, "first do what is said above"
    return "ok", "a filter, which lets pass what a bench needs"


def _cpus(system: System, tried: Tried) -> _Judgement:
    listed = f"{len(system.allowed_cpus) or 'unknown'} allowed ({ranges(system.allowed_cpus)})"
    if tried.pin_errno:
        why = pin_refused(tried.cpu)
        found = f"{listed}; pinning to {tried.cpu} was refused ({error_name(tried.pin_errno)})"
        return "note", found, LATE, why.remedy
    if len(system.allowed_cpus) == 1:
        cost = "the core's thread and Python take turns: " + LATE
        return "note", listed, cost, "allow two: `taskset -c 0,1`, AllowedCPUs=, --cpuset-cpus=0,1"
    held = "".join(f"; bench {', '.join(benches)} has {cpu}" for cpu, benches in tried.held.items())
    return "ok", f"{listed}{held}; the core takes {tried.cpu}" if tried.cpu >= 0 else listed


def _isolation(system: System) -> _Judgement:
    isolated, allowed = system.isolated_cpus, system.allowed_cpus
    usable = [cpu for cpu in isolated if cpu in allowed]
    if usable:
        tickless = ", no timer tick" if usable[-1] in system.tickless_cpus else ""
        return "ok", f"{ranges(isolated)}{tickless}; use it with `cpu: {usable[-1]}`"
    if not isolated and len(allowed) < 2:
        return "ok", "none; there is no second CPU to isolate"
    cpu = (isolated or allowed)[-1]
    # A process is not allowed an isolated CPU unless it asks for it.
    ask = f"`taskset -c {ranges(tuple(sorted({*allowed, *isolated})))} hil serve ...` with `cpu: {cpu}`"
    if isolated:
        return "note", f"{ranges(isolated)}, not among those allowed", "nothing uses them", ask
    cost = "other programs run on the core's CPU, and the kernel's work delays it"
    return "note", "none", cost, f"boot the kernel with `isolcpus={cpu} nohz_full={cpu}`, then {ask}"


def _quota(system: System) -> _Judgement:
    if not system.quotas:
        return "ok", "none"
    tightest = min(system.quotas, key=lambda quota: quota.budget_us / quota.period_us)
    share = tightest.budget_us / tightest.period_us
    found = f"{share:.2f} CPUs ({tightest.file})"
    cost = f"once it is used up the firmware stops for up to {tightest.period_us / 1000:.0f} ms at a time"
    remedy = "no CPUQuota= in the unit, no --cpus for the container"
    return "problem" if share < 1 else "note", found, cost, remedy


def _kernel(system: System) -> _Judgement:
    found = f"Linux {system.kernel or 'of unknown version'}, preemption: {system.preemption or 'not known'}"
    if system.preemption == "PREEMPT_RT":
        return "ok", found
    cost = "under load one wake in a thousand is late by milliseconds"
    full = (
        "" if system.preemption == "full" else "; `preempt=full` on the kernel's command line helps a little"
    )
    remedy = "a PREEMPT_RT kernel, on Debian `apt install linux-image-rt-amd64`"
    return "note", found, cost, remedy + full


def _governor(system: System) -> _Judgement:
    governors = system.governors
    if not governors:
        return "ok", "not governed from here"
    if governors == ("performance",):
        return "ok", "performance"
    cost = "a CPU that was idle is slow at first: wakes take longer"
    return "note", ", ".join(governors), cost, "as root `cpupower frequency-set -g performance`"


def _clock(system: System) -> _Judgement:
    source = system.clock_source
    if source in FAST_CLOCKS or not source:
        return "ok", source or "not known"
    cost = "each look at the clock takes a microsecond or more, and a wake has several"
    remedy = (
        "`dmesg | grep -i tsc` says why not the TSC; if it is steady, boot the kernel with `tsc=reliable`"
    )
    if "jiffies" in source:
        return "problem", source, "time goes in steps of milliseconds", remedy
    return "note", source, cost, remedy


def _container(system: System) -> _Judgement:
    if not system.container:
        return "ok", "no"
    cost = "limits come from the container's runtime, not from this system's files"
    remedy = "give them where it is started: --ulimit rtprio=80 --ulimit memlock=268435456"
    return "note", system.container, cost, remedy


def _virtual(system: System) -> _Judgement:
    if not system.virtual:
        return "ok", "no"
    cost = "its host may stop it for tens of milliseconds, and nothing here can tell or help"
    return "note", system.virtual, cost, "for the best figures use a machine of its own"


def _ptys(system: System, tried: Tried, devices: int) -> _Judgement:
    raise_it = f"as root `sysctl -w kernel.pty.max={4096 + devices}`"
    limited = re.search(r"\bmax=(\d+)", system.devpts)
    if tried.pty_errno:
        found = f"tried, refused ({error_name(tried.pty_errno)})"
        remedy = f"{raise_it}; see RLIMIT_NOFILE"
        if tried.pty_errno == ENOSPC and limited:
            found += f": {limited[1]} at most in this mount of /dev/pts"
            remedy = f"as root `mount -o remount,max={4096 + devices} /dev/pts`"
        elif tried.pty_errno in (EACCES, EPERM, ENOENT):
            how = f"-o remount,{DEVPTS}" if system.devpts else f"-t devpts -o {DEVPTS} devpts"
            remedy = f"as root `mount {how} /dev/pts`"
        return "problem", found, "no pty port opens", remedy
    if limited and int(limited[1]) < devices:
        found = f"{limited[1]} at most in this mount of /dev/pts"
        remedy = f"as root `mount -o remount,max={4096 + devices} /dev/pts`"
        return "problem", found, f"a bench of {devices} pty ports does not start", remedy
    if system.pty_max is None or system.pty_used is None:
        return "ok", "tried"
    # The reserve is kept for the first mount of devpts: others may be a container's.
    left = system.pty_max - system.pty_used - (system.pty_reserve if system.container else 0)
    found = f"{system.pty_used} of {system.pty_max} in use"
    if left < devices:
        cost = f"a bench of {devices} pty ports does not start"
        return "problem", found, cost, raise_it
    return "ok", found


def _group(system: System) -> _Judgement:
    if system.dialout is None:
        return "ok", "there is none here"
    if system.dialout in system.groups or system.may(CAP_DAC_OVERRIDE):
        return "ok", "a member" if system.dialout in system.groups else "not needed: root"
    remedy = "as root `usermod -aG dialout USER`, then log in again; in a unit SupplementaryGroups=dialout"
    cost = "real boards' serial ports and those of a service's bench refuse you; so does `group: dialout`"
    return "note", "not a member", cost, remedy


def _inotify(system: System, tried: Tried) -> _Judgement:
    if not tried.inotify_errno:
        most = system.inotify_instances
        return "ok", "tried" if most is None else f"tried; {most} for each user"
    found = f"tried, refused ({error_name(tried.inotify_errno)}); {system.inotify_instances} for each user"
    remedy = "as root `sysctl -w fs.inotify.max_user_instances=512`; see RLIMIT_NOFILE"
    return "problem", found, "no pty port opens: each daemon needs one", remedy


def _descriptors(system: System, devices: int) -> _Judgement:
    limit = system.nofile
    needed = DESCRIPTORS + DESCRIPTORS_PER_DEVICE * devices
    if limit is None:
        return "ok", "not known"
    found = "unlimited" if limit.soft == UNLIMITED else str(limit.soft)
    if limit.allows(needed):
        return "ok", found
    cost = f"a bench of {devices} devices needs about {needed}: ports or clients are refused"
    wanted = max(1024, needed)
    remedy = (
        f"`ulimit -n {wanted}`"
        if limit.may_allow(wanted)
        else f"LimitNOFILE={wanted}, or `nofile {wanted}` for you in /etc/security/limits.conf"
    )
    return "problem", found, cost, remedy


def _folder(folder: Path, failure: str, option: str) -> _Judgement:
    if not failure:
        return "ok", f"{folder} can be written"
    return "problem", f"{folder}: {failure}", NO_START, f"choose another with {option}"


def ranges(cpus: tuple[int, ...]) -> str:
    """Format numbers as ranges: (0, 1, 2, 5) as ``0-2,5``."""
    parts: list[list[int]] = []
    for cpu in cpus:
        if parts and cpu == parts[-1][-1] + 1:
            parts[-1].append(cpu)
        else:
            parts.append([cpu])
    return (
        ",".join(f"{part[0]}-{part[-1]}" if len(part) > 1 else str(part[0]) for part in parts) or "not known"
    )
