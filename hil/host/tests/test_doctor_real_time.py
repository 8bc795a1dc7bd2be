"""Findings of ``hil doctor`` about real time: priorities, budgets, locked memory, CPUs, kernels."""

import gzip
from dataclasses import replace
from errno import EPERM

import pytest
from doctor_machine import (
    CAP_SYS_NICE,
    REFUSED,
    TRIED,
    UNLOCKED,
    V1_MOUNT,
    Machine,
    found,
    says,
)

from hil.host.doctor import Diagnosis
from hil.host.real_time import grant


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


def test_a_priority_below_the_wanted_one_is_said(machine: Machine) -> None:
    stats = {"fifo_errno": 0, "lock_errno": 0, "pin_errno": 0}
    given = grant(stats, 10, 3, machine.system(rtprio=10))  # type: ignore[typeddict-item]
    assert (given.state, given.missing) == ("ok", {})
    assert "SCHED_FIFO 10" in given.line()
    assert "80 was wanted: LimitRTPRIO=80" in given.line()
