"""The core's real-time thread in the running daemon: its counters, and what it was not granted."""

import ctypes
import os
import re
import select
import signal
import subprocess
import sys
import time
from typing import Any

import pytest
from e2e_support import AS_STRANGER, STRANGER_UID, Place, Server, config, needs_stranger, until

SPINNER = """
import ctypes, os, sys, time
cpu, seconds = int(sys.argv[1]), float(sys.argv[2])
os.sched_setaffinity(0, {cpu})
os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(99))
end = time.monotonic() + seconds
while time.monotonic() < end:
    pass
"""


def adds_up(status: dict[str, Any]) -> bool:
    return bool(status["ticks"] + status["missed"] == status["elapsed_ns"] // status["period_ns"])


def own_cpu(server: Server) -> int | None:
    found = re.search(r"SCHED_FIFO \d+, CPU (\d+)", server.output)
    return int(found[1]) if found else None


def check_often(server: Server, seconds: float) -> dict[str, Any]:
    """ticks + missed = floor(elapsed / period), every time it is asked; the last answer."""
    end = time.monotonic() + seconds
    asked = 0
    while time.monotonic() < end or asked < 10:
        status: dict[str, Any] = server.ask("status")
        assert adds_up(status), status
        asked += 1
    return status


@pytest.mark.parametrize("rate_hz", [100, 1000, 6500])
def test_ticks_and_missed_add_up(place: Place, rate_hz: int) -> None:
    server = place.serve(config(speed=1, rate_hz=rate_hz))
    status = check_often(server, 0.5)
    assert status["ticks"] > 0
    assert sum(status["wake_latency"]) == status["ticks"]


def test_a_stopped_process_misses_its_ticks_and_catches_up(place: Place) -> None:
    server = place.serve(config(speed=10))
    with server.client() as client:
        before = check_often(server, 0.1)
        for _ in range(2):
            server.process.send_signal(signal.SIGSTOP)
            select.select([], [], [], 0.5)
            server.process.send_signal(signal.SIGCONT)
            after = check_often(server, 0.2)
            assert after["missed"] >= before["missed"] + 450
            before = after
        server.ready()
        client.ask(b"p", b"raw encoder: ")


@pytest.mark.skipif(os.getuid() != 0, reason="only root may run a program at a real-time priority")
def test_a_blocked_cpu_is_counted(place: Place) -> None:
    server = place.serve(config(speed=1))
    cpu = own_cpu(server)
    if cpu is None:
        pytest.skip("the core has no real-time priority on a CPU of its own here")
    before = check_often(server, 0.1)
    for _ in range(2):
        subprocess.run([sys.executable, "-c", SPINNER, str(cpu), "0.1"], timeout=30, check=True)
        after = check_often(server, 0.1)
        assert after["missed"] >= before["missed"] + 50
        before = after


def stranger(place: Place) -> None:
    """The directories that a user without rights needs."""
    for folder in (place.runtime, place.state):
        folder.mkdir(mode=0o700, exist_ok=True)
        os.chown(folder, STRANGER_UID, STRANGER_UID)


def limited(**limits: int) -> tuple[str, ...]:
    return (
        *("prlimit", *(f"--{name}={value}:{value}" for name, value in limits.items()), "--"),
        *AS_STRANGER,
    )


@needs_stranger
def test_without_permission_it_goes_on_and_says_how_to_grant_it(place: Place) -> None:
    stranger(place)
    prefix = limited(rtprio=0)
    server = place.serve(config(), prefix=prefix).ready()
    (line,) = [line for line in server.output.splitlines() if "rt: " in line]
    assert "rt: late (no real-time priority" in line
    assert line.endswith(": answers are right, and late when this computer is busy; `hil doctor` tells more")
    status = server.ask("status")
    assert status["rt"] == "late"
    assert not [each for each in status["health"]["problems"] if each["kind"] in ("real_time", "wakes")]
    without_others = re.compile(r"; shares CPU[^):]*")
    assert without_others.sub("", status["rt_line"]) in without_others.sub("", line)
    assert "rt: late" in place.cli("status")
    check_often(server, 0.2)
    with server.client() as client:
        client.ask(b"p")
    server.stop()

    said = place.launch(config(), "--require-rt", prefix=prefix).refused()
    assert "rt: late (no real-time priority" in said
    assert "RLIMIT_RTPRIO is 0, at most 0: LimitRTPRIO=80, or `rtprio 80` for you in /etc/security" in said
    assert not (place.runtime / "t").exists()


@needs_stranger
def test_without_locked_memory_it_says_so(place: Place) -> None:
    stranger(place)
    cpu = max(os.sched_getaffinity(0))
    server = place.serve(config(cpu=cpu), prefix=limited(rtprio=0, memlock=0))
    assert "rt: late (no real-time priority and no locked memory" in server.output
    assert "RLIMIT_MEMLOCK is 0 kB: LimitMEMLOCK=45M, or `memlock 46080` for you in /etc/" in server.output
    server.stop()


@needs_stranger
def test_a_user_who_was_granted_it_gets_it(place: Place) -> None:
    stranger(place)
    server = place.launch(config(), "--require-rt", prefix=limited(rtprio=50, memlock=256 * 1024 * 1024))
    until(lambda: server.serves or server.process.poll() is not None, "the start")
    if "failed to set the RTPRIO" in server.output:
        pytest.skip("this container may not raise the limit of real-time priorities")
    assert "rt: ok (SCHED_FIFO 50" in server.output
    server.stop()


def test_only_the_core_runs_at_a_real_time_priority(place: Place) -> None:
    """The event loop and the store must never keep a CPU from others."""
    server = place.serve(config())
    libc = ctypes.CDLL(None, use_errno=True)
    threads = [int(name) for name in os.listdir(f"/proc/{server.pid}/task")]
    realtime = [thread for thread in threads if libc.sched_getscheduler(thread) != os.SCHED_OTHER]
    assert server.pid not in realtime
    assert len(realtime) == (own_cpu(server) is not None)
