"""The container with the bench ``lab`` in it, and its clients."""

import json
import os
import subprocess
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
from container import Container, until
from debian import HIL_PYTHON
from frozen_thread import host_pid

from hil.net.control_client import ControlError, ask

UNIT = "hil@lab.service"
LAB = """\
bench: lab
speed: 5
devices:
  m1: {profile: mechaduino, flash: {table: identity}}
  m2: {profile: mechaduino, flash: {table: identity}, port: {kind: tcp, listen: 7001}}
  m3: {profile: mechaduino, flash: {table: identity}, port: {kind: rfc2217, listen: 7002}}
  s1: {profile: sac}
bridges:
  zenoh: {}
"""
READY_NS = 5_000_000_000  # a Mechaduino answers 4 s after power-up, of simulated time
BUSY = 0.3
"""Share of the machine's time that others use, above which nothing measured says anything about the
service."""
QUIET_S = 60.0


class Lab:
    """The container, and the bench ``lab`` in it."""

    def __init__(self, container: Container) -> None:
        self.container = container
        self.run = container.run

    def write(self, path: str, text: str) -> None:
        self.container.path(path).write_text(text)

    def show(self, what: str, unit: str = UNIT) -> str:
        return self.run("systemctl", "show", "--value", "-p", what, unit).strip()

    def pid(self) -> int:
        """Process number of the daemon on the host; 0 while there is none."""
        inner = int(self.show("MainPID"))
        return host_pid(self.container.leader, inner) if inner else 0

    def ask(self, verb: str, bench: str = "lab") -> dict[str, Any]:
        answer: dict[str, Any] = ask(self.container.path(f"/run/hil/{bench}/control.sock"), verb)
        return answer

    def answers(self) -> bool:
        try:
            return bool(self.ask("status"))
        except (OSError, ControlError):
            return False

    def started(self) -> "Lab":
        """The bench as it is in LAB, freshly started."""
        self.write("/etc/hil/lab.yaml", LAB)
        self.run("systemctl", "reset-failed", check=False)
        self.run("systemctl", "restart", UNIT)
        return self

    @contextmanager
    def with_drop_in(self, name: str) -> Iterator[None]:
        """Restart the service with this drop-in for the block."""
        folder = "/etc/systemd/system/hil@.service.d"
        self.run("mkdir", "-p", folder)
        self.run("ln", "-s", f"/usr/local/share/hil/systemd/{name}.conf", folder)
        try:
            self.run("systemctl", "daemon-reload")
            self.run("systemctl", "restart", UNIT)
            yield
        finally:
            self.run("rm", "-r", folder)
            self.run("systemctl", "daemon-reload")

    def ready(self) -> "Lab":
        """Wait until the boards are past their start-up."""
        until(lambda: self.answers() and self.ask("status")["sim_ns"] > READY_NS, "the boards", every_s=0.1)
        return self

    def log(self) -> str:
        """The last lines of the journal about it."""
        return self.run("journalctl", "-u", UNIT, "-n", "20", "--no-pager")

    def hil(self, *words: str, check: bool = True) -> str:
        return self.run("hil", *words, check=check)

    def back_after(self, pid: int, since: float, reap: Callable[[], None] = lambda: None) -> float:
        """Seconds until the daemon that succeeds ``pid`` has its port m1 and answers."""

        def ended() -> bool:
            reap()
            return not Path(f"/proc/{pid}").exists()

        port = self.container.path("/run/hil/lab/m1")
        until(ended, "the end of the old daemon")
        until(lambda: os.path.lexists(port) and self.answers(), "its successor")
        return time.monotonic() - since


class Client:
    """A program in the container that has a port open."""

    def __init__(self, lab: Lab, url: str, user: str = "tester") -> None:
        self._process = subprocess.Popen(
            lab.container.command(HIL_PYTHON, "/usr/local/lib/inside.py", url, user=user),
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
        )
        self.opened = self._line()

    def _line(self) -> Any:
        assert self._process.stdout
        return json.loads(self._process.stdout.readline() or "null")

    def ask(self, sent: str, awaited: str) -> str:
        """Send a text, and return what came, which contains what was awaited."""
        assert self._process.stdin
        self._process.stdin.write(json.dumps([sent, awaited]).encode() + b"\n")
        self._process.stdin.flush()
        got: str = self._line()
        assert awaited in got, got
        return got

    def __enter__(self) -> "Client":
        assert self.opened == "open", self.opened
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        assert self._process.stdin
        assert self._process.stdout
        self._process.stdin.close()
        self._process.stdout.close()
        assert self._process.wait(20) == 0


def busy() -> float:
    """Share of all CPUs' time that was used in half a second."""

    def jiffies() -> list[int]:
        return [int(word) for word in Path("/proc/stat").read_text().split("\n", 1)[0].split()[1:9]]

    before = jiffies()
    time.sleep(0.5)
    spent = [after - each for after, each in zip(jiffies(), before, strict=True)]
    return 1 - (spent[3] + spent[4]) / max(sum(spent), 1)  # idle and waiting for disks, proc(5)


def wait_for_quiet() -> None:
    deadline = time.monotonic() + QUIET_S
    while (share := busy()) > BUSY:
        if time.monotonic() > deadline:
            pytest.skip(f"this machine is busy with other things ({share:.0%}): times say nothing")
