"""Systems of all kinds for ``hil doctor``, each a small folder with the files that matter."""

from dataclasses import replace
from errno import ENOMEM, EPERM
from pathlib import Path

from hil.host.doctor import Diagnosis, judge
from hil.host.probes import Tried
from hil.host.system import System, read_system

LIMITS = """\
Limit                     Soft Limit           Hard Limit           Units
Max open files            {nofile:<20} {nofile:<20} files
Max locked memory         {memlock:<20} {memlock:<20} bytes
Max nice priority         0                    0
Max realtime priority     {rtprio:<20} {hard_rtprio:<20}
Max realtime timeout      unlimited            unlimited            us
"""
STATUS = "Name:\thil\nCapEff:\t{capabilities:016x}\nSeccomp:\t{seccomp}\nCpus_allowed_list:\t{cpus}\n"
V1_MOUNT = "33 31 0:30 / /sys/fs/cgroup/cpu,cpuacct rw,relatime shared:9 - cgroup cgroup rw,cpu,cpuacct\n"
V2_MOUNT = "41 31 0:38 / /sys/fs/cgroup rw,relatime - cgroup2 cgroup2 rw,nsdelegate\n"
CAP_SYS_NICE = 1 << 23
GOOD = {
    "proc/sys/kernel/osrelease": "6.12.9-rt-amd64\n",
    "proc/version": "Linux version 6.12.9-rt-amd64 (gcc) #1 SMP PREEMPT_RT Debian\n",
    "proc/cmdline": "quiet\n",
    "sys/kernel/realtime": "1\n",
    "proc/self/cgroup": "0::/user.slice\n",
    "proc/self/mountinfo": V2_MOUNT,
    "sys/fs/cgroup/user.slice/cpu.max": "max 100000\n",
    "proc/self/uid_map": "         0          0 4294967295\n",
    "proc/sys/kernel/sched_rt_runtime_us": "950000\n",
    "proc/sys/kernel/sched_rt_period_us": "1000000\n",
    "sys/devices/system/cpu/isolated": "3\n",
    "sys/devices/system/cpu/nohz_full": "3\n",
    "sys/devices/system/clocksource/clocksource0/current_clocksource": "tsc\n",
    "proc/sys/kernel/pty/max": "4096\n",
    "proc/sys/kernel/pty/nr": "7\n",
    "proc/sys/kernel/pty/reserve": "1024\n",
    "proc/sys/fs/inotify/max_user_instances": "128\n",
    "proc/cpuinfo": "flags\t\t: fpu tsc\n",
} | {f"sys/devices/system/cpu/cpu{cpu}/cpufreq/scaling_governor": "performance\n" for cpu in range(4)}
TRIED = Tried(
    priority=80,
    cpu=3,
    core_failure="",
    fifo_errno=0,
    pin_errno=0,
    lock_errno=0,
    locked_kB=5168,
    pty_errno=0,
    inotify_errno=0,
    runtime_dir=Path("/run/user/1000/hil"),
    runtime_failure="",
    state_dir=Path("/home/me/.local/state/hil"),
    state_failure="",
)
REFUSED = replace(TRIED, fifo_errno=EPERM)
UNLOCKED = replace(TRIED, lock_errno=ENOMEM)


class Machine:
    """A tree of files of a well set up system, some of them replaced (None: removed)."""

    def __init__(self, root: Path) -> None:
        self.root = root

    def system(
        self,
        files: dict[str, str | bytes | None] | None = None,
        *,
        nofile: object = 1024,
        memlock: object = 256 << 20,
        rtprio: object = 80,
        hard_rtprio: object = None,
        capabilities: int = 0,
        seccomp: int = 0,
        cpus: str = "0-3",
    ) -> System:
        hard = rtprio if hard_rtprio is None else hard_rtprio
        limits = LIMITS.format(nofile=nofile, memlock=memlock, rtprio=rtprio, hard_rtprio=hard)
        status = STATUS.format(capabilities=capabilities, seccomp=seccomp, cpus=cpus)
        own = {"proc/self/limits": limits, "proc/self/status": status}
        for path, content in {**GOOD, **own, **(files or {})}.items():
            if content is not None:
                file = self.root / path
                file.parent.mkdir(parents=True, exist_ok=True)
                file.write_bytes(content.encode() if isinstance(content, str) else content)
        return read_system(self.root)


def found(system: System, name: str, tried: Tried = TRIED, devices: int = 8) -> Diagnosis:
    (finding,) = (each for each in judge(system, tried, devices) if each.name == name)
    return finding


def says(finding: Diagnosis, verdict: str, in_found: str, in_remedy: str) -> None:
    assert finding.verdict == verdict, finding
    assert in_found in finding.found, finding
    assert in_remedy in finding.remedy, finding
    assert finding.cost, finding
