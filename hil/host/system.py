"""State of this Linux: limits, control groups, kernel, CPUs, clocks. Reads; judges nothing.

All of it comes from files below a root, so that a folder with a few files can stand for any system.
"""

import gzip
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

UNLIMITED = -1
CAP_DAC_OVERRIDE, CAP_IPC_LOCK, CAP_SYS_NICE = 1, 14, 23  # linux/capability.h
ALL_IDS = "4294967295"
"""Length of the id map of a process that is in no user namespace of its own."""


@dataclass(frozen=True)
class ResourceLimit:
    """Resource limit; UNLIMITED is -1."""

    soft: int
    hard: int

    def allows(self, wanted: int) -> bool:
        """True if the limit in force is at least ``wanted``."""
        return self.soft == UNLIMITED or self.soft >= wanted

    def may_allow(self, wanted: int) -> bool:
        """True if the process itself may raise the limit to ``wanted``."""
        return self.hard == UNLIMITED or self.hard >= wanted


@dataclass(frozen=True)
class Budget:
    """Time that a control group may use in each period, in us; ``file`` is where it stands."""

    file: str
    budget_us: int
    period_us: int


@dataclass(frozen=True)
class System:
    """Reading of the system. None, an empty text or an empty tuple: it does not say."""

    rtprio: ResourceLimit | None
    memlock: ResourceLimit | None
    nofile: ResourceLimit | None
    capabilities: frozenset[int]
    """Effective capabilities; none in a user namespace, where they do not reach what this is about."""
    seccomp: bool
    rt_groups: tuple[Budget, ...]
    """Real-time budgets of the process's control group and those above it, its own first."""
    rt_groups_without_budgets: bool
    """True if there are real-time groups in a version 2 hierarchy: no group but the root has or can get a
    budget."""
    quotas: tuple[Budget, ...]
    """CPU quotas in force on the process's control groups."""
    rt_runtime_us: int | None
    rt_period_us: int | None
    kernel: str
    preemption: str
    """Preemption model: PREEMPT_RT, full, lazy, voluntary or none."""
    allowed_cpus: tuple[int, ...]
    isolated_cpus: tuple[int, ...]
    tickless_cpus: tuple[int, ...]
    governors: tuple[str, ...]
    """Governors of the allowed CPUs, each name once."""
    clock_source: str
    container: str
    virtual: str
    pty_max: int | None
    pty_used: int | None
    pty_reserve: int
    inotify_instances: int | None
    devpts: str
    """Options of the mount that is on /dev/pts."""
    dialout: int | None
    """Number of the group that serial ports belong to."""
    groups: frozenset[int]
    """Group numbers of the process."""

    def may(self, capability: int) -> bool:
        return capability in self.capabilities


class Files:
    """Reader of text files below a root; what is missing or may not be read is None."""

    def __init__(self, root: Path) -> None:
        self._root = root

    def raw(self, path: str) -> bytes | None:
        try:
            return (self._root / path.lstrip("/")).read_bytes()
        except OSError:
            return None

    def text(self, path: str) -> str | None:
        data = self.raw(path)
        return None if data is None else data.decode(errors="replace").strip()

    def number(self, path: str) -> int | None:
        text = self.text(path)
        return int(text) if text and re.fullmatch(r"-?\d+", text) else None

    def cpus(self, path: str) -> tuple[int, ...]:
        return _cpus(self.text(path) or "")


def read_system(root: Path = Path("/")) -> System:
    """Read the system that the process runs on."""
    files = Files(root)
    status = dict(re.findall(r"^(\w+):[ \t]*(.*)$", files.text("/proc/self/status") or "", re.M))
    limits = _limits(files.text("/proc/self/limits") or "")
    version = files.text("/proc/version") or ""
    command_line = (files.text("/proc/cmdline") or "").split()
    config = kernel_config(files)
    old_groups, new_groups = _groups(files, "cgroup"), _groups(files, "cgroup2")
    own_namespace = not (files.text("/proc/self/uid_map") or ALL_IDS).endswith(ALL_IDS)
    mask = 0 if own_namespace else int(status.get("CapEff") or "0", 16)
    allowed = _cpus(status.get("Cpus_allowed_list", ""))
    return System(
        rtprio=limits.get("realtime priority"),
        memlock=limits.get("locked memory"),
        nofile=limits.get("open files"),
        capabilities=frozenset(bit for bit in range(64) if mask >> bit & 1),
        seccomp=status.get("Seccomp", "0") != "0",
        rt_groups=_budgets(files, old_groups, "cpu.rt_runtime_us", "cpu.rt_period_us"),
        rt_groups_without_budgets=_rt_groups_on(config, command_line)
        and any(files.text(f"{group}/cpu.max") for group in new_groups),
        quotas=_quotas(files, old_groups, new_groups),
        rt_runtime_us=files.number("/proc/sys/kernel/sched_rt_runtime_us"),
        rt_period_us=files.number("/proc/sys/kernel/sched_rt_period_us"),
        kernel=files.text("/proc/sys/kernel/osrelease") or "",
        preemption=_preemption(files, version, command_line, config),
        allowed_cpus=allowed,
        isolated_cpus=files.cpus("/sys/devices/system/cpu/isolated"),
        tickless_cpus=files.cpus("/sys/devices/system/cpu/nohz_full"),
        governors=_governors(files, allowed),
        clock_source=files.text("/sys/devices/system/clocksource/clocksource0/current_clocksource") or "",
        container=_container(files),
        virtual=_virtual(files, version),
        pty_max=files.number("/proc/sys/kernel/pty/max"),
        pty_used=files.number("/proc/sys/kernel/pty/nr"),
        pty_reserve=files.number("/proc/sys/kernel/pty/reserve") or 0,
        inotify_instances=files.number("/proc/sys/fs/inotify/max_user_instances"),
        devpts=_devpts(files),
        dialout=group_number(files, "dialout"),
        groups=frozenset(map(int, f"{status.get('Gid', '')} {status.get('Groups', '')}".split())),
    )


def _cpus(listed: str) -> tuple[int, ...]:
    """Parse a list of CPUs: ``0-2,5`` as (0, 1, 2, 5)."""
    found: list[int] = []
    for first, last in re.findall(r"(\d+)(?:-(\d+))?", listed):
        found += range(int(first), int(last or first) + 1)
    return tuple(found)


def _limits(text: str) -> dict[str, ResourceLimit]:
    def number(word: str) -> int:
        return UNLIMITED if word == "unlimited" else int(word)

    rows = re.findall(r"^Max ([a-z ]+?) {2,}(\d+|unlimited) +(\d+|unlimited)", text, re.M)
    return {name: ResourceLimit(number(soft), number(hard)) for name, soft, hard in rows}


def _mounts(files: Files) -> Iterator[tuple[str, str, str, str]]:
    """Root, folder, kind and options of each mount."""
    for line in (files.text("/proc/self/mountinfo") or "").splitlines():
        mount, _, source = line.partition(" - ")
        root, folder = mount.split()[3:5]
        kind, *_, options = source.split()
        yield root, folder, kind, options


def _groups(files: Files, kind: str) -> list[str]:
    """Folders of the process's control group (``cgroup``: of the controller cpu; ``cgroup2``: the only
    one) and of those above it, as far as they are mounted here. Sources: proc(5), cgroups(7)."""
    member = ""
    for number, controllers, path in re.findall(
        r"^(\d+):([^:]*):(.*)$", files.text("/proc/self/cgroup") or "", re.M
    ):
        if "cpu" in controllers.split(",") if kind == "cgroup" else number == "0":
            member = path
    if not member:
        return []
    for root, folder, kind_there, options in _mounts(files):
        if kind_there != kind or (kind == "cgroup" and "cpu" not in options.split(",")):
            continue
        inside = member.removeprefix(root.rstrip("/")).strip("/")
        parts = [] if ".." in inside.split("/") or not inside else inside.split("/")
        return ["/".join([folder, *parts[:depth]]) for depth in range(len(parts), -1, -1)]
    return []


def _budgets(files: Files, groups: list[str], budget: str, period: str) -> tuple[Budget, ...]:
    found = []
    for group in groups:
        budget_us, period_us = files.number(f"{group}/{budget}"), files.number(f"{group}/{period}")
        if budget_us is not None and period_us:
            found.append(Budget(f"{group}/{budget}", budget_us, period_us))
    return tuple(found)


def _quotas(files: Files, old_groups: list[str], new_groups: list[str]) -> tuple[Budget, ...]:
    found = [
        b for b in _budgets(files, old_groups, "cpu.cfs_quota_us", "cpu.cfs_period_us") if b.budget_us > 0
    ]
    for group in new_groups:
        if words := re.fullmatch(r"(\d+) (\d+)", files.text(f"{group}/cpu.max") or ""):
            found.append(Budget(f"{group}/cpu.max", int(words[1]), int(words[2])))
    return tuple(found)


def _devpts(files: Files) -> str:
    found = [
        options for _, folder, kind, options in _mounts(files) if (folder, kind) == ("/dev/pts", "devpts")
    ]
    return found[-1] if found else ""  # a later mount covers an earlier one


def group_number(files: Files, name: str) -> int | None:
    """Number of a group by /etc/group; None: it is not in there."""
    found = re.search(rf"^{name}:[^:]*:(\d+):", files.text("/etc/group") or "", re.M)
    return int(found[1]) if found else None


def kernel_config(files: Files) -> str:
    """Configuration that the kernel was built with; empty: it is not here."""
    if packed := files.raw("/proc/config.gz"):
        return gzip.decompress(packed).decode()
    return files.text(f"/boot/config-{files.text('/proc/sys/kernel/osrelease')}") or ""


def _rt_groups_on(config: str, command_line: list[str]) -> bool:
    """True if real-time groups are on. Linux 6.16 can switch them at boot; before, what was compiled in was
    on."""
    if "CONFIG_RT_GROUP_SCHED=y" not in config:
        return False
    chosen = [
        word.removeprefix("rt_group_sched=") for word in command_line if word.startswith("rt_group_sched=")
    ]
    if chosen:
        return chosen[-1] in ("1", "y", "on")
    return "CONFIG_RT_GROUP_SCHED_DEFAULT_DISABLED=y" not in config


def _preemption(files: Files, version: str, command_line: list[str], config: str) -> str:
    if files.text("/sys/kernel/realtime") == "1" or "PREEMPT_RT" in version:
        return "PREEMPT_RT"
    if chosen := re.search(r"\((\w+)\)", files.text("/sys/kernel/debug/sched/preempt") or ""):
        return chosen[1]
    if asked := [word.removeprefix("preempt=") for word in command_line if word.startswith("preempt=")]:
        return asked[-1]
    if built := re.search(r"^CONFIG_PREEMPT(?:_(NONE|VOLUNTARY|LAZY))?=y", config, re.M):
        return built[1].lower() if built[1] else "full"
    return "full" if re.search(r"\bPREEMPT\b", version) else ""


def _governors(files: Files, cpus: tuple[int, ...]) -> tuple[str, ...]:
    read = (files.text(f"/sys/devices/system/cpu/cpu{cpu}/cpufreq/scaling_governor") for cpu in cpus)
    return tuple(sorted({governor for governor in read if governor}))


def _container(files: Files) -> str:
    if files.text("/.dockerenv") is not None:
        return "Docker"
    if files.text("/run/.containerenv") is not None:
        return "Podman"
    if named := files.text("/run/systemd/container"):
        return named
    found = re.search(r"docker|kubepods|containerd|libpod|lxc", files.text("/proc/self/cgroup") or "")
    return found[0] if found else ""


def _virtual(files: Files, version: str) -> str:
    if "microsoft" in version.lower():
        return "WSL"
    if kind := files.text("/sys/hypervisor/type"):
        return kind
    vendor = files.text("/sys/class/dmi/id/sys_vendor") or ""
    if re.search(r"QEMU|VMware|innotek|Xen|Parallels|Amazon EC2|Google", vendor):
        return vendor
    flags = re.search(r"^flags\s*:.*\bhypervisor\b", files.text("/proc/cpuinfo") or "", re.M)
    return "virtual machine" if flags else ""
