"""Refusals that Linux can make to a bench, made for real: ``hil doctor`` says so from outside, ``hil status``
of a bench that runs all the same, and each has the line that mends it."""

import json
import os
import resource
import shutil
import signal
import socket
import subprocess
from collections.abc import Callable
from functools import partial
from typing import Any

import pytest
from denials import CALLS, install_filter, limited, needs_calls
from e2e_support import AS_STRANGER, HIL, PATIENCE_S, Place, config, needs_stranger, until

from hil.firmware.nvm import Content, encode

needs_mounts = pytest.mark.skipif(
    os.getuid() != 0 or not shutil.which("unshare"),
    reason="only root with unshare can mount a /dev/pts",
)
Findings = dict[str, dict[str, str]]
OWN_PTS = ("unshare", "-m", "sh", "-c")
MOUNT = "mount -t devpts -o newinstance,{} devpts /dev/pts && mount --bind /dev/pts/ptmx /dev/ptmx"


def doctor(place: Place, prefix: tuple[str, ...] = (), *options: str, **popen: Any) -> Findings:
    """Findings by name; of several with one name the first. A busy machine is no finding."""
    command = [*prefix, HIL, "doctor", "--json", *place.folders(), *options]
    return findings(subprocess.run(command, capture_output=True, timeout=PATIENCE_S, check=False, **popen))


def findings(done: "subprocess.CompletedProcess[bytes]") -> Findings:
    assert b"Traceback" not in done.stderr, done.stderr
    rows = json.loads(done.stdout)
    assert done.returncode == any(row["verdict"] == "problem" for row in rows)
    found: Findings = {}
    for row in sorted(rows, key=lambda row: is_of_load(row["found"])):
        found.setdefault(row["name"], {**row, "verdict": "ok"} if is_of_load(row["found"]) else row)
    return found


def is_of_load(found: str) -> bool:
    """True if what was found holds for any bench on a machine that has too much to do, or has many."""
    return (
        "shares CPU" in found or "of the wakes of the last minute" in found or "answers were held up" in found
    )


def status(place: Place, **launch: Any) -> dict[str, Any]:
    """Status of a bench that asks for real time under a denial; ``hil status`` shows each remedy, too."""
    server = place.serve(config(cpu=max(os.sched_getaffinity(0))), **launch)
    answer: dict[str, Any] = server.ask("status")
    shown = place.cli("status")
    for problem in answer["health"]["problems"]:  # those of load come and go
        assert is_of_load(problem["what"]) or problem["remedy"] in shown, "for people, too"
    server.stop()
    return answer


def remedy_of(answer: dict[str, Any], what: str) -> str:
    (found,) = [each["remedy"] for each in answer["health"]["problems"] if each["what"] == what]
    assert answer["health"]["state"] == "late"
    return str(found)


def as_stranger(preexec: Callable[[], None]) -> dict[str, Any]:
    return {"prefix": AS_STRANGER, "preexec_fn": preexec}


# ---- 1 to 3: real-time priority ----


@needs_stranger
def test_no_rtprio(open_place: Place) -> None:
    how = as_stranger(limited(resource.RLIMIT_RTPRIO, 0))
    finding = doctor(open_place, **how)["real-time priority"]
    assert (finding["verdict"], finding["remedy"][:14]) == ("problem", "LimitRTPRIO=80")
    answer = status(open_place, **how)
    assert (answer["rt"], remedy_of(answer, "no real-time priority")) == (
        "late",
        f"RLIMIT_RTPRIO is 0, at most 0: {finding['remedy']}",
    )


@needs_stranger
def test_a_lower_rtprio_than_wanted(open_place: Place) -> None:
    how = as_stranger(limited(resource.RLIMIT_RTPRIO, 10))
    finding = doctor(open_place, **how)["RLIMIT_RTPRIO"]
    assert (finding["verdict"], finding["found"]) == ("note", "10, at most 10")
    line = status(open_place, **how)["rt_line"]
    if "locked" in line:
        assert "SCHED_FIFO 10" in line
        assert f"80 was wanted: {finding['remedy']}" in line


@needs_calls
def test_realtime_that_seccomp_refuses(place: Place) -> None:
    """RestrictRealtime=yes of a unit."""
    refuse = partial(install_filter, CALLS["sched_setscheduler"])
    finding = doctor(place, preexec_fn=refuse)["real-time priority"]
    assert finding["verdict"] == "problem"
    assert "no RestrictRealtime=yes" in finding["remedy"]
    if "seccomp" in finding["found"]:
        assert finding["remedy"] in remedy_of(status(place, preexec_fn=refuse), "no real-time priority")


# ---- 4 and 5: locked memory ----


@needs_stranger
def test_little_memlock(open_place: Place) -> None:
    how = as_stranger(limited(resource.RLIMIT_MEMLOCK, 65536))
    finding = doctor(open_place, **how)["locked memory"]
    assert (finding["verdict"], finding["remedy"][:16]) == ("problem", "LimitMEMLOCK=45M")
    assert finding["remedy"] in remedy_of(status(open_place, **how), "no locked memory")


@needs_calls
def test_mlock_that_seccomp_refuses(place: Place) -> None:
    refuse = partial(install_filter, CALLS["mlock"])
    finding = doctor(place, preexec_fn=refuse)["locked memory"]
    assert finding["verdict"] == "problem"
    if "seccomp" in finding["found"]:
        assert "SystemCallFilter= without mlock" in finding["remedy"]
        assert finding["remedy"] in remedy_of(status(place, preexec_fn=refuse), "no locked memory")


# ---- 6: a CPU ----


@needs_calls
@pytest.mark.skipif(len(os.sched_getaffinity(0)) < 2, reason="where there is one CPU, none is chosen")
def test_a_cpu_that_is_refused(place: Place) -> None:
    refuse = partial(install_filter, CALLS["sched_setaffinity"])
    cpu = max(os.sched_getaffinity(0))
    finding = doctor(place, preexec_fn=refuse)["CPUs"]
    assert (finding["verdict"], "was refused (EPERM)" in finding["found"]) == ("note", True)
    assert finding["remedy"] in remedy_of(status(place, preexec_fn=refuse), f"no CPU {cpu}")


def test_a_cpu_that_is_not_allowed(place: Place) -> None:
    cpu, other = min(os.sched_getaffinity(0)), max(os.sched_getaffinity(0)) + 1
    alone = partial(os.sched_setaffinity, 0, {cpu})
    finding = doctor(place, preexec_fn=alone)["CPUs"]
    assert (finding["verdict"], finding["found"]) == ("note", f"1 allowed ({cpu})")
    assert "taskset" in finding["remedy"]
    said = place.launch(config(cpu=other), preexec_fn=alone).refused()
    assert f"cpu: {other} is not one that this process may use ({cpu})" in said


# ---- 7: groups and ports ----


@needs_stranger
def test_a_user_that_is_not_in_dialout(open_place: Place) -> None:
    finding = doctor(open_place, AS_STRANGER)["group dialout"]
    if finding["found"] == "there is none here":
        pytest.skip("this system has no group dialout")
    assert (finding["verdict"], finding["found"]) == ("note", "not a member")
    assert "`usermod -aG dialout USER`" in finding["remedy"]
    port = {"port": {"kind": "pty", "group": "dialout"}}
    said = open_place.launch(config(devices={"m1": port}), prefix=AS_STRANGER).refused()
    assert "to that group, or set group: null" in said


@needs_stranger
def test_ports_that_refuse_the_user_who_asks(place: Place) -> None:
    """The daemon is somebody else's; its socket and its ports are closed to this user."""
    server = place.serve(config())
    for folder in (place.runtime, place.state):
        folder.chmod(0o755)
    os.chmod(server.control, 0o666)
    refused = doctor(place, AS_STRANGER)["bench t"]
    assert (refused["verdict"], refused["found"][:25]) == ("problem", "1 of its ports refuse you")
    assert "`usermod -aG dialout USER`" in refused["remedy"]
    os.chmod(server.control, 0o600)
    refused = doctor(place, AS_STRANGER)["bench t"]
    assert refused["found"] == "its control socket refuses you: Permission denied"
    server.stop()


# ---- 8: ptys ----


@needs_mounts
def test_few_ptys(place: Place) -> None:
    mount = MOUNT.format("max=1,ptmxmode=666")
    check = subprocess.run([*OWN_PTS, mount], capture_output=True, timeout=PATIENCE_S, check=False)
    if check.returncode:
        pytest.skip(f"no mount of devpts here: {check.stderr.decode().strip()}")
    command = f"{mount} && exec {HIL} doctor --json --runtime-dir {place.runtime} --state-dir {place.state}"
    done = subprocess.run([*OWN_PTS, command], capture_output=True, timeout=PATIENCE_S, check=False)
    finding = findings(done)["ptys"]
    assert finding["verdict"] == "problem"
    assert finding["found"] == "1 at most in this mount of /dev/pts"
    assert finding["remedy"] == "as root `mount -o remount,max=4104 /dev/pts`"


@needs_mounts
@needs_stranger
def test_a_pts_that_nobody_but_root_may_use(open_place: Place) -> None:
    mount = MOUNT.format("ptmxmode=000")
    check = subprocess.run([*OWN_PTS, mount], capture_output=True, timeout=PATIENCE_S, check=False)
    if check.returncode:
        pytest.skip(f"no mount of devpts here: {check.stderr.decode().strip()}")
    setpriv = " ".join(AS_STRANGER)
    folders = " ".join(open_place.folders())
    done = subprocess.run(
        [*OWN_PTS, f"{mount} && exec {setpriv} {HIL} doctor --json {folders}"],
        capture_output=True,
        timeout=PATIENCE_S,
        check=False,
    )
    finding = findings(done)["ptys"]
    assert (finding["verdict"], finding["found"]) == ("problem", "tried, refused (EACCES)")
    assert finding["remedy"] == "as root `mount -o remount,gid=5,mode=620,ptmxmode=666 /dev/pts`"


# ---- 9: folders and what is in them ----


@needs_stranger
def test_folders_that_cannot_be_written(open_place: Place) -> None:
    for folder, name in ((open_place.state, "state directory"), (open_place.runtime, "runtime directory")):
        folder.chmod(0o500)
        finding = doctor(open_place, AS_STRANGER)[name]
        assert (finding["verdict"], "Permission denied" in finding["found"]) == ("problem", True)
        said = open_place.launch(config(), prefix=AS_STRANGER).refused()
        assert f"{name} {folder}/t: " in said
        assert finding["remedy"] in said
        folder.chmod(0o700)


def test_memories_that_a_start_would_not_take(place: Place) -> None:
    folder = place.state / "t"
    folder.mkdir(parents=True)
    good = encode(Content("mechaduino", 1, {}))
    (folder / "m1.nvm").write_bytes(good)
    (folder / "m2.nvm").write_bytes(good[:-3])
    found = doctor(place)
    assert "memory t/m1" not in found
    assert found["memory t/m2"]["verdict"] == "problem"
    assert "kept aside" in found["memory t/m2"]["cost"]
    server = place.serve(config(devices={"m1": {}, "m2": {}}))
    assert server.status("m1")["note"] is None
    assert "kept" in server.status("m2")["note"]
    server.stop()


# ---- 10: the daemon itself ----


@pytest.mark.thorough
def test_a_daemon_that_is_gone_or_hangs(place: Place) -> None:
    server = place.serve(config())
    assert doctor(place)["bench t"]["verdict"] == "ok"
    server.process.send_signal(signal.SIGSTOP)
    finding = doctor(place)["bench t"]
    assert (finding["verdict"], finding["found"]) == (
        "problem",
        f"process {server.pid} does not answer within 3 s",
    )
    assert "`systemctl restart hil`" in finding["remedy"]
    server.kill()
    finding = doctor(place)["bench t"]
    assert (finding["verdict"], "was left behind" in finding["found"]) == ("note", True)
    assert "no bench is running here" in place.cli("status", code=1)
    again = place.serve(config())
    assert doctor(place)["bench t"]["verdict"] == "ok", "the remedy"
    again.stop()
    assert "bench t" not in doctor(place)


def test_a_port_whose_name_somebody_removed(place: Place) -> None:
    server = place.serve(config())
    (place.runtime / "t" / "m1").unlink()
    finding = doctor(place)["bench t"]
    assert "the names of 1 of its ports are gone" in finding["found"]
    assert finding["remedy"] == "restart the bench"
    server.stop()


def test_few_file_descriptors(place: Place) -> None:
    """Ask the doctor before the start; of a bench that has used them up, doctor and status."""
    few = limited(resource.RLIMIT_NOFILE, 512)
    finding = doctor(place, (), "--devices", "400", preexec_fn=few)["RLIMIT_NOFILE"]
    assert (finding["verdict"], finding["found"]) == ("problem", "512")
    assert "1224" in finding["remedy"]
    server = place.serve(config(), preexec_fn=limited(resource.RLIMIT_NOFILE, 64))
    clients: list[socket.socket] = []

    def shortage() -> list[dict[str, str]]:
        clients.append(socket.socket(socket.AF_UNIX))
        clients[-1].connect(str(server.control))
        problems = server.ask("status")["health"]["problems"]
        return [problem for problem in problems if problem["kind"] == "descriptors"]

    try:
        found = until(shortage, "the shortage")
        assert found[0]["remedy"] == "restart it with LimitNOFILE=256"
        said = [each for each in doctor_rows(place) if each["remedy"] == found[0]["remedy"]]
        assert [each["verdict"] for each in said] == ["problem"]
    finally:
        for client in clients:
            client.close()
    server.stop()


def doctor_rows(place: Place) -> list[dict[str, str]]:
    command = [HIL, "doctor", "--json", *place.folders()]
    done = subprocess.run(command, capture_output=True, timeout=PATIENCE_S, check=False)
    rows: list[dict[str, str]] = json.loads(done.stdout)
    return rows
