"""Findings of ``hil doctor`` as a whole, and about what is not real time."""

from dataclasses import replace
from errno import EACCES, EMFILE, ENOENT, ENOSPC, EPERM
from pathlib import Path

import pytest
from doctor_machine import REFUSED, STATUS, TRIED, V2_MOUNT, Machine, found, says

from hil.host.doctor import WORST_FIRST, healthy, judge, ranges
from hil.host.real_time import grant
from hil.host.system import read_system


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
    assert line.startswith("rt: late (no real-time priority and no CPU 3 and no locked memory): ")
    for name in ("real-time priority", "locked memory", "CPUs"):
        assert found(system, name, tried).remedy in line
    line = grant(stats, 80, 3, system, asked=False).line()  # type: ignore[typeddict-item]
    assert line.startswith(
        "rt: late (no real-time priority and no CPU 3 and no locked memory): answers are right"
    )


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
