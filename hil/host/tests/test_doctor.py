"""What ``hil doctor`` says about systems of all kinds, each a small folder with the files that matter."""

import gzip
from dataclasses import replace
from errno import EACCES, EMFILE, ENOENT, ENOMEM, ENOSPC, EPERM
from pathlib import Path

import pytest

from hil.host.doctor import WORST_FIRST, Diagnosis, healthy, judge, ranges
from hil.host.probes import Tried
from hil.host.real_time import grant
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


@pytest.fixture
def machine(tmp_path: Path) -> Machine:
    return Machine(tmp_path)


def found(system: System, name: str, tried: Tried = TRIED, devices: int = 8) -> Diagnosis:
    (finding,) = (each for each in judge(system, tried, devices) if each.name == name)
    return finding


def says(finding: Diagnosis, verdict: str, in_found: str, in_remedy: str) -> None:
    assert finding.verdict == verdict, finding
    assert in_found in finding.found, finding
    assert in_remedy in finding.remedy, finding
    assert finding.cost, finding


def test_a_well_set_up_system_is_ok_throughout(machine: Machine) -> None:
    findings = judge(machine.system(), TRIED, 8)
    assert [finding for finding in findings if finding.verdict != "ok"] == []
    assert healthy(findings)
    assert not any(finding.cost or finding.remedy for finding in findings)


def test_a_system_that_says_nothing_at_all_is_judged_all_the_same(tmp_path: Path) -> None:
    findings = judge(read_system(tmp_path), replace(REFUSED, lock_errno=EPERM, pin_errno=EPERM), 8)
    assert not healthy(findings)
    assert next(f for f in findings if f.name == "real-time priority").remedy.startswith("LimitRTPRIO=80")


def test_worst_first_and_notes_alone_are_healthy(machine: Machine) -> None:
    system = machine.system({"proc/cpuinfo": "flags : fpu hypervisor tsc\n"})
    findings = judge(system, replace(TRIED, state_failure="/: Read-only file system"), 8)
    ranks = [WORST_FIRST.index(finding.verdict) for finding in findings]
    assert ranks == sorted(ranks)
    assert [finding.name for finding in findings[:2]] == ["state directory", "virtual machine"]
    assert not healthy(findings)
    assert healthy(findings[1:])


@pytest.mark.parametrize(
    ("rtprio", "hard", "container", "remedy"),
    [
        (0, 0, False, "LimitRTPRIO=80, or `rtprio 80` for you in /etc/security/limits.conf"),
        (0, 0, True, "or --ulimit rtprio=80 for this container"),
        (0, 99, False, "`ulimit -r 80`"),
        (0, "unlimited", False, "`ulimit -r 80`"),
    ],
)
def test_no_rtprio(machine: Machine, rtprio: int, hard: object, container: bool, remedy: str) -> None:
    marker = {"run/.containerenv": ""} if container else {}
    system = machine.system(marker, rtprio=rtprio, hard_rtprio=hard)
    says(
        found(system, "real-time priority", REFUSED),
        "problem",
        f"(EPERM): RLIMIT_RTPRIO is 0, at most {hard}",
        remedy,
    )
    says(found(system, "RLIMIT_RTPRIO", REFUSED), "note", f"0, at most {hard}", remedy)


def test_a_low_rtprio_is_a_note(machine: Machine) -> None:
    system = machine.system(rtprio=10)
    assert found(system, "real-time priority", replace(TRIED, priority=10)).verdict == "ok"
    says(
        found(system, "RLIMIT_RTPRIO", replace(TRIED, priority=10)),
        "note",
        "10, at most 10",
        "LimitRTPRIO=80",
    )


def test_a_capability_makes_up_for_limits_but_not_in_a_user_namespace(machine: Machine) -> None:
    system = machine.system(rtprio=0, capabilities=CAP_SYS_NICE, seccomp=2)
    assert found(system, "RLIMIT_RTPRIO").verdict == "ok"
    assert "seccomp" in found(system, "real-time priority", REFUSED).found
    system = machine.system(
        {"proc/self/uid_map": "0 1000 1\n"}, rtprio=0, capabilities=CAP_SYS_NICE, seccomp=2
    )
    assert "RLIMIT_RTPRIO" in found(system, "real-time priority", REFUSED).found


@pytest.mark.parametrize("mount_root", ["/", "/docker/1"])
def test_groups_without_a_budget_and_how_to_give_them_one(machine: Machine, mount_root: str) -> None:
    where = "sys/fs/cgroup/cpu,cpuacct"
    below = ["a", "a/b"] if mount_root == "/" else ["a"]
    files: dict[str, str | bytes | None] = {
        "proc/self/cgroup": f"5:memory:/x\n4:cpu,cpuacct:{mount_root.rstrip('/')}/{below[-1]}\n0::/\n",
        "proc/self/mountinfo": V1_MOUNT.replace(" / ", f" {mount_root} ", 1),
        f"{where}/cpu.rt_runtime_us": "950000\n",
        f"{where}/cpu.rt_period_us": "1000000\n",
    }
    for group in below:
        files |= {
            f"{where}/{group}/cpu.rt_runtime_us": "0\n",
            f"{where}/{group}/cpu.rt_period_us": "1000000\n",
        }
    knobs = " ".join(f"/{where}/{group}/cpu.rt_runtime_us" for group in below)
    system = machine.system(files, capabilities=CAP_SYS_NICE)
    for name in ("real-time priority", "real-time group"):
        says(found(system, name, REFUSED), "problem", "no real-time budget", f"`echo 500000 | tee {knobs}`")
    nobody = machine.system(files, rtprio=0)
    assert "RLIMIT_RTPRIO" in found(nobody, "real-time priority", REFUSED).found
    says(found(nobody, "real-time group", REFUSED), "problem", "no real-time budget", knobs)


def test_a_budget_is_ok(machine: Machine) -> None:
    where = "sys/fs/cgroup/cpu,cpuacct"
    files: dict[str, str | bytes | None] = {
        "proc/self/cgroup": "4:cpu,cpuacct:/\n",
        "proc/self/mountinfo": V1_MOUNT,
        f"{where}/cpu.rt_runtime_us": "950000\n",
        f"{where}/cpu.rt_period_us": "1000000\n",
    }
    assert found(machine.system(files), "real-time group") == Diagnosis(
        "real-time group", "ok", "950000 of 1000000 us"
    )


@pytest.mark.parametrize(
    ("config", "command_line", "starved"),
    [
        ("CONFIG_RT_GROUP_SCHED=y", "quiet", True),
        ("CONFIG_RT_GROUP_SCHED=y", "quiet rt_group_sched=0", False),
        ("CONFIG_RT_GROUP_SCHED=y\nCONFIG_RT_GROUP_SCHED_DEFAULT_DISABLED=y", "quiet", False),
        ("# CONFIG_RT_GROUP_SCHED is not set", "quiet", False),
    ],
)
@pytest.mark.parametrize("packed", [True, False])
def test_version_2_groups_of_a_kernel_with_real_time_groups(
    machine: Machine, config: str, command_line: str, starved: bool, packed: bool
) -> None:
    file = (
        {"proc/config.gz": gzip.compress(config.encode())}
        if packed
        else {"boot/config-6.12.9-rt-amd64": config}
    )
    system = machine.system({**file, "proc/cmdline": command_line})
    assert found(system, "real-time group").verdict == "ok"  # it was tried, and was given
    finding = found(system, "real-time group", REFUSED)
    if starved:
        says(finding, "problem", "CONFIG_RT_GROUP_SCHED", "rt_group_sched=0")
    else:
        assert finding.verdict == "ok"


def test_seccomp(machine: Machine) -> None:
    system = machine.system(seccomp=2)
    assert found(system, "seccomp").verdict == "ok"
    says(found(system, "seccomp", REFUSED), "note", "filter", "above")
    says(found(system, "real-time priority", REFUSED), "problem", "a seccomp filter", "RestrictRealtime")
    locked = machine.system(seccomp=2, memlock="unlimited")
    says(found(locked, "locked memory", UNLOCKED), "problem", "a seccomp filter", "SystemCallFilter")


def test_refused_for_no_reason_that_can_be_seen(machine: Machine) -> None:
    system = machine.system(memlock="unlimited")
    says(found(system, "real-time priority", REFUSED), "problem", "the kernel does not", "dmesg")
    says(found(system, "locked memory", UNLOCKED), "problem", "the kernel does not", "memory.max")


@pytest.mark.parametrize("memlock", [0, 65536, 8 << 20])
def test_memlock(machine: Machine, memlock: int) -> None:
    finding = found(machine.system(memlock=memlock), "locked memory", UNLOCKED)
    says(finding, "problem", f"(ENOMEM): RLIMIT_MEMLOCK is {memlock >> 10} kB", "LimitMEMLOCK=45M")


@pytest.mark.parametrize(
    ("runtime_us", "verdict"), [("-1", "ok"), ("950000", "ok"), ("200000", "note"), ("0", "problem")]
)
def test_throttling(machine: Machine, runtime_us: str, verdict: str) -> None:
    system = machine.system({"proc/sys/kernel/sched_rt_runtime_us": runtime_us})
    finding = found(system, "real-time throttling", REFUSED if runtime_us == "0" else TRIED)
    assert finding.verdict == verdict
    if verdict != "ok":
        assert finding.remedy == "as root `sysctl -w kernel.sched_rt_runtime_us=950000`"
    if runtime_us == "0":
        assert found(system, "real-time priority", REFUSED).remedy == finding.remedy


def test_one_cpu(machine: Machine) -> None:
    system = machine.system({"sys/devices/system/cpu/isolated": "\n"}, cpus="0")
    says(found(system, "CPUs", replace(TRIED, cpu=-1)), "note", "1 allowed (0)", "AllowedCPUs=")
    assert found(system, "isolated CPU").verdict == "ok"


def test_isolated_cpus(machine: Machine) -> None:
    assert found(machine.system(), "isolated CPU").found == "3, no timer tick; use it with `cpu: 3`"
    says(
        found(machine.system(cpus="0-2"), "isolated CPU"),
        "note",
        "not among",
        "`taskset -c 0-3 hil serve ...`",
    )
    none = machine.system({"sys/devices/system/cpu/isolated": "\n"})
    says(found(none, "isolated CPU"), "note", "none", "`isolcpus=3 nohz_full=3`")


def test_a_cpu_that_is_refused(machine: Machine) -> None:
    says(
        found(machine.system(), "CPUs", replace(TRIED, pin_errno=EPERM)), "note", "pinning to 3", "taskset -p"
    )


@pytest.mark.parametrize(
    ("quota", "verdict", "share"), [("50000 100000", "problem", "0.50"), ("250000 100000", "note", "2.50")]
)
def test_a_quota_of_cpu_time(machine: Machine, quota: str, verdict: str, share: str) -> None:
    finding = found(machine.system({"sys/fs/cgroup/user.slice/cpu.max": quota}), "CPU quota")
    says(finding, verdict, f"{share} CPUs (/sys/fs/cgroup/user.slice/cpu.max)", "CPUQuota=")


def test_a_quota_of_version_1_on_a_group_above(machine: Machine) -> None:
    where = "sys/fs/cgroup/cpu,cpuacct"
    system = machine.system(
        {
            "proc/self/cgroup": "4:cpu,cpuacct:/docker/1\n",
            "proc/self/mountinfo": V1_MOUNT,
            f"{where}/docker/cpu.cfs_quota_us": "20000\n",
            f"{where}/docker/cpu.cfs_period_us": "100000\n",
            f"{where}/docker/1/cpu.cfs_quota_us": "-1\n",
            f"{where}/docker/1/cpu.cfs_period_us": "100000\n",
        }
    )
    says(found(system, "CPU quota"), "problem", "0.20 CPUs (/sys/fs/cgroup/cpu,cpuacct/docker/", "--cpus")
    assert found(system, "container").found == "docker"


@pytest.mark.parametrize(
    ("version", "files", "model"),
    [
        (
            "#1 SMP PREEMPT_DYNAMIC",
            {"sys/kernel/debug/sched/preempt": "none voluntary (full) lazy\n"},
            "full",
        ),
        ("#1 SMP PREEMPT_DYNAMIC", {"proc/cmdline": "preempt=lazy"}, "lazy"),
        (
            "#1 SMP PREEMPT_DYNAMIC",
            {"boot/config-6.12.9-rt-amd64": "CONFIG_PREEMPT_VOLUNTARY=y\n"},
            "voluntary",
        ),
        ("#1 SMP PREEMPT_DYNAMIC", {}, "not known"),
        ("#1 SMP PREEMPT", {}, "full"),
        ("#1 SMP PREEMPT", {"boot/config-6.12.9-rt-amd64": "CONFIG_PREEMPT=y\n"}, "full"),
    ],
)
def test_kernels_without_real_time(machine: Machine, version: str, files: dict[str, str], model: str) -> None:
    finding = found(machine.system({"sys/kernel/realtime": None, "proc/version": version, **files}), "kernel")
    says(finding, "note", f"Linux 6.12.9-rt-amd64, preemption: {model}", "linux-image-rt-amd64")
    assert ("preempt=full" in finding.remedy) == (model != "full")


def test_a_governor(machine: Machine) -> None:
    system = machine.system({"sys/devices/system/cpu/cpu2/cpufreq/scaling_governor": "powersave\n"})
    says(
        found(system, "CPU frequency"),
        "note",
        "performance, powersave",
        "cpupower frequency-set -g performance",
    )


@pytest.mark.parametrize(("source", "verdict"), [("hpet", "note"), ("refined-jiffies", "problem")])
def test_a_slow_clock(machine: Machine, source: str, verdict: str) -> None:
    file = "sys/devices/system/clocksource/clocksource0/current_clocksource"
    says(found(machine.system({file: source}), "clock source"), verdict, source, "tsc=reliable")


@pytest.mark.parametrize(
    ("files", "name", "kind"),
    [
        ({".dockerenv": ""}, "container", "Docker"),
        ({"run/.containerenv": ""}, "container", "Podman"),
        ({"run/systemd/container": "systemd-nspawn\n"}, "container", "systemd-nspawn"),
        ({"proc/self/cgroup": "0::/kubepods.slice/pod1\n"}, "container", "kubepods"),
        ({"proc/cpuinfo": "flags\t: fpu hypervisor\n"}, "virtual machine", "virtual machine"),
        ({"sys/class/dmi/id/sys_vendor": "QEMU\n"}, "virtual machine", "QEMU"),
        ({"sys/hypervisor/type": "xen\n"}, "virtual machine", "xen"),
        ({"proc/version": "Linux version 5.15-microsoft-standard-WSL2\n"}, "virtual machine", "WSL"),
    ],
)
def test_containers_and_virtual_machines(
    machine: Machine, files: dict[str, str | bytes | None], name: str, kind: str
) -> None:
    says(found(machine.system(files), name), "note", kind, "")


def test_ptys(machine: Machine) -> None:
    full = machine.system({"proc/sys/kernel/pty/nr": "4090\n"})
    assert found(full, "ptys", devices=6).verdict == "ok"
    says(found(full, "ptys", devices=7), "problem", "4090 of 4096 in use", "kernel.pty.max=4103")
    in_container = machine.system({"proc/sys/kernel/pty/nr": "3070\n", ".dockerenv": ""})
    assert found(in_container, "ptys", devices=3).verdict == "problem"
    says(found(full, "ptys", replace(TRIED, pty_errno=ENOSPC)), "problem", "ENOSPC", "kernel.pty.max")


def test_inotify(machine: Machine) -> None:
    finding = found(machine.system(), "inotify", replace(TRIED, inotify_errno=EMFILE))
    says(finding, "problem", "(EMFILE); 128 for each user", "fs.inotify.max_user_instances=512")


def test_descriptors(machine: Machine) -> None:
    assert found(machine.system(nofile=48), "RLIMIT_NOFILE", devices=8).verdict == "ok"
    says(found(machine.system(nofile=47), "RLIMIT_NOFILE", devices=8), "problem", "47", "LimitNOFILE=1024")
    says(found(machine.system(), "RLIMIT_NOFILE", devices=400), "problem", "1024", "LimitNOFILE=1224")


def test_folders(machine: Machine) -> None:
    tried = replace(
        TRIED, runtime_failure="it belongs to another user", state_failure="/home: Permission denied"
    )
    system = machine.system()
    says(found(system, "runtime directory", tried), "problem", "another user", "--runtime-dir")
    says(found(system, "state directory", tried), "problem", "/home: Permission denied", "--state-dir")


def test_a_core_that_does_not_start(machine: Machine) -> None:
    tried = replace(TRIED, core_failure="no memory or no file descriptor for it")
    says(
        found(machine.system(), "real-time priority", tried), "problem", "no file descriptor", "RLIMIT_NOFILE"
    )
    assert found(machine.system(), "locked memory", tried).verdict == "note"


def test_serve_gives_the_same_remedies(machine: Machine) -> None:
    system = machine.system(rtprio=0, memlock=0)
    tried = replace(TRIED, fifo_errno=EPERM, lock_errno=EPERM, pin_errno=EACCES)
    stats = {"fifo_errno": EPERM, "lock_errno": EPERM, "pin_errno": EACCES}
    line = grant(stats, 80, 3, system).line()  # type: ignore[typeddict-item]
    assert line.startswith("rt: degraded (no real-time priority and no CPU 3 and no locked memory): ")
    for name in ("real-time priority", "locked memory", "CPUs"):
        assert found(system, name, tried).remedy in line


def test_ranges() -> None:
    assert ranges((0, 1, 2, 5, 7, 8)) == "0-2,5,7-8"
    assert ranges(()) == "not known"


def test_devpts_and_its_mount(machine: Machine) -> None:
    line = "30 29 0:22 / /dev/pts rw,relatime - devpts devpts rw,gid=5,mode=620,ptmxmode=000,max={}\n"
    system = machine.system({"proc/self/mountinfo": V2_MOUNT + line.format(4)})
    assert found(system, "ptys", devices=4).verdict == "ok"
    says(found(system, "ptys", devices=5), "problem", "4 at most", "`mount -o remount,max=4101 /dev/pts`")
    full = replace(TRIED, pty_errno=ENOSPC)
    says(
        found(system, "ptys", full), "problem", "(ENOSPC): 4 at most", "`mount -o remount,max=4104 /dev/pts`"
    )
    closed = replace(TRIED, pty_errno=EACCES)
    says(found(system, "ptys", closed), "problem", "EACCES", "`mount -o remount,gid=5,mode=620,ptmxmode=666")
    nothing = found(machine.system(), "ptys", replace(TRIED, pty_errno=ENOENT))
    says(nothing, "problem", "ENOENT", "`mount -t devpts -o gid=5,mode=620,ptmxmode=666 devpts /dev/pts`")


@pytest.mark.parametrize(
    ("groups", "capabilities", "verdict"),
    [("4 24 1000", 0, "note"), ("4 20 1000", 0, "ok"), ("", 1 << 1, "ok"), ("", 0, "note")],
)
def test_the_group_of_serial_ports(machine: Machine, groups: str, capabilities: int, verdict: str) -> None:
    files = {"etc/group": "root:x:0:\ndialout:x:20:other\n"}
    status = STATUS.format(capabilities=capabilities, seccomp=0, cpus="0-3")
    own = {"proc/self/status": f"Gid:\t1000\t1000\t1000\t1000\nGroups:\t{groups} \nNStgid:\t7\n{status}"}
    finding = found(machine.system({**files, **own}), "group dialout")
    assert finding.verdict == verdict
    if verdict == "note":
        says(finding, "note", "not a member", "`usermod -aG dialout USER`")


def test_a_priority_below_the_wanted_one_is_said(machine: Machine) -> None:
    stats = {"fifo_errno": 0, "lock_errno": 0, "pin_errno": 0}
    given = grant(stats, 10, 3, machine.system(rtprio=10))  # type: ignore[typeddict-item]
    assert (given.state, given.missing) == ("ok", {})
    assert "SCHED_FIFO 10" in given.line()
    assert "80 was wanted: LimitRTPRIO=80" in given.line()
