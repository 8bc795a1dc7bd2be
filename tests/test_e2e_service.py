"""The daemon as a service: what it tells systemd, when its watchdog bites, what signals and exits mean."""

import os
import re
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from e2e_support import HIL, PATIENCE_S, Place, Server, config, until
from service_manager import Manager

WATCHDOG_S = 0.4

HANGING = """
import asyncio, os, signal, sys, time
from pathlib import Path
from hil.compose import find_catalogue
from hil.config import parse
from hil.daemon import Daemon
from hil.host.notify import Notifier

path, runtime, state = map(Path, sys.argv[1:4])
bench = parse(path.read_text(), str(path), find_catalogue())
daemon = Daemon(bench, config_folder=path.parent, runtime_base=runtime, state_base=state,
                notifier=Notifier(os.environ, os.getpid()))

def hang_loop(core):
    before = core.native.rt_stats()["ticks"]
    time.sleep(3 * float(sys.argv[4]))
    print("ticks meanwhile:", core.native.rt_stats()["ticks"] - before, flush=True)

def started(serving):
    core = serving.live.sim.core
    loop = asyncio.get_running_loop()
    loop.add_signal_handler(signal.SIGUSR1, hang_loop, core)
    loop.add_signal_handler(signal.SIGUSR2, core.native.rt_stop)
    print("it serves", flush=True)

asyncio.run(daemon.run(started))
"""


@pytest.fixture
def manager(place: Place) -> Iterator[Manager]:
    made = Manager(place.folder, WATCHDOG_S)
    yield made
    made.close()


def hanging(place: Place, manager: Manager) -> Server:
    """A daemon whose loop hangs for a while after SIGUSR1, and whose core's thread ends after SIGUSR2."""
    path = place.write(config(), "t.yaml")
    where = (str(path), str(place.runtime), str(place.state), str(WATCHDOG_S))
    return place.script(HANGING, *where, env=manager.env).started()


def test_from_start_to_end(place: Place, manager: Manager) -> None:
    server = place.serve(config(devices={"m1": {}, "m2": {}}), env=manager.env)
    first = manager.wait("READY=1")
    assert manager.said[0] == first
    status = re.search(r"STATUS=bench t; 2 devices; 0 clients; real time (ok|late \(.*\)); \d+ miss", first)
    assert status, first
    with server.client("m2"):
        manager.wait("; 2 devices; 1 client; ")
    server.stop()
    manager.wait("STOPPING=1")
    assert sum("READY=1" in message for message in manager.said) == 1
    assert manager.said[-1].startswith("STOPPING=1")


def test_a_failed_device_stands_in_the_status(place: Place, manager: Manager) -> None:
    server = place.serve(config(devices={"m1": {}, "m2": {}}), env=manager.env)
    server.ask("inject", fault="node_brown_out", target="m2", parameters={})
    manager.wait("2 devices, 1 failed (m2);")
    server.stop()


def test_pings_come_in_time(place: Place, manager: Manager) -> None:
    server = place.serve(config(), env=manager.env)
    manager.wait("READY=1")
    assert manager.pings_in(5 * WATCHDOG_S) >= 10
    server.stop()


def test_none_for_another_process(place: Place, manager: Manager) -> None:
    server = place.serve(config(), env=manager.env | {"WATCHDOG_PID": "1"})
    manager.wait("READY=1")
    assert manager.pings_in(2 * WATCHDOG_S) == 0
    server.stop()


def test_a_hung_loop_pings_no_more(place: Place, manager: Manager) -> None:
    server = hanging(place, manager)
    manager.next_ping()
    server.process.send_signal(signal.SIGUSR1)
    silent_s = 0.0
    while "ticks meanwhile" not in server.output:
        silent_s = max(silent_s, manager.next_ping())
    assert silent_s > 2 * WATCHDOG_S
    ticks = re.search(r"ticks meanwhile: (\d+)", server.output)
    assert ticks
    assert int(ticks[1]) > 100  # the core went on, and that is not enough
    manager.next_ping()
    server.stop()


def test_a_hung_core_pings_no_more(place: Place, manager: Manager) -> None:
    server = hanging(place, manager)
    manager.next_ping()
    server.process.send_signal(signal.SIGUSR2)
    until(lambda: not manager.pings_in(WATCHDOG_S), "silence")
    assert manager.pings_in(3 * WATCHDOG_S) == 0
    assert server.ask("list")["bench"] == "t"  # the loop went on, and that is not enough
    server.process.kill()


def test_a_stopped_process_pings_no_more(place: Place, manager: Manager) -> None:
    server = place.serve(config(), env=manager.env)
    manager.next_ping()
    server.process.send_signal(signal.SIGSTOP)
    until(lambda: not manager.pings_in(WATCHDOG_S), "silence")
    server.process.send_signal(signal.SIGCONT)
    manager.next_ping()
    server.stop()


def test_hangup_reloads_a_service(place: Place, manager: Manager) -> None:
    server = place.serve(config(), env=manager.env, start_new_session=True)
    manager.wait("READY=1")
    place.write(config(devices={"m1": {}, "m2": {}}), "t.yaml")
    server.process.send_signal(signal.SIGHUP)
    until(lambda: len(server.ask("list")["devices"]) == 2, "the second device")
    until(lambda: (manager.hear(), sum("READY=1" in m for m in manager.said))[1] == 2, "ready again")
    states = [m for m in manager.said if "READY=1" in m or "RELOADING=1" in m]
    assert [m.partition("=")[0] for m in states] == ["READY", "RELOADING", "READY"]
    at_us = re.search(r"^MONOTONIC_USEC=(\d+)$", states[1], re.M)
    assert at_us
    assert 0 < int(at_us[1]) / 1e6 < float(Path("/proc/uptime").read_text().split()[0]) + 1
    assert "; 2 devices;" in states[2]
    server.stop()


ON_A_TERMINAL = """
import fcntl, os, sys, termios
os.setsid()
master, slave = os.openpty()
os.set_inheritable(master, True)
fcntl.ioctl(slave, termios.TIOCSCTTY, 0)
os.execv(sys.argv[1], sys.argv[1:])
"""


def test_hangup_ends_what_a_terminal_controls(place: Place) -> None:
    server = place.serve(config(), prefix=[sys.executable, "-c", ON_A_TERMINAL])
    assert "Aborted" not in server.stop(signal.SIGHUP)
    assert not place.runtime.exists()


def test_a_wrong_configuration_in_the_journal(place: Place, manager: Manager) -> None:
    path = place.write(config(spede=1), "t.yaml")
    errors = place.folder / "errors"
    with errors.open("w") as file:
        stat = os.fstat(file.fileno())
        env = manager.env | {"JOURNAL_STREAM": f"{stat.st_dev}:{stat.st_ino}"}
        command = [HIL, "serve", str(path), *place.folders()]
        done = subprocess.run(command, stderr=file, env=env, timeout=PATIENCE_S, check=False)
    assert done.returncode == 2
    lines = errors.read_text().splitlines()
    assert lines
    assert all(line.startswith("<3>") for line in lines)
    assert f"{path}:1:" in lines[1]
    assert manager.wait("STATUS=") == f"STATUS={path} has problems; the log lists them"


def test_the_directories_of_a_unit(place: Place, manager: Manager) -> None:
    """Directories are as hil@t.service has them: each is made for this bench."""
    runtime, state, logs = (place.folder / name / "t" for name in ("run", "state", "logs"))
    for folder in (runtime, state, logs):
        folder.mkdir(parents=True, mode=0o755)
    path = place.write(config(), "t.yaml")
    env = manager.env | {
        "RUNTIME_DIRECTORY": str(runtime),
        "STATE_DIRECTORY": str(state),
        "LOGS_DIRECTORY": str(logs),
    }
    with (place.folder / "out").open("w") as out:
        command = [HIL, "serve", str(path), "--log", "a.log"]
        server = subprocess.Popen(command, stdout=out, stderr=out, env=env)
    try:
        manager.wait("READY=1")
        assert sorted(p.name for p in runtime.iterdir()) == ["control.sock", "m1"]
        asked = subprocess.run(
            [HIL, "reload"], env=env, capture_output=True, text=True, timeout=PATIENCE_S, check=False
        )
        assert (asked.returncode, asked.stdout) == (0, "1 device went on\n"), asked.stderr
        assert (logs / "a.log").stat().st_size > 0
    finally:
        server.terminate()
        assert server.wait(PATIENCE_S) == 0


def test_a_hang_up_while_it_starts_is_a_reload_when_it_has_started(place: Place) -> None:
    server = place.launch(config(), start_new_session=True)

    def waits() -> bool:
        status = Path(f"/proc/{server.pid}/status").read_text()
        return bool(int(status.partition("SigBlk:")[2].split()[0], 16) & 1 << (signal.SIGHUP - 1))

    until(waits, "the program's begin")
    server.process.send_signal(signal.SIGHUP)
    server.started()
    until(lambda: "reloaded: 1 went on" in server.output, "the reload")
    server.stop()
